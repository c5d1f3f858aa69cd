//! T.81 B.2.1: reading of a stream
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

use super::processes::unexpected_marker;
use super::scan::{ScanTables, decode_scan};
use super::tables::Tables;
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
///
/// Returns [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard, or has another
/// size or another number of components, and [`StreamFault::Unsupported`](crate::codec::StreamFault) for the
/// processes of T.81 other than sequential Huffman coding with 8 bits.
pub fn decode(stream: &[u8], width: u32, height: u32) -> StreamResult<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let mut tables = Tables::default();
    let scan_tables = read_headers(&mut stream, &mut tables, width, height)?;
    // `BitBuffer<0>` is the fast version, and `Bits<0>` the plain one.
    let samples = decode_scan::<BitBuffer<0>>(&mut stream, &scan_tables, width, height)?;
    read_until(&mut stream, &mut tables, &[EOI], "the end of the image")?;
    Ok(samples)
}

/// Reads everything before the entropy-coded data.
pub(super) fn read_headers(
    stream: &mut Cursor,
    tables: &mut Tables,
    width: u32,
    height: u32,
) -> StreamResult<ScanTables> {
    read_until(stream, tables, &[SOF0, SOF1], "a frame header")?;
    let frame = FrameHeader::read(stream, width, height, &[12])?;
    read_until(stream, tables, &[SOS], "the scan header")?;
    let scan = ScanHeader::read(stream, &frame)?;
    find_scan_tables(tables, &frame, &scan)
}

/// Reads tables up to a marker in `codes`. Any other marker is an error.
fn read_until(
    stream: &mut Cursor,
    tables: &mut Tables,
    codes: &[u8],
    what: &str,
) -> StreamResult<()> {
    let marker = tables.read(stream)?;
    match codes.contains(&marker.code) {
        true => Ok(()),
        false => Err(unexpected_marker(marker, what)),
    }
}

/// Looks up the tables that the headers name (B.2.3).
fn find_scan_tables(
    tables: &Tables,
    frame: &FrameHeader,
    scan: &ScanHeader,
) -> StreamResult<ScanTables> {
    // The whole spectrum at once and no successive approximation: other values are for progressive frames (Table B.3).
    if scan.parameters != [0, 63, 0] {
        let [first, last, approximation] = scan.parameters;
        let found = format!("{first} {last} {approximation}");
        let what = format!("expected parameters 0 63 0 of a sequential scan, found {found}");
        return Err(malformed(scan.at + 1, what));
    }
    let (dc, ac) = (scan.tables >> 4, scan.tables & 15);
    tables.scan_tables(frame.quantization_table, dc, ac, scan.at)
}
