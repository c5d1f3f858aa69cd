//! §2.8 Lookup Table Indices
//!
//! An index for every texel, one byte each where the table has at most 256 entries (clauses 2.8.1/2, 2.8.2/2), else two,
//! low byte first (clauses 2.8.1/3, 2.8.2/3); rows from bottom to top. `PTM_LUT` then has R, G, B of every texel (2.8.1/4).
//!
//! Format notes
//! - The number of entries decides the width, not the largest index that occurs.
//! - An index equal to the number of entries is already out of range (ruling `lut-range`).

use super::lookup_table::LookupTable;
use super::texels::{self, Block};
use super::{Header, Input, Limits, blank};
use crate::error::{Error, Kind, Result};
use crate::ptm::{Format, Planes, Shape};
use crate::reading::Reading;

pub(super) fn read(
    header: &Header,
    table: &LookupTable,
    input: &mut Input,
    reading: &Reading,
    limits: &Limits,
) -> Result<Planes> {
    let count = header.size.texels();
    let width = (reading.index_width)(header.format, table.entries, input.rest(), count);
    let start = input.at();
    let stored = input.take("2.8.1/1", "the indices", count.saturating_mul(width))?;
    let colors = texels::read_blocks(header, input, reading)?;

    let mut planes = blank(header, Shape::Lrgb, limits, input)?;
    let mut entries = vec![0; count * table.entry_size];
    for (i, (index, entry)) in stored
        .chunks_exact(width)
        .zip(entries.chunks_exact_mut(table.entry_size))
        .enumerate()
    {
        let index = (reading.index)(index);
        let found = (reading.entry)(index, table.entries).and_then(|index| {
            table
                .bytes
                .get(index * table.entry_size..)?
                .get(..table.entry_size)
        });
        match found {
            Some(found) => entry.copy_from_slice(found),
            None => {
                return Err(Error::new(
                    "2.8/1",
                    start + i * width,
                    Kind::IndexOutOfRange {
                        index,
                        entries: table.entries,
                    },
                ));
            }
        }
    }

    let looked_up = Block {
        channel: 0,
        channels: table.entry_size,
    };
    let blocks = std::iter::once((looked_up, &entries[..])).chain(colors);
    for (part, (block, bytes)) in blocks.enumerate() {
        texels::place(bytes, block, &mut planes, |row, height| {
            (reading.stored_row)(header.format, part, row, height)
        });
    }
    Ok(planes)
}

/// Bytes of an index (clauses 2.8.1/2–3, 2.8.2/2–3).
pub(crate) fn width(_: Format, entries: usize, _stored: &[u8], _texels: usize) -> usize {
    if entries <= 256 { 1 } else { 2 }
}

/// Low byte first (clauses 1.0/3, 2.8.1/3, 2.8.2/3).
pub(crate) fn little_endian(stored: &[u8]) -> usize {
    stored
        .iter()
        .rev()
        .fold(0, |index, &byte| index << 8 | usize::from(byte))
}

/// The entry an index names, if there is one (ruling `lut-range`).
pub(crate) fn entry(index: usize, entries: usize) -> Option<usize> {
    (index < entries).then_some(index)
}
