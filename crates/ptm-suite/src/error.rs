//! Errors of the data of the suite, and of responses that are not in the form of the protocol.

use std::borrow::Cow;
use std::fmt;

/// The reason why a text or a response cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// Another error, with the file, line or case in which it was found.
    In {
        /// The place.
        place: String,
        /// The error.
        error: Box<Error>,
    },
    /// A file cannot be read. The text is the reason.
    Unreadable(String),
    /// A YAML text is malformed, or has unexpected fields or values.
    Yaml {
        /// The number of the line, counted from 1.
        line: usize,
        /// The error in the line.
        message: String,
    },
    /// A value has an unexpected form, or contradicts another. The text says what was expected.
    Invalid(Cow<'static, str>),
    /// A name of a format, or a size, is invalid.
    Header(ptm::ParseError),
    /// A recipe or a damage is invalid.
    Recipe(ptm_generate::Error),
}

/// The result of reading the data of the suite, or a response.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Returns this error with the place in which it was found.
    #[must_use]
    pub fn in_place(self, place: impl fmt::Display) -> Error {
        Error::In {
            place: place.to_string(),
            error: Box::new(self),
        }
    }

    pub(crate) fn at_line<T>(line: usize, message: impl Into<String>) -> Result<T> {
        Err(Error::Yaml {
            line,
            message: message.into(),
        })
    }

    pub(crate) fn invalid<T>(message: impl Into<Cow<'static, str>>) -> Result<T> {
        Err(Error::Invalid(message.into()))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::In { place, error } => write!(f, "{place}: {error}"),
            Error::Unreadable(reason) => f.write_str(reason),
            Error::Yaml { line, message } => write!(f, "line {line}: {message}"),
            Error::Invalid(message) => f.write_str(message),
            Error::Header(error) => error.fmt(f),
            Error::Recipe(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Error {}

impl From<ptm::ParseError> for Error {
    fn from(error: ptm::ParseError) -> Error {
        Error::Header(error)
    }
}

impl From<ptm_generate::Error> for Error {
    fn from(error: ptm_generate::Error) -> Error {
        Error::Recipe(error)
    }
}

impl From<String> for Error {
    fn from(message: String) -> Error {
        Error::Invalid(message.into())
    }
}

impl From<&'static str> for Error {
    fn from(message: &'static str) -> Error {
        Error::Invalid(message.into())
    }
}

/// A program prints errors as texts.
impl From<Error> for String {
    fn from(error: Error) -> String {
        error.to_string()
    }
}
