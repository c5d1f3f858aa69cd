//! T.81 E.2.3, E.2.4: decoding all blocks of a scan, in independent intervals
//!
//! Worked example: two intervals of one block each, with the DC codes 00 for size 0 and 01 for size 4, and the AC
//! code 0 for the end of the block.
//!
//! ```text
//! 61      01 1000 0 1    DC difference 8, end of block, padding
//! FF D0                  RST0
//! 61      01 1000 0 1    DC difference 8 from 0, not from the previous block
//! ```
//!
//! Format notes
//! - A scan of one component has its blocks in plain raster order, and one block is one MCU, regardless of the
//!   sampling factors of the component (A.2.2). A restart interval counts these blocks.
//! - The blocks of the last column and row may extend past the image. Samples outside are dropped (A.2.4). An image
//!   of 9 × 9 samples has four blocks.
//! - A restart marker separates two intervals and resets the DC prediction to 0. The markers cycle from RST0 to RST7.
//!   No marker follows the last interval.

use super::decode_block::decode_block;
use super::huffman::ReadSymbols;
use super::huffman_table::HuffmanTable;
use super::{narrow_dct::fast_inverse_dct, processes::unexpected_marker};
use crate::codec::headers::allocate_samples;
use crate::codec::markers::{Cursor, RST0};
use crate::codec::stream_error::StreamResult;

pub(super) struct ScanTables {
    /// Quantization steps in zigzag order.
    pub quantization: [u16; 64],
    pub dc: HuffmanTable,
    pub ac: HuffmanTable,
    /// Number of blocks between restart markers, or 0 for no restart markers.
    pub restart_interval: u16,
}

/// Decodes the entropy-coded data that starts at the cursor. Leaves the cursor at the marker that ends the data.
pub(super) fn decode_scan<'a, B: ReadSymbols<'a>>(
    stream: &mut Cursor<'a>,
    tables: &ScanTables,
    width: u32,
    height: u32,
) -> StreamResult<Vec<u8>> {
    let columns = width.div_ceil(8) as usize;
    let blocks = columns * height.div_ceil(8) as usize;
    let interval = match tables.restart_interval {
        0 => blocks,
        interval => usize::from(interval),
    };
    // A code has at least one bit, and a block has at least a DC code and an end of block.
    let mut samples = allocate_samples(stream, width, height, 2 * blocks as u64)?;
    let (dc, ac) = (B::Table::from(&tables.dc), B::Table::from(&tables.ac));
    let mut bits = B::new(stream.stream, stream.at);
    let mut previous_dc = 0;
    for block in 0..blocks {
        if block > 0 && block % interval == 0 {
            let number = (block / interval - 1) % 8;
            bits = B::new(stream.stream, read_restart(&bits, number as u8)?);
            previous_dc = 0;
        }
        let steps = &tables.quantization;
        let coefficients = decode_block(&mut bits, &dc, &ac, steps, &mut previous_dc)?;
        let decoded = fast_inverse_dct(&coefficients); // plain version: inverse_dct
        let (x, y) = (block % columns * 8, block / columns * 8);
        copy_block(&mut samples, width as usize, x, y, &decoded);
    }
    stream.at = bits.plain_bits().finish()?;
    Ok(samples)
}

/// Checks the end of an interval and the number of its restart marker (E.2.4). Returns the offset of the next interval.
fn read_restart<'a>(bits: &impl ReadSymbols<'a>, number: u8) -> StreamResult<usize> {
    let bits = bits.plain_bits();
    let mut stream = Cursor::new(bits.stream, bits.finish()?);
    let marker = stream.read_marker()?;
    if marker.code != RST0 + number {
        let expected = format!("restart marker {number}");
        return Err(unexpected_marker(marker, &expected));
    }
    Ok(stream.at)
}

/// Copies the part of a block that is inside the image. (x, y) is the position of the top-left sample.
fn copy_block(samples: &mut [u8], width: usize, x: usize, y: usize, block: &[u8; 64]) {
    let visible = (width - x).min(8);
    let rows = samples.chunks_exact_mut(width).skip(y);
    for (row, decoded) in rows.zip(block.chunks_exact(8)) {
        row[x..x + visible].copy_from_slice(&decoded[..visible]);
    }
}
