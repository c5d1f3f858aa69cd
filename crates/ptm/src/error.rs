//! Errors of the decoder: the fault, the violated clause, and the byte offset.
//!
//! A fault in the file ([`Class::Malformed`]), a feature that this decoder does not support ([`Class::Unsupported`]) and an
//! exceeded limit ([`Class::Limit`]) are separate classes. The program exits with 65 for the first, and with 69 for the others.

use std::fmt;

/// The reason why a file was not decoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    clause: &'static str,
    offset: usize,
    kind: Kind,
}

/// The class of an [`Error`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// The file violates a rule of the text.
    Malformed,
    /// The file may be valid, but uses a feature that this decoder does not support.
    Unsupported,
    /// The file needs more memory than [`crate::types::Limits`] allows.
    Limit,
}

/// The fault, with details.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The content differs from `what`.
    Expected {
        /// Description of the expected part.
        what: &'static str,
        /// Beginning of the actual content, escaped for printing.
        found: String,
    },
    /// The file ends before `what`.
    Ended {
        /// Description of the expected part.
        what: &'static str,
    },
    /// `what` needs more bytes than remain in the file.
    Short {
        /// Description of the truncated part.
        what: &'static str,
        /// Number of bytes needed, or 2⁶⁴ − 1 on overflow.
        needed: u64,
        /// Number of bytes from the position of the error to the end of the file.
        remaining: usize,
    },
    /// An index is past the last entry of the table.
    IndexOutOfRange {
        /// Index that is out of range.
        index: usize,
        /// Number of entries in the table.
        entries: usize,
    },
    /// The planes need more memory than allowed.
    TooLarge {
        /// Number of bytes needed, or 2⁶⁴ − 1 on overflow.
        needed: u64,
        /// Maximum number of bytes allowed.
        limit: usize,
    },
    /// A plane is predicted from a plane that does not exist.
    NotAPlane {
        /// Index of the predicted plane.
        plane: usize,
        /// Index of the nonexistent reference.
        reference: i64,
        /// Number of planes in the file.
        planes: usize,
    },
    /// A plane is predicted from a plane that is not decoded before it.
    NotCausal {
        /// Index of the predicted plane.
        plane: usize,
        /// Rank of the predicted plane.
        rank: i64,
        /// Index of the reference.
        reference: usize,
        /// Rank of the reference.
        reference_rank: i64,
    },
    /// The stream of a plane violates its standard or does not match the plane.
    Stream {
        /// Index of the plane.
        plane: usize,
        /// True if the stream may be legal, but uses an unsupported feature.
        unsupported: bool,
        /// Description of the fault.
        what: String,
    },
    /// The size of the side information is not a multiple of the record size.
    PartialRecord {
        /// Size of the side information in bytes.
        bytes: usize,
    },
    /// A record corrects a texel that does not exist.
    PositionOutOfRange {
        /// Position in the record.
        position: u32,
        /// Number of texels in the map.
        texels: usize,
    },
    /// The file uses a legal feature that this decoder does not support.
    NotSupported {
        /// Name of the feature.
        what: &'static str,
    },
}

impl Error {
    /// Creates an error: the violated clause, the offset in the file, and what was found there.
    #[must_use]
    pub const fn new(clause: &'static str, offset: usize, kind: Kind) -> Error {
        Error {
            clause,
            offset,
            kind,
        }
    }

    /// Returns the error with a different clause, for faults that violate a clause other than the field's.
    pub(crate) const fn with_clause(mut self, clause: &'static str) -> Error {
        self.clause = clause;
        self
    }

    /// Returns the violated clause, as numbered in `spec-cases/clauses.yaml`: `2.5/2`.
    #[must_use]
    pub const fn clause(&self) -> &'static str {
        self.clause
    }

    /// Returns the section of the violated clause: `2.5`.
    #[must_use]
    pub fn section(&self) -> &'static str {
        self.clause
            .split_once('/')
            .map_or(self.clause, |(section, _)| section)
    }

    /// Returns the zero-based offset of the byte at which the error was detected.
    #[must_use]
    pub const fn offset(&self) -> usize {
        self.offset
    }

    /// Returns the fault with its details.
    #[must_use]
    pub const fn kind(&self) -> &Kind {
        &self.kind
    }

    /// Returns the class of the fault.
    #[must_use]
    pub const fn class(&self) -> Class {
        match self.kind {
            Kind::TooLarge { .. } => Class::Limit,
            Kind::NotSupported { .. }
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

/// Returns a short title of a section, in lowercase.
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

/// Describes a number of bytes, which may be the result of saturating arithmetic.
#[must_use]
pub fn byte_count(n: u64) -> String {
    match n {
        u64::MAX => "more bytes than 64 bits can count".to_owned(),
        n => format!("{n} bytes"),
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Expected { what, found } => write!(f, "expected {what}, found \"{found}\""),
            Kind::Ended { what } => write!(f, "expected {what}, found the end of the file"),
            Kind::Short {
                what,
                needed,
                remaining,
            } => write!(f, "{what} need {}, {remaining} remain", byte_count(*needed)),
            Kind::IndexOutOfRange { index, entries } => {
                write!(f, "index {index}, but the table has {entries} entries")
            }
            Kind::TooLarge { needed: n, limit } => {
                write!(
                    f,
                    "the planes need {}; the limit is {limit}",
                    byte_count(*n)
                )
            }
            Kind::NotAPlane {
                plane,
                reference,
                planes,
            } => {
                write!(
                    f,
                    "plane {plane} is predicted from plane {reference}, but the last plane is {}",
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
                "plane {plane} (rank {rank}) is predicted from plane {reference} (rank {reference_rank}), which is not decoded before it"
            ),
            Kind::Stream { plane, what, .. } => write!(f, "plane {plane}: {what}"),
            Kind::PartialRecord { bytes } => write!(
                f,
                "{bytes} bytes of side information are not a whole number of 5-byte records"
            ),
            Kind::PositionOutOfRange { position, texels } => write!(
                f,
                "a record refers to texel {position}, but the last texel is {}",
                texels - 1
            ),
            Kind::NotSupported { what } => write!(f, "{what} are not supported"),
        }
    }
}

impl std::error::Error for Error {}

/// Result type of the decoder.
pub type Result<T> = std::result::Result<T, Error>;
