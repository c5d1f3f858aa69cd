//! T.81 B.2.1: the order of a stream, read
//!
//! ```text
//! SOI  [tables]  SOF0 or SOF1  [tables]  SOS  entropy-coded data  [tables]  EOI
//! ```
//!
//! Format notes
//! - Tables may be defined again; the last definition before the scan header counts.
//! - SOF0 (baseline) and SOF1 (extended) differ in what tables they may use. For samples of 8 bits
//!   a decoder that can read SOF1 can read both alike.
//! - The frame header of another process follows the same SOI; only its marker identifies
//!   the process.

use super::processes::unexpected;
use super::scan::{ScanTables, decode_scan};
use super::tables::Tables;
use crate::codec::bit_buffer::BitBuffer;
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, EOI, SOS};
use crate::codec::stream_error::{StreamResult, malformed};

/// Frame headers of JPEG only (Table B.1): baseline and extended sequential, Huffman coded.
const SOF0: u8 = 0xC0;
const SOF1: u8 = 0xC1;

/// Decodes a JPEG stream of one component and `width` × `height` samples, in row order from the top.
///
/// # Errors
///
/// [`StreamFault::Malformed`](crate::codec::StreamFault) if the stream violates the standard, has
/// another size or another number of components;
/// [`StreamFault::Unsupported`](crate::codec::StreamFault) for the processes of T.81 other than
/// sequential Huffman with 8 bits.
pub fn decode(stream: &[u8], width: u32, height: u32) -> StreamResult<Vec<u8>> {
    let mut stream = Cursor::open(stream)?;
    let mut tables = Tables::default();
    let scan_tables = read_headers(&mut stream, &mut tables, width, height)?;
    // The fast version; `Bits<0>` in place of `BitBuffer<0>` is the plain one.
    let samples = decode_scan::<BitBuffer<0>>(&mut stream, &scan_tables, width, height)?;
    expect(&mut stream, &mut tables, &[EOI], "the end of the image")?;
    Ok(samples)
}

/// Reads everything before the entropy-coded data.
pub(super) fn read_headers(
    stream: &mut Cursor,
    tables: &mut Tables,
    width: u32,
    height: u32,
) -> StreamResult<ScanTables> {
    expect(stream, tables, &[SOF0, SOF1], "a frame header")?;
    let frame = FrameHeader::read(stream, width, height, &[12])?;
    expect(stream, tables, &[SOS], "the scan header")?;
    let scan = ScanHeader::read(stream, &frame)?;
    tables_of_scan(tables, &frame, &scan)
}

/// Reads tables up to one of these markers.
fn expect(stream: &mut Cursor, tables: &mut Tables, codes: &[u8], what: &str) -> StreamResult<()> {
    let marker = tables.read(stream)?;
    match codes.contains(&marker.code) {
        true => Ok(()),
        false => Err(unexpected(marker, what)),
    }
}

/// Returns the tables that the headers name (B.2.3).
fn tables_of_scan(
    tables: &Tables,
    frame: &FrameHeader,
    scan: &ScanHeader,
) -> StreamResult<ScanTables> {
    // The whole spectrum at once, and no successive approximation: the rest is for progressive
    // frames (Table B.3).
    if scan.parameters != [0, 63, 0] {
        let [first, last, approximation] = scan.parameters;
        let found = format!("{first} {last} {approximation}");
        let what = format!("expected parameters 0 63 0 of a sequential scan, found {found}");
        return Err(malformed(scan.at + 1, what));
    }
    let (dc, ac) = (scan.tables >> 4, scan.tables & 15);
    tables.of_scan(frame.quantization_table, dc, ac, scan.at)
}
