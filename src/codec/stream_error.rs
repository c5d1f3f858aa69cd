//! Why a stream was not decoded, and at which byte.

use std::fmt;

/// Whose fault it is that a stream was not decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StreamFault {
    /// The stream violates its standard, or is not what was asked for.
    Malformed,
    /// The stream may well be legal, but uses what this decoder does not implement.
    Unsupported,
}

/// Why a stream was not decoded, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamError {
    /// Whose fault it is.
    pub fault: StreamFault,
    /// The byte of the stream that shows it, counted from 0; at most the length of the stream.
    pub offset: usize,
    /// What is wrong, as part of a sentence.
    pub what: String,
}

impl fmt::Display for StreamError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "byte {}: {}", self.offset, self.what)
    }
}

impl std::error::Error for StreamError {}

pub(super) type Result<T> = std::result::Result<T, StreamError>;

pub(super) fn malformed(offset: usize, what: impl Into<String>) -> StreamError {
    StreamError {
        fault: StreamFault::Malformed,
        offset,
        what: what.into(),
    }
}

pub(super) fn unsupported(offset: usize, what: impl Into<String>) -> StreamError {
    StreamError {
        fault: StreamFault::Unsupported,
        offset,
        what: what.into(),
    }
}
