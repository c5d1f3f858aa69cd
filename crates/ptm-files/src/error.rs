//! Errors of the tools.

use std::borrow::Cow;
use std::fmt;

/// The reason why a tool cannot do what it was asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// The file is refused.
    File(ptm::Error),
    /// The new file cannot be generated.
    Recipe(ptm_generate::Error),
    /// The data of the suite, or of a reader's profile, is invalid.
    Data(ptm_suite::Error),
    /// The file or the request has no result of this kind. The text is the reason.
    Impossible(Cow<'static, str>),
}

/// The result of a tool.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    pub(crate) fn impossible<T>(reason: impl Into<Cow<'static, str>>) -> Result<T> {
        Err(Error::Impossible(reason.into()))
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::File(error) => error.fmt(f),
            Error::Recipe(error) => error.fmt(f),
            Error::Data(error) => error.fmt(f),
            Error::Impossible(reason) => f.write_str(reason),
        }
    }
}

impl std::error::Error for Error {}

impl From<ptm::Error> for Error {
    fn from(error: ptm::Error) -> Error {
        Error::File(error)
    }
}

impl From<ptm_generate::Error> for Error {
    fn from(error: ptm_generate::Error) -> Error {
        Error::Recipe(error)
    }
}

impl From<ptm_suite::Error> for Error {
    fn from(error: ptm_suite::Error) -> Error {
        Error::Data(error)
    }
}

impl From<String> for Error {
    fn from(reason: String) -> Error {
        Error::Impossible(reason.into())
    }
}

impl From<&'static str> for Error {
    fn from(reason: &'static str) -> Error {
        Error::Impossible(reason.into())
    }
}

/// A program prints errors as texts.
impl From<Error> for String {
    fn from(error: Error) -> String {
        error.to_string()
    }
}
