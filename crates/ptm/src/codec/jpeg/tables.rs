//! T.81 B.2.4: tables and miscellaneous segments
//!
//! Tables and miscellaneous segments are quantization tables (DQT), Huffman tables (DHT), the restart interval (DRI), comments
//! and application data. Any number of them may precede each header and EOI, in any order. A table is stored under an index,
//! 0 … 3, until another table replaces it.
//!
//! Worked example: a quantization table of ones, and a 16-bit table whose first step is 300.
//!
//! ```text
//! FF DB  00 43  00  01*64             precision 0, number 0, then 64 steps in zigzag order
//! FF DB  00 83  11  01 2C  00 01*63   precision 1, number 1
//! ```
//!
//! Format notes
//! - A segment may contain several tables.
//! - The byte before a table contains its precision or class in the high four bits and its index in the low four bits.
//! - DC and AC tables have separate indices: DC table 0 and AC table 0 are different tables.

use super::{huffman_table::HuffmanTable, processes::unexpected_marker, scan::ScanTables};
use crate::codec::headers::{FrameHeader, ScanHeader};
use crate::codec::markers::{Cursor, DRI};
use crate::codec::stream_error::{StreamResult, malformed};

// Markers of JPEG only (Table B.1).
const DHT: u8 = 0xC4;
const DQT: u8 = 0xDB;

/// Tables in effect at the current position in the stream, by index.
#[derive(Default)]
pub(super) struct Tables {
    /// Quantization tables in zigzag order, as stored.
    quantization: [Option<[u16; 64]>; 4],
    /// Huffman tables: DC tables, then AC tables.
    huffman: [[Option<HuffmanTable>; 4]; 2],
    /// Number of blocks between restart markers, or 0 for no restart markers.
    restart_interval: u16,
}

impl Tables {
    /// Reads tables up to the first marker in `codes`. Skips comments and application data. Any other marker is an error.
    pub fn read_until(&mut self, input: &mut Cursor, codes: &[u8], what: &str) -> StreamResult<()> {
        loop {
            let marker = input.read_marker_after_comments()?;
            match marker.code {
                DQT => {
                    self.read_quantization(input.read_segment("the quantization table segment")?)?;
                }
                DHT => self.read_huffman(input.read_segment("the Huffman table segment")?)?,
                DRI => {
                    // The number of blocks between restart markers (B.2.4.4).
                    let mut segment = input.read_segment("the restart interval segment")?;
                    self.restart_interval = segment.read_u16("the restart interval")?;
                    segment.expect_end()?;
                }
                code if codes.contains(&code) => return Ok(()),
                _ => return Err(unexpected_marker(marker, what)),
            }
        }
    }

    /// Reads quantization tables: for each, a byte with precision and index, then 64 steps (B.2.4.1).
    fn read_quantization(&mut self, mut segment: Cursor) -> StreamResult<()> {
        while !segment.at_end() {
            let (precision, number) = read_precision_and_index(&mut segment, "quantization table")?;
            let mut table = [0; 64];
            for step in &mut table {
                let at = segment.at;
                *step = match precision {
                    0 => u16::from(segment.read_byte("the 64 quantization steps")?),
                    _ => segment.read_u16("the 64 quantization steps")?,
                };
                if *step == 0 {
                    return Err(malformed(at, "a quantization step is zero"));
                }
            }
            self.quantization[number] = Some(table);
        }
        Ok(())
    }

    /// Reads Huffman tables: for each, a byte with class (0 for DC, 1 for AC) and index, then the table (B.2.4.2).
    fn read_huffman(&mut self, mut segment: Cursor) -> StreamResult<()> {
        while !segment.at_end() {
            let (class, number) = read_precision_and_index(&mut segment, "Huffman table")?;
            self.huffman[usize::from(class)][number] = Some(read_huffman_table(&mut segment)?);
        }
        Ok(())
    }

    /// Looks up the tables that the headers name (B.2.3).
    pub fn scan_tables(&self, frame: &FrameHeader, scan: &ScanHeader) -> StreamResult<ScanTables> {
        let [dc_tables, ac_tables] = &self.huffman;
        let (number, dc, ac) = (frame.quantization_table, scan.tables >> 4, scan.tables & 15);
        let undefined = |kind: &'static str, number: u8| {
            // The error is at the offset of the table indices in the scan header.
            move || malformed(scan.at, format!("{kind} {number} was not defined"))
        };
        let quantization = find_table(&self.quantization, number);
        Ok(ScanTables {
            quantization: quantization.ok_or_else(undefined("quantization table", number))?,
            dc: find_table(dc_tables, dc).ok_or_else(undefined("DC Huffman table", dc))?,
            ac: find_table(ac_tables, ac).ok_or_else(undefined("AC Huffman table", ac))?,
            restart_interval: self.restart_interval,
        })
    }
}

fn find_table<T: Clone>(tables: &[Option<T>; 4], number: u8) -> Option<T> {
    tables.get(usize::from(number))?.clone()
}

/// Reads the byte before a table: its precision or class, 0 or 1, and its index, 0 … 3.
fn read_precision_and_index(segment: &mut Cursor, kind: &str) -> StreamResult<(u8, usize)> {
    let at = segment.at;
    let byte = segment.read_byte(kind)?;
    let (precision, number) = (byte >> 4, byte & 15);
    if precision > 1 || number > 3 {
        let what = format!("illegal {kind}: precision or class {precision}, index {number}");
        return Err(malformed(at, what));
    }
    Ok((precision, usize::from(number)))
}

/// Reads the code counts for lengths of 1 … 16 bits, then the symbols (B.2.4.2).
fn read_huffman_table(segment: &mut Cursor) -> StreamResult<HuffmanTable> {
    let at = segment.at;
    let mut counts = [0; 16];
    for count in &mut counts {
        *count = segment.read_byte("the 16 code counts")?;
    }
    let total: usize = counts.iter().map(|&count| usize::from(count)).sum();
    if total > 256 {
        let what = format!("a Huffman table has {total} codes; at most 256 are allowed");
        return Err(malformed(at, what));
    }
    let mut symbols = Vec::with_capacity(total);
    for _ in 0..total {
        symbols.push(segment.read_byte("the symbols of a Huffman table")?);
    }
    let table = HuffmanTable { counts, symbols };
    match table.overfull_length() {
        Some(length) => {
            let what = format!("a Huffman table has too many codes of {length} bits");
            Err(malformed(at, what))
        }
        None => Ok(table),
    }
}
