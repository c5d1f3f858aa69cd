//! Errors of recipes and damages.

use std::borrow::Cow;
use std::fmt;

/// The reason why a file cannot be generated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// A text is none of the names of its kind.
    UnknownName {
        /// What the text should name, such as a scene.
        kind: &'static str,
        /// The text.
        name: String,
    },
    /// A text has an unexpected form.
    Syntax {
        /// The expected form.
        expected: Cow<'static, str>,
        /// The text.
        found: String,
    },
    /// A recipe contradicts itself, or the format cannot express it.
    InvalidRecipe(Cow<'static, str>),
    /// A damage does not apply to a file, because the file lacks something.
    NotApplicable(Cow<'static, str>),
    /// A map has more distinct texels than two bytes can index.
    TooManyEntries {
        /// The number of distinct texels.
        texels: usize,
    },
}

/// The result of building or damaging a file.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    pub(crate) fn unknown(kind: &'static str, name: &str) -> Error {
        Error::UnknownName {
            kind,
            name: name.to_owned(),
        }
    }

    pub(crate) fn syntax(expected: impl Into<Cow<'static, str>>, found: &str) -> Error {
        Error::Syntax {
            expected: expected.into(),
            found: found.to_owned(),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::UnknownName { kind, name } => write!(f, "unknown {kind} {name:?}"),
            Error::Syntax { expected, found } => write!(f, "expected {expected}, found {found:?}"),
            Error::InvalidRecipe(reason) | Error::NotApplicable(reason) => f.write_str(reason),
            Error::TooManyEntries { texels } => write!(
                f,
                "the map has {texels} distinct texels, but two bytes can index at most 65536 entries"
            ),
        }
    }
}

impl std::error::Error for Error {}

/// A program prints errors as texts.
impl From<Error> for String {
    fn from(error: Error) -> String {
        error.to_string()
    }
}
