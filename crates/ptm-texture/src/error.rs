//! Errors of maps and of names.

use std::fmt;

/// The reason why a texture map cannot be created, or why a text is not the name of an enumerant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Error {
    /// A text is none of the known names.
    UnknownName {
        /// The known names.
        known: Vec<&'static str>,
        /// The text.
        found: String,
    },
    /// The number of dimensions is not 1, 2 or 3.
    Dimensions(usize),
    /// A map has no base level with texels.
    NoBaseLevel,
    /// The number of texels of a level differs from the product of its sides.
    TexelCount {
        /// The number of the level.
        level: usize,
        /// The sides of the level.
        size: [usize; 3],
        /// The number of texels.
        count: usize,
    },
    /// A level has more dimensions than the map.
    TooManyDimensions {
        /// The number of the level.
        level: usize,
        /// The sides of the level.
        size: [usize; 3],
        /// The number of dimensions of the map.
        dimensions: usize,
    },
    /// A level has texels of different kinds.
    MixedTexels {
        /// The number of the level.
        level: usize,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::UnknownName { known, found } => {
                write!(f, "expected one of {}, found {found:?}", known.join(", "))
            }
            Error::Dimensions(found) => write!(f, "expected 1, 2 or 3 dimensions, found {found}"),
            Error::NoBaseLevel => f.write_str("a map needs a base level with texels"),
            Error::TexelCount { level, size, count } => {
                write!(f, "level {level} of size {size:?} has {count} texels")
            }
            Error::TooManyDimensions {
                level,
                size,
                dimensions,
            } => write!(
                f,
                "level {level} of size {size:?} has more than {dimensions} dimensions"
            ),
            Error::MixedTexels { level } => {
                write!(f, "level {level} has texels of different kinds")
            }
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
