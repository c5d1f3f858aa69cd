//! T.81 B.2.4: tables and miscellaneous segments
//!
//! Quantization tables (DQT), Huffman tables (DHT), the restart interval (DRI), comments and application data. Any number of
//! them may precede every header and the end, in any order; tables are stored under a number, 0 … 3, until another one replaces
//! it.
//!
//! Worked example: a quantization table of ones, and one of 16 bits whose first step is 300.
//!
//! ```text
//! FF DB  00 43  00  01*64             precision 0, number 0, then 64 steps in zigzag order
//! FF DB  00 83  11  01 2C  00 01*63   precision 1, number 1
//! ```
//!
//! Format notes
//! - One segment may hold several tables, one after the other.
//! - Precision and class are in the high four bits of the byte before the table, the number in
//!   the low ones.
//! - DC and AC tables are numbered separately: DC table 0 and AC table 0 are two tables.

use super::huffman_table::HuffmanTable;
use super::scan::ScanTables;
use crate::codec::markers::{Cursor, DRI, Marker};
use crate::codec::stream_error::{StreamResult, malformed};

// Markers of JPEG only (Table B.1).
const DHT: u8 = 0xC4;
const DQT: u8 = 0xDB;

/// The tables that are defined at one position of the stream, by number.
#[derive(Default)]
pub(super) struct Tables {
    /// In zigzag order, as stored.
    quantization: [Option<[u16; 64]>; 4],
    /// Tables for DC, then for AC.
    huffman: [[Option<HuffmanTable>; 4]; 2],
    /// Number of blocks; 0 for no restart interval.
    restart_interval: u16,
}

impl Tables {
    /// Reads table segments, skips comments and application data, and returns the first other
    /// marker.
    pub fn read(&mut self, stream: &mut Cursor) -> StreamResult<Marker> {
        loop {
            let marker = stream.marker_after_comments()?;
            match marker.code {
                DQT => self.read_quantization(stream.segment("the quantization table segment")?)?,
                DHT => self.read_huffman(stream.segment("the Huffman table segment")?)?,
                DRI => self.read_interval(stream.segment("the restart interval segment")?)?,
                _ => return Ok(marker),
            }
        }
    }

    /// Reads tables, each a byte of precision and number, then 64 steps (B.2.4.1).
    fn read_quantization(&mut self, mut segment: Cursor) -> StreamResult<()> {
        while !segment.at_end() {
            let (precision, number) = precision_and_number(&mut segment, "quantization table")?;
            let mut table = [0; 64];
            for step in &mut table {
                let at = segment.at;
                *step = match precision {
                    0 => u16::from(segment.byte("64 quantization steps")?),
                    _ => segment.u16("64 quantization steps")?,
                };
                if *step == 0 {
                    return Err(malformed(at, "a quantization step is zero"));
                }
            }
            self.quantization[number] = Some(table);
        }
        Ok(())
    }

    /// Reads tables, each a byte of class (0 for DC, 1 for AC) and number, then the table (B.2.4.2).
    fn read_huffman(&mut self, mut segment: Cursor) -> StreamResult<()> {
        while !segment.at_end() {
            let (class, number) = precision_and_number(&mut segment, "Huffman table")?;
            self.huffman[usize::from(class)][number] = Some(read_huffman_table(&mut segment)?);
        }
        Ok(())
    }

    /// Reads the number of blocks between restart markers (B.2.4.4).
    fn read_interval(&mut self, mut segment: Cursor) -> StreamResult<()> {
        self.restart_interval = segment.u16("the restart interval")?;
        segment.expect_end()
    }

    /// Returns the tables that the headers name; `at` is the position of these numbers in the scan header.
    pub fn of_scan(&self, quantization: u8, dc: u8, ac: u8, at: usize) -> StreamResult<ScanTables> {
        let [dc_tables, ac_tables] = &self.huffman;
        Ok(ScanTables {
            quantization: find_table(&self.quantization, quantization, "quantization table", at)?,
            dc: find_table(dc_tables, dc, "DC Huffman table", at)?,
            ac: find_table(ac_tables, ac, "AC Huffman table", at)?,
            restart_interval: self.restart_interval,
        })
    }
}

fn find_table<T: Clone>(
    tables: &[Option<T>; 4],
    number: u8,
    kind: &str,
    at: usize,
) -> StreamResult<T> {
    let table = tables.get(usize::from(number)).cloned().flatten();
    table.ok_or_else(|| malformed(at, format!("{kind} {number} was not defined")))
}

/// Reads the byte before a table: its precision or class, 0 or 1, and its number, 0 … 3.
fn precision_and_number(segment: &mut Cursor, kind: &str) -> StreamResult<(u8, usize)> {
    let at = segment.at;
    let byte = segment.byte(kind)?;
    let (precision, number) = (byte >> 4, byte & 15);
    if precision > 1 || number > 3 {
        let what = format!("no {kind} has precision or class {precision} and number {number}");
        return Err(malformed(at, what));
    }
    Ok((precision, usize::from(number)))
}

/// Reads the numbers of codes of 1 … 16 bits, then the symbols (B.2.4.2).
fn read_huffman_table(segment: &mut Cursor) -> StreamResult<HuffmanTable> {
    let at = segment.at;
    let mut counts = [0; 16];
    for count in &mut counts {
        *count = segment.byte("16 numbers of codes")?;
    }
    let total: usize = counts.iter().map(|&count| usize::from(count)).sum();
    if total > 256 {
        let what = format!("a Huffman table of {total} codes has more than 256");
        return Err(malformed(at, what));
    }
    let mut symbols = Vec::with_capacity(total);
    for _ in 0..total {
        symbols.push(segment.byte("the symbols of a Huffman table")?);
    }
    let table = HuffmanTable { counts, symbols };
    match table.overfull_length() {
        Some(length) => Err(malformed(
            at,
            format!("a Huffman table has too many codes of {length} bits"),
        )),
        None => Ok(table),
    }
}
