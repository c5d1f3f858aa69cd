//! §2.7 Uncompressed Per Texel Data
//!
//! One byte for each value, without separators (clauses 2.7/1–2), in one to three *blocks*; within
//! a block texel after texel, rows from bottom to top.
//!
//! - `RGB` (§2.7.1): a block for red, one for green, one for blue, each a0…a5 of every texel.
//! - `LUM` (§2.7.2): one block, a0…a5, Cr, Cb of every texel.
//! - `LRGB` (§2.7.3): a block of a0…a5, then a block of R, G, B.
//!
//! ```text
//! LRGB, one column, two rows:
//! 01 02 03 04 05 06     0B 0C 0D 0E 0F 10     a0 … a5 of the lower texel, of the upper texel
//! FF 00 00              00 00 FF              its color: red; blue
//! ```
//!
//! Format notes
//! - The first byte of the first block follows the last header line's line feed, whatever its value.
//! - Blocks are whole: all coefficients of all texels precede the first color. `PTM_1.1` interleaved the nine bytes of
//!   a texel, and readers derived from readers of 1.1 still do.
//! - The six coefficients of a texel are adjacent in every uncompressed format; only §2.9 has planes.
//! - The map from stored rows to image rows is decided here, for all formats; rows are turned in [`super::stored`].

use std::borrow::Cow;

use super::channels::{Channels, ValueLayout};
use crate::error::Result;
use crate::input::Input;
use crate::parts::Block;
use crate::ptm::{Format, Header, Shape, Storage};
use crate::reading::Reading;

/// Returns the blocks of a format in the order of the file (clauses 2.7.1/1–2, 2.7.2/1, 2.7.3/1–2).
pub(crate) fn blocks(format: Format) -> &'static [Block] {
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
        // The colors after the indices; a PTM_C_LUT has them in its table.
        (Storage::Table, _) => const { &[block(6, 3, "2.8.1/4")] },
        _ => &[],
    }
}

/// Returns the block of a format that has channel `channel`, and its number.
#[cfg(feature = "harness")]
#[cfg_attr(
    not(unix),
    allow(dead_code, reason = "its callers need Unix or the program")
)]
pub(crate) fn block_of(format: Format, channel: usize) -> Option<(usize, &'static Block)> {
    let has = |block: &Block| (block.channel..block.channel + block.channels).contains(&channel);
    (blocks(format).iter().enumerate()).find(|(_, block)| has(block))
}

/// Returns the stored row for row `row` from the top: the bottom row is stored first (clauses 2.7.1/3, 2.7.2/3, 2.7.3/3,
/// 2.8.1/5, 2.8.2/4), in compressed planes too (clause 2.9.8/9, ruling `rows`).
pub(crate) fn bottom_row_first(header: &Header, row: usize) -> usize {
    header.size.height as usize - 1 - row
}

/// Reads the blocks of the format.
pub(super) fn read<'a>(
    header: &Header,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<Vec<Channels<'a>>> {
    let one = |&block: &Block| {
        let bytes = header.size.bytes(block.channels);
        let bytes = input.take("2.7/1", "the texels", bytes);
        let bytes = bytes.map_err(|error| error.with_clause("2.7/3"))?;
        Ok(Channels {
            block,
            values: ValueLayout::Bytes(Cow::Borrowed(bytes)),
        })
    };
    (reading.blocks)(header.format).iter().map(one).collect()
}
