//! T.81 B.1.1.4 (T.87 C.1): the marker segments before the data, taken apart and put together again
//!
//! For those who write other headers than the encoders do, or read headers otherwise than the standards say. Fill bytes
//! (B.1.1.2) belong to no segment, and are not put back.

use super::markers::{Cursor, SOS};
use super::stream_error::Result;
use super::writer::Writer;

/// A marker segment.
pub(crate) struct Segment {
    /// The second byte of its marker.
    pub code: u8,
    /// What stands behind its length.
    pub content: Vec<u8>,
}

/// The segments of a stream, the scan header as the last of them, and what follows it.
///
/// # Errors
///
/// Where a marker or a segment is cut off.
pub(crate) fn apart(stream: &[u8]) -> Result<(Vec<Segment>, &[u8])> {
    let mut cursor = Cursor::open(stream)?;
    let mut segments = Vec::new();
    loop {
        let code = cursor.marker()?.code;
        let segment = cursor.segment("a segment")?;
        let content = segment.stream[segment.at..].to_vec();
        segments.push(Segment { code, content });
        if code == SOS {
            return Ok((segments, &stream[cursor.at..]));
        }
    }
}

/// The stream of these segments and what follows them.
pub(crate) fn together(segments: &[Segment], data: &[u8]) -> Vec<u8> {
    let mut writer = Writer::new();
    for segment in segments {
        writer.segment(segment.code, &segment.content);
    }
    writer.followed_by(data)
}
