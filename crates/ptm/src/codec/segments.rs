//! T.81 B.1.1.4 (T.87 C.1): splitting a stream into marker segments, and joining them
//!
//! Used by code that writes unusual headers, or that interprets headers differently from the standards. Fill bytes (B.1.1.2)
//! belong to no segment and are not preserved.

use super::markers::{Cursor, SOS};
use super::{stream_error::StreamResult, writer::Writer};

/// A marker segment, without its length.
pub struct MarkerSegment {
    /// Marker code, the second byte of the marker.
    pub code: u8,
    /// Content of the segment: the bytes after its length.
    pub content: Vec<u8>,
}

/// Splits a stream into segments up to the scan header, and the remaining bytes. Returns an error if a segment is truncated.
///
/// # Errors
/// Returns an error if the stream has no scan, or if a segment is malformed.
pub fn split_segments(stream: &[u8]) -> StreamResult<(Vec<MarkerSegment>, &[u8])> {
    let mut cursor = Cursor::open(stream)?;
    let mut segments = Vec::new();
    loop {
        let (code, content) = cursor.read_marker_segment()?;
        let content = content.to_vec();
        segments.push(MarkerSegment { code, content });
        if code == SOS {
            return Ok((segments, &stream[cursor.at..]));
        }
    }
}

/// Joins these segments and `data` into a stream.
#[must_use]
pub fn join_segments(segments: &[MarkerSegment], data: &[u8]) -> Vec<u8> {
    let mut writer = Writer::new();
    for segment in segments {
        writer.write_segment(segment.code, &segment.content);
    }
    writer.finish_with(data)
}
