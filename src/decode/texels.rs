//! §2.7 Uncompressed Per Texel Data
//!
//! One byte for each value and nothing between them (clauses 2.7/1–2), in one to three *blocks*; within a block texel
//! after texel, rows from bottom to top.
//!
//! - `RGB` (§2.7.1): a block for red, one for green, one for blue, each a0…a5 of every texel.
//! - `LUM` (§2.7.2): one block, a0…a5, Cr, Cb of every texel.
//! - `LRGB` (§2.7.3): a block of a0…a5, then a block of R, G, B.
//!
//! Format notes
//! - The first byte of the first block follows the last header line's line feed, whatever byte it is.
//! - Which stored row is which row of the picture is said here, for all formats; rows are turned in [`super::stored`].

use std::borrow::Cow;

use super::stored::{Part, Values};
use super::{Header, Input};
use crate::error::Result;
use crate::ptm::Format;
use crate::reading::Reading;

/// A run of bytes that holds some channels of every texel.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The first of its channels.
    pub channel: usize,
    /// How many channels, side by side.
    pub channels: usize,
}

/// The blocks of a format in the order of the file (clauses 2.7.1/1–2, 2.7.2/1, 2.7.3/1–2).
pub(crate) fn blocks(format: Format) -> &'static [Block] {
    const fn block(channel: usize, channels: usize) -> Block {
        Block { channel, channels }
    }
    match format {
        Format::Rgb => const { &[block(0, 6), block(6, 6), block(12, 6)] },
        Format::Lum => const { &[block(0, 8)] },
        Format::Lrgb => const { &[block(0, 6), block(6, 3)] },
        // The colours that follow the indices (clause 2.8.1/4); a PTM_C_LUT has them in its table.
        Format::PtmLut => const { &[block(6, 3)] },
        _ => &[],
    }
}

/// Which stored row holds row `row` from the top: the bottom row is stored first (clauses 2.7.1/3, 2.7.2/3, 2.7.3/3, 2.8.1/5, 2.8.2/4).
///
/// `part` counts the blocks of the payload, indices first where there are any; for the compressed formats, whose planes
/// lie the same way (ruling `rows`), it is the plane.
pub(crate) fn bottom_row_first(_: Format, _part: usize, row: usize, height: usize) -> usize {
    height - 1 - row
}

/// The blocks of the format and their bytes.
pub(super) fn read<'a>(
    header: &Header,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<Vec<Part<'a>>> {
    let one = |&Block { channel, channels }: &Block| {
        let bytes = header.size.texels().saturating_mul(channels);
        let bytes = input.take("2.7/1", "the texels", bytes)?;
        Ok(Part {
            channel,
            channels,
            values: Values::Bytes(Cow::Borrowed(bytes)),
        })
    };
    (reading.blocks)(header.format).iter().map(one).collect()
}
