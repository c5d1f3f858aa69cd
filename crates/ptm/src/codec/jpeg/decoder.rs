//! T.81 B.2.1: reading a stream
//!
//! ```text
//! SOI  [tables]  SOF0 or SOF1  [tables]  SOS  entropy-coded data  [tables]  EOI
//! ```
//!
//! Format notes
//! - Tables may be redefined. The last definition before the scan header applies.
//! - SOF0 (baseline) and SOF1 (extended) differ in the tables that they allow. For samples of 8 bits, a decoder that
//!   supports SOF1 can treat both in the same way.
//! - Other processes use the same SOI. Only the marker of the frame header identifies the process.

use super::{scan::decode_scan, tables::Tables};
use crate::codec::bit_buffer::BitBuffer;
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, EOI, SOS};
use crate::codec::stream_error::{StreamResult, malformed};

/// Frame header markers that only JPEG uses (Table B.1): baseline and extended sequential, Huffman coded.
const SOF0: u8 = 0xC0;
const SOF1: u8 = 0xC1;

/// Decodes a JPEG stream with one component and `width` × `height` samples. Returns the samples in row order from the top.
///
/// # Errors
/// Returns [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard or differs in size or number
/// of components, and [`StreamFault::Unsupported`](crate::codec::StreamFault) for the processes of T.81 other than sequential
/// Huffman coding with 8 bits.
pub fn decode(stream: &[u8], width: u32, height: u32) -> StreamResult<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let mut tables = Tables::default();
    tables.read_until(&mut stream, &[SOF0, SOF1], "a frame header")?;
    let frame = FrameHeader::read(&mut stream, width, height, 8..=8, 12..=12)?;
    tables.read_until(&mut stream, &[SOS], "the scan header")?;
    let scan = ScanHeader::read(&mut stream, &frame)?;
    // The whole spectrum at once and no successive approximation: other values are for progressive frames (Table B.3).
    if scan.parameters != [0, 63, 0] {
        let [first, last, approximation] = scan.parameters;
        let found = format!("{first} {last} {approximation}");
        let what = format!("expected parameters 0 63 0 for a sequential scan, found {found}");
        return Err(malformed(scan.at + 1, what));
    }
    let scan_tables = tables.scan_tables(&frame, &scan)?;
    // `BitBuffer<0>` is the fast version, and `Bits<0>` the plain one.
    let samples = decode_scan::<BitBuffer<0>>(&mut stream, &scan_tables, width, height)?;
    tables.read_until(&mut stream, &[EOI], "the end of the image")?;
    Ok(samples)
}
