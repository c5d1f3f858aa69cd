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
//! - Rows are turned here and nowhere else; all after this counts from the top.

use super::{Header, Input, Limits, blank};
use crate::error::Result;
use crate::ptm::{Format, Planes, Shape};
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

pub(super) fn read(
    header: &Header,
    shape: Shape,
    input: &mut Input,
    reading: &Reading,
    limits: &Limits,
) -> Result<Planes> {
    let stored = read_blocks(header, input, reading)?;
    let mut planes = blank(header, shape, limits, input)?;
    for (part, &(block, bytes)) in stored.iter().enumerate() {
        place(bytes, block, &mut planes, |row, height| {
            (reading.stored_row)(header.format, part, row, height)
        });
    }
    Ok(planes)
}

/// The blocks of the format and their bytes.
pub(super) fn read_blocks<'a>(
    header: &Header,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<Vec<(Block, &'a [u8])>> {
    let one = |&block: &Block| {
        let bytes = header.size.texels().saturating_mul(block.channels);
        Ok((block, input.take("2.7/1", "the texels", bytes)?))
    };
    (reading.blocks)(header.format).iter().map(one).collect()
}

/// Puts the bytes of a block where they belong in `planes`.
pub(super) fn place(
    bytes: &[u8],
    block: Block,
    planes: &mut Planes,
    stored_row: impl Fn(usize, usize) -> usize,
) {
    let (width, height) = (planes.size.width as usize, planes.size.height as usize);
    let row_bytes = width * block.channels;
    let texel_bytes = planes.shape.channels();
    for (row, samples) in planes
        .samples
        .chunks_exact_mut(width * texel_bytes)
        .enumerate()
    {
        let stored = &bytes[stored_row(row, height) * row_bytes..][..row_bytes];
        for (texel, values) in samples
            .chunks_exact_mut(texel_bytes)
            .zip(stored.chunks_exact(block.channels))
        {
            texel[block.channel..][..block.channels].copy_from_slice(values);
        }
    }
}

/// Puts planes, one a channel, where they belong in `out`; row by row, so that the row being made stays at hand.
pub(super) fn interleave(
    stored: &[Vec<u8>],
    out: &mut Planes,
    stored_row: impl Fn(usize, usize, usize) -> usize,
) {
    let (width, height) = (out.size.width as usize, out.size.height as usize);
    let channels = out.shape.channels();
    for (row, samples) in out.samples.chunks_exact_mut(width * channels).enumerate() {
        for (channel, plane) in stored.iter().enumerate() {
            let values = &plane[stored_row(channel, row, height) * width..][..width];
            for (texel, &value) in samples.chunks_exact_mut(channels).zip(values) {
                texel[channel] = value;
            }
        }
    }
}
