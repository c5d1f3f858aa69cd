//! The reason why a stream was not decoded, and the byte.

use std::fmt;

/// The kind of fault for which a stream was not decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StreamFault {
    /// The stream violates its standard, or has other properties than requested.
    Malformed,
    /// The stream may be legal, but uses a feature that this decoder does not support.
    Unsupported,
}

/// The reason why a stream was not decoded, and the position.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamError {
    /// The kind of fault.
    pub fault: StreamFault,
    /// The byte of the stream at which it was found, counted from 0; at most the length of the stream.
    pub offset: usize,
    /// The fault, as part of a sentence.
    pub what: String,
}

impl fmt::Display for StreamError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "byte {}: {}", self.offset, self.what)
    }
}

impl std::error::Error for StreamError {}

pub(super) type StreamResult<T> = std::result::Result<T, StreamError>;

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
