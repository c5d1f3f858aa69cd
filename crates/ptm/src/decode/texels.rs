//! §2.7 Uncompressed Per Texel Data
//!
//! One byte per value, without separators (clauses 2.7/1–2), in one to three *blocks*. Within a block, values are stored texel by
//! texel, with rows from bottom to top.
//!
//! - `RGB` (§2.7.1): blocks for red, green and blue, each with a0…a5 of every texel.
//! - `LUM` (§2.7.2): one block with a0…a5, Cr, Cb of every texel.
//! - `LRGB` (§2.7.3): a block with a0…a5, then a block with R, G, B.
//!
//! ```text
//! LRGB, one column, two rows:
//! 01 02 03 04 05 06     0B 0C 0D 0E 0F 10     a0 … a5 of the lower texel, of the upper texel
//! FF 00 00              00 00 FF              their colors: red, blue
//! ```
//!
//! Format notes
//! - The first byte of the first block directly follows the line feed of the last header line, regardless of its value.
//! - Blocks are not interleaved: all coefficients of all texels precede the first color. `PTM_1.1` interleaves the nine bytes of
//!   a texel, and some decoders derived from 1.1 decoders still expect this order.
//! - The six coefficients of a texel are adjacent in every uncompressed format. Only §2.9 has planes.
//! - This module defines the order of stored rows for all formats. `stored.rs` flips the rows.

use std::borrow::Cow;

use super::channels::{Channels, ValueLayout};
use crate::error::Result;
use crate::input::Input;
use crate::parts::Block;
use crate::reading::Reading;
use crate::types::{Format, Header, Shape, Storage};

/// Returns the blocks of a format in file order (clauses 2.7.1/1–2, 2.7.2/1, 2.7.3/1–2).
#[must_use]
pub fn blocks(format: Format) -> &'static [Block] {
    const fn block(channel: usize, channels: usize, clause: &'static str) -> Block {
        Block {
            channel,
            channels,
            clause,
        }
    }
    const RGB: [Block; 3] = [
        block(0, 6, "2.7.1/2"),
        block(6, 6, "2.7.1/2"),
        block(12, 6, "2.7.1/2"),
    ];
    match (format.storage(), format.shape()) {
        (Storage::Texels, Shape::Rgb) => &RGB,
        (Storage::Texels, Shape::Lum(())) => const { &[block(0, 8, "2.7.2/1")] },
        (Storage::Texels, Shape::Lrgb) => {
            const { &[block(0, 6, "2.7.3/1"), block(6, 3, "2.7.3/2")] }
        }
        // The colors follow the indices. In PTM_C_LUT, they are part of the table.
        (Storage::Table, _) => const { &[block(6, 3, "2.8.1/4")] },
        _ => &[],
    }
}

/// Returns the block that contains `channel`, and the index of the block.
#[must_use]
pub fn block_containing(format: Format, channel: usize) -> Option<(usize, &'static Block)> {
    let contains = |b: &Block| (b.channel..b.channel + b.channels).contains(&channel);
    (blocks(format).iter().enumerate()).find(|(_, block)| contains(block))
}

/// Converts `row`, which is counted from the top, to the index of the stored row. The bottom row is stored first (clauses
/// 2.7.1/3, 2.7.2/3, 2.7.3/3, 2.8.1/5, 2.8.2/4), including in compressed planes (clause 2.9.8/9, ruling `rows`).
#[must_use]
pub fn bottom_row_first(header: &Header, row: usize) -> usize {
    header.size.height as usize - 1 - row
}

/// Reads all blocks of the format.
pub(super) fn read<'a>(
    header: &Header,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<Vec<Channels<'a>>> {
    let read = |&block: &Block| {
        let bytes = header.size.bytes(block.channels);
        let bytes = input.take("2.7/1", "the texels", bytes);
        let bytes = bytes.map_err(|error| error.with_clause("2.7/3"))?;
        Ok(Channels {
            block,
            values: ValueLayout::Bytes(Cow::Borrowed(bytes)),
        })
    };
    (reading.blocks)(header.format).iter().map(read).collect()
}
