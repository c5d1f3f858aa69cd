//! Errors of the codecs, with byte offsets.

use std::fmt;

/// The kind of an error in a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StreamFault {
    /// The stream violates its standard, or its properties differ from the requested ones.
    Malformed,
    /// The stream may be legal, but uses a feature that this decoder does not support.
    Unsupported,
}

/// The reason why a stream was not decoded, with the offset of the fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamError {
    /// The kind of fault.
    pub fault: StreamFault,
    /// Zero-based offset of the faulty byte in the stream, at most the length of the stream.
    pub offset: usize,
    /// Description of the fault, in lowercase and without a period.
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
