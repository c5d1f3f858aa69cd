//! §2.8 Lookup Table Indices
//!
//! One index per texel: one byte if the table has at most 256 entries (clauses 2.8.1/2, 2.8.2/2), or two bytes, low
//! byte first, if it has more (clauses 2.8.1/3, 2.8.2/3). Rows are stored from bottom to top. In `PTM_LUT`, R, G, B
//! of every texel follow (2.8.1/4).
//!
//! ```text
//! 256 entries:   00 FF 07            entries 0, 255 and 7
//! 257 entries:   00 00 FF 00 00 01   entries 0, 255 and 256
//! ```
//!
//! Format notes
//! - The width of an index depends on the number of entries, not on the largest index in the file.
//! - An index equal to the number of entries is already out of range (ruling `lut-range`).
//! - 257 is the smallest count with two-byte indices, and the smallest whose last index reveals the byte order.
//! - The colors of `PTM_LUT` follow the indices of *all* texels. They are not interleaved (clause 2.8.1/4).
//! - Check every index before decoding the first texel, so that a file is either rejected or completely decoded.

use super::channels::{Channels, ValueLayout, table_entry};
use super::texels;
use crate::error::{Error, Kind, Result};
use crate::input::Input;
use crate::parts::{Block, IndexBlock, LookupTable};
use crate::reading::Reading;
use crate::types::{Header, Size};

pub(super) fn read<'a>(
    header: &Header,
    table: LookupTable<'a>,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<Vec<Channels<'a>>> {
    // Offset of the first index, for errors.
    let start = input.at();
    let indices = (reading.indices)(&table, header.size, input)?;
    let colors = texels::read(header, input, reading)?;
    check_indices(&indices, &table, start, reading)?;
    let coefficients = Channels {
        block: Block {
            channel: 0,
            channels: table.entry_size,
            clause: "2.8.1/1",
        },
        values: ValueLayout::Entries(indices, table),
    };
    Ok(std::iter::once(coefficients).chain(colors).collect())
}

/// Checks that each index refers to an entry (clause 2.8/1). `start` is the offset of the first index, for errors.
fn check_indices(
    indices: &IndexBlock,
    table: &LookupTable,
    start: usize,
    reading: &Reading,
) -> Result<()> {
    let stored = indices.bytes.chunks_exact(indices.width);
    for (texel, index) in stored.enumerate() {
        if table_entry(indices, table, texel, reading).is_none() {
            let kind = Kind::IndexOutOfRange {
                index: (reading.index)(index),
                entries: table.entries,
            };
            return Err(Error::new("2.8/1", start + texel * indices.width, kind));
        }
    }
    Ok(())
}

/// Reads one-byte indices if there are at most 256 entries (clauses 2.8.1/2, 2.8.2/2), or else two-byte indices (clauses 2.8.1/3,
/// 2.8.2/3).
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn read_indices<'a>(
    table: &LookupTable,
    size: Size,
    input: &mut Input<'a>,
) -> Result<IndexBlock<'a>> {
    read_indices_of_width(if table.entries <= 256 { 1 } else { 2 }, size, input)
}

/// Reads one index of `width` bytes per texel.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn read_indices_of_width<'a>(
    width: usize,
    size: Size,
    input: &mut Input<'a>,
) -> Result<IndexBlock<'a>> {
    let bytes = input.take("2.8.1/1", "the indices", size.bytes(width))?;
    Ok(IndexBlock { bytes, width })
}

/// Decodes an index, low byte first (clauses 1.0/3, 2.8.1/3, 2.8.2/3).
#[must_use]
pub fn little_endian(stored: &[u8]) -> usize {
    stored
        .iter()
        .rev()
        .fold(0, |index, &byte| index << 8 | usize::from(byte))
}

/// Returns the entry for an index, or `None` if the index is out of range (ruling `lut-range`).
#[must_use]
pub fn valid_entry(index: usize, entries: usize) -> Option<usize> {
    (index < entries).then_some(index)
}
