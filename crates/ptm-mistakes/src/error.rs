//! Errors of the catalogs, and of formulas in text form.

use std::fmt;

/// The reason why a catalog or a formula cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// A formula has an error. The text says what was expected.
    Formula(String),
    /// The YAML text of a catalog has an error.
    Data(ptm_suite::Error),
    /// A record of a catalog has an error.
    Record {
        /// The number of the record's first line, counted from 1.
        line: usize,
        /// The error in the record.
        message: String,
    },
}

/// The result of reading a catalog or a formula.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Formula(message) => f.write_str(message),
            Error::Data(error) => error.fmt(f),
            Error::Record { line, message } => write!(f, "line {line}: {message}"),
        }
    }
}

impl std::error::Error for Error {}

impl From<ptm_suite::Error> for Error {
    fn from(error: ptm_suite::Error) -> Error {
        Error::Data(error)
    }
}

/// A program prints errors as texts.
impl From<Error> for String {
    fn from(error: Error) -> String {
        error.to_string()
    }
}
