//! T.81 B.1.1 (T.87 C.1): markers and marker segments
//!
//! A stream is a sequence of *markers*: a byte 0xFF and a code that is neither 0x00 nor 0xFF. Some markers are
//! standalone. The others start a *marker segment*, whose first two bytes are its length. The scan header is followed
//! by entropy-coded data, which has no length and ends at the next marker.
//!
//! Worked example: a JPEG-LS stream of 4 × 1 zeros.
//!
//! ```text
//! FF D8                                      SOI, start of image
//! FF F7  00 0B  08  00 01 00 04 01 01 11 00  SOF55, frame header: 11 bytes, 8 bits, 1 row of 4
//! FF DA  00 08  01  01 00 00 00 00           SOS, scan header: 8 bytes, one component
//! F0                                         entropy-coded data
//! FF D9                                      EOI, end of image
//! ```
//!
//! Format notes
//! - A length includes its own two bytes, but not the marker (B.1.1.4): 00 0B covers eleven bytes. A segment with the
//!   minimum length 00 02 is empty.
//! - Two-byte numbers are big-endian (B.1.1.1).
//! - Any number of 0xFF bytes may precede each marker except the first (B.1.1.2).
//! - Bytes after EOI are ignored.

use std::fmt;

use super::stream_error::{StreamResult, malformed};

// Second bytes of the markers that both standards use (T.81 Table B.1, T.87 Table C.1).
pub(super) const RST0: u8 = 0xD0;
pub(super) const SOI: u8 = 0xD8;
pub(super) const EOI: u8 = 0xD9;
/// Start of scan.
pub const SOS: u8 = 0xDA;
pub(super) const DNL: u8 = 0xDC;
pub(super) const DRI: u8 = 0xDD;
pub(super) const APP0: u8 = 0xE0;
const APP15: u8 = 0xEF;
const COM: u8 = 0xFE;

/// A marker code, and the offset of its 0xFF byte.
#[derive(Clone, Copy)]
pub struct Marker {
    /// Second byte of the marker.
    pub code: u8,
    /// Offset in the stream of the first byte.
    pub at: usize,
}

impl fmt::Display for Marker {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "marker FF{:02X}", self.code)
    }
}

/// A read position in a stream or in one of its marker segments.
///
/// The cursor of a segment contains the stream up to the end of the segment, so offsets count from the start of the stream.
pub struct Cursor<'a> {
    /// Bytes up to the end of the segment or of the stream.
    pub stream: &'a [u8],
    /// Offset of the next byte.
    pub at: usize,
    /// Name of the part of the stream that this cursor reads, for error messages.
    name: &'static str,
}

impl<'a> Cursor<'a> {
    /// Creates a cursor at byte `at` of a stream.
    #[must_use]
    pub fn new(stream: &'a [u8], at: usize) -> Self {
        let name = "the stream";
        Cursor { stream, at, name }
    }

    /// Creates a cursor after the first marker, which must be SOI (B.2.1).
    ///
    /// # Errors
    /// Returns an error if the stream does not begin with SOI.
    pub fn open(stream: &'a [u8]) -> StreamResult<Self> {
        match stream {
            [] => Err(malformed(0, "the stream is empty")),
            [0xFF, SOI, ..] => Ok(Cursor::new(stream, 2)),
            _ => {
                let what = "the stream does not start with SOI (bytes FF D8)";
                Err(malformed(0, what))
            }
        }
    }

    /// Reads a byte. `what` is the name of the byte in the error message.
    ///
    /// # Errors
    /// Returns an error if the bytes end.
    pub fn read_byte(&mut self, what: &str) -> StreamResult<u8> {
        let Some(&byte) = self.stream.get(self.at) else {
            let what = format!("{} ends before {what}", self.name);
            return Err(malformed(self.at, what));
        };
        self.at += 1;
        Ok(byte)
    }

    /// Reads a two-byte big-endian number. `what` is the name of the number in the error message.
    ///
    /// # Errors
    /// Returns an error if the bytes end.
    pub fn read_u16(&mut self, what: &str) -> StreamResult<u16> {
        let bytes = [self.read_byte(what)?, self.read_byte(what)?];
        Ok(u16::from_be_bytes(bytes))
    }

    /// Returns true if no bytes are left.
    #[must_use]
    pub fn at_end(&self) -> bool {
        self.at == self.stream.len()
    }

    /// Checks that no bytes are left in the segment.
    ///
    /// # Errors
    /// Returns an error if there are more bytes.
    pub fn expect_end(&self) -> StreamResult<()> {
        match self.stream.len() - self.at {
            0 => Ok(()),
            left => {
                let what = format!("{} is {left} bytes too long", self.name);
                Err(malformed(self.at, what))
            }
        }
    }

    /// Reads the next marker, after any fill bytes (B.1.1.2).
    ///
    /// # Errors
    /// Returns an error if there is no marker.
    pub fn read_marker(&mut self) -> StreamResult<Marker> {
        let first = self.read_byte("a marker")?;
        if first != 0xFF {
            let what = format!("expected a marker, found byte {first:02X}");
            return Err(malformed(self.at - 1, what));
        }
        let mut code = 0xFF;
        while code == 0xFF {
            code = self.read_byte("the code of a marker")?;
        }
        // The last of several 0xFF bytes belongs to the marker.
        let at = self.at - 2;
        Ok(Marker { code, at })
    }

    /// Reads the next marker. Skips comments and application data (B.2.4.5, B.2.4.6).
    ///
    /// # Errors
    /// Returns an error if there is no marker, or if a segment is malformed.
    pub fn read_marker_after_comments(&mut self) -> StreamResult<Marker> {
        let mut marker = self.read_marker()?;
        while matches!(marker.code, COM | APP0..=APP15) {
            self.read_segment("a comment or application segment")?;
            marker = self.read_marker()?;
        }
        Ok(marker)
    }

    /// Reads the next marker and its segment. Returns the code, and the bytes after the length.
    ///
    /// # Errors
    /// Returns an error if there is no marker, or if its segment is malformed.
    pub fn read_marker_segment(&mut self) -> StreamResult<(u8, &'a [u8])> {
        let code = self.read_marker()?.code;
        let segment = self.read_segment("a segment")?;
        Ok((code, &segment.stream[segment.at..]))
    }

    /// Reads the segment of the marker that was just read (B.1.1.4). The cursor continues after the segment.
    ///
    /// # Errors
    /// Returns an error if the length of the segment is less than 2 or exceeds the rest of the stream.
    pub fn read_segment(&mut self, name: &'static str) -> StreamResult<Cursor<'a>> {
        let start = self.at;
        let length = self.read_u16("the length of a segment")?;
        if length < 2 {
            let what = format!("{name} has length {length}, which is less than 2");
            return Err(malformed(start, what));
        }
        let end = start + usize::from(length);
        if end > self.stream.len() {
            let what = format!("{name} of {length} bytes extends past the end of the stream");
            return Err(malformed(start, what));
        }
        self.at = end;
        Ok(Cursor {
            stream: &self.stream[..end],
            at: start + 2,
            name,
        })
    }
}
