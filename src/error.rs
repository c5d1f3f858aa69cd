//! Errors: what is wrong, which clause, which byte.
//!
//! A fault of the file ([`Class::Malformed`]), a feature that this reader lacks ([`Class::Unsupported`]) and an exceeded limit
//! ([`Class::Limit`]) are separate classes, with separate exit statuses of the program.

use std::fmt;

/// The reason why a file was not decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    clause: &'static str,
    offset: usize,
    kind: Kind,
}

/// The kind of fault of an [`Error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The file breaks a rule of the text.
    Malformed,
    /// The file may be valid, but this reader does not support its kind.
    Unsupported,
    /// The file needs more memory than [`crate::ptm::Limits`] allow.
    Limit,
}

/// The fault, with what was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Something else was found instead of `what`; `found` is its beginning, printable.
    Expected {
        /// The expected part.
        what: &'static str,
        /// The beginning of what was found.
        found: String,
    },
    /// The file ends before `what`.
    Ended {
        /// The expected part.
        what: &'static str,
    },
    /// `what` needs more bytes than the file has left.
    Short {
        /// The part of the file.
        what: &'static str,
        /// Bytes it needs; 2⁶⁴ − 1 on overflow.
        needs: u64,
        /// Bytes from here to the end of the file.
        remain: usize,
    },
    /// An index points past the last entry of the table.
    IndexOutOfRange {
        /// The index.
        index: usize,
        /// The number of entries.
        entries: usize,
    },
    /// The planes would take more memory than allowed.
    TooLarge {
        /// Bytes needed; 2⁶⁴ − 1 on overflow.
        needs: u64,
        /// Bytes allowed.
        limit: usize,
    },
    /// A plane is predicted from one that does not exist.
    NotAPlane {
        /// The plane.
        plane: usize,
        /// The plane it names as its reference.
        reference: i64,
        /// Number of planes.
        planes: usize,
    },
    /// A plane is predicted from one that is not decoded before it.
    NotCausal {
        /// The plane.
        plane: usize,
        /// Its rank.
        rank: i64,
        /// Its reference.
        reference: usize,
        /// The reference's rank.
        reference_rank: i64,
    },
    /// The stream of a plane violates its standard, or does not fit the plane.
    Stream {
        /// The plane.
        plane: usize,
        /// True if the stream may be legal but is of an unsupported kind.
        unsupported: bool,
        /// The fault of the stream.
        what: String,
    },
    /// Side information that does not consist of whole records.
    PartialRecord {
        /// Its bytes.
        bytes: usize,
    },
    /// A record corrects a texel that does not exist.
    PositionOutOfRange {
        /// The position.
        position: u32,
        /// Number of texels.
        texels: usize,
    },
    /// A legal feature that this reader does not support.
    NotRead {
        /// The feature.
        what: &'static str,
    },
}

impl Error {
    pub(crate) const fn new(clause: &'static str, offset: usize, kind: Kind) -> Error {
        Error {
            clause,
            offset,
            kind,
        }
    }

    /// Returns the error with another clause, if the clause of the field is not the one that is broken.
    pub(crate) const fn with_clause(mut self, clause: &'static str) -> Error {
        self.clause = clause;
        self
    }

    /// Returns the clause that is broken, as numbered in `spec-cases/clauses.yaml`: `2.5/2`.
    #[must_use]
    pub const fn clause(&self) -> &'static str {
        self.clause
    }

    /// Returns the section of that clause: `2.5`.
    #[must_use]
    pub fn section(&self) -> &'static str {
        self.clause
            .split_once('/')
            .map_or(self.clause, |(section, _)| section)
    }

    /// Returns the byte of the file, counted from 0, at which the error was found.
    #[must_use]
    pub const fn offset(&self) -> usize {
        self.offset
    }

    /// Returns the fault.
    #[must_use]
    pub const fn kind(&self) -> &Kind {
        &self.kind
    }

    /// Returns the class of the fault.
    #[must_use]
    pub const fn class(&self) -> Class {
        match self.kind {
            Kind::TooLarge { .. } => Class::Limit,
            Kind::NotRead { .. }
            | Kind::Stream {
                unsupported: true, ..
            } => Class::Unsupported,
            Kind::Expected { .. }
            | Kind::Ended { .. }
            | Kind::Short { .. }
            | Kind::IndexOutOfRange { .. }
            | Kind::NotAPlane { .. }
            | Kind::NotCausal { .. }
            | Kind::Stream {
                unsupported: false, ..
            }
            | Kind::PartialRecord { .. }
            | Kind::PositionOutOfRange { .. } => Class::Malformed,
        }
    }
}

/// Returns the title of a section, in the words of the text.
#[must_use]
pub fn section_title(section: &str) -> &'static str {
    match section {
        "1.0" => "background",
        "2.0" => "file format",
        "2.1" => "header string",
        "2.2" => "format string",
        "2.3" => "image size",
        "2.4" => "scale and bias",
        "2.5" => "lookup table",
        "2.6" => "color matrix",
        "2.7" | "2.7.1" | "2.7.2" | "2.7.3" => "texel data",
        "2.8" | "2.8.1" | "2.8.2" => "lookup table indices",
        _ => "compressed data",
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let section = self.section();
        write!(
            f,
            "{} (§{section}), byte {}: {}",
            section_title(section),
            self.offset,
            self.kind
        )
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A saturated number of bytes is not printed as a number.
        let bytes = |n: u64| {
            if n == u64::MAX {
                "more bytes than can be counted".to_owned()
            } else {
                format!("{n} bytes")
            }
        };
        match self {
            Kind::Expected { what, found } => write!(f, "expected {what}, found \"{found}\""),
            Kind::Ended { what } => write!(f, "expected {what}, found the end of the file"),
            Kind::Short {
                what,
                needs,
                remain,
            } => write!(f, "{what} need {}, {remain} remain", bytes(*needs)),
            Kind::IndexOutOfRange { index, entries } => {
                write!(f, "index {index} into a table of {entries} entries")
            }
            Kind::TooLarge { needs, limit } => {
                write!(f, "the planes need {}, the limit is {limit}", bytes(*needs))
            }
            Kind::NotAPlane {
                plane,
                reference,
                planes,
            } => {
                write!(
                    f,
                    "plane {plane} is predicted from plane {reference}, the last plane is {}",
                    planes - 1
                )
            }
            Kind::NotCausal {
                plane,
                rank,
                reference,
                reference_rank,
            } => write!(
                f,
                "plane {plane} of rank {rank} is predicted from plane {reference} of rank {reference_rank}, which is not decoded before it"
            ),
            Kind::Stream { plane, what, .. } => write!(f, "plane {plane}: {what}"),
            Kind::PartialRecord { bytes } => write!(
                f,
                "{bytes} bytes of side information are no whole number of records of 5 bytes"
            ),
            Kind::PositionOutOfRange { position, texels } => write!(
                f,
                "a record for texel {position}, but the last texel is {}",
                texels - 1
            ),
            Kind::NotRead { what } => write!(f, "{what} are not read"),
        }
    }
}

impl std::error::Error for Error {}

/// The result of the decoder.
pub type Result<T> = std::result::Result<T, Error>;
