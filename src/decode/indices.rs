//! §2.8 Lookup Table Indices
//!
//! An index for every texel, one byte each where the table has at most 256 entries (clauses 2.8.1/2, 2.8.2/2), else two,
//! low byte first (clauses 2.8.1/3, 2.8.2/3); rows from bottom to top. `PTM_LUT` then has R, G, B of every texel (2.8.1/4).
//!
//! Format notes
//! - The number of entries decides the width, not the largest index that occurs.
//! - An index equal to the number of entries is already out of range (ruling `lut-range`).

use std::ops::Range;

use super::lookup_table::LookupTable;
use super::stored::{Part, Values};
use super::texels;
use super::{Header, Input};
use crate::error::{Error, Kind, Result};
use crate::ptm::Format;
use crate::reading::Reading;

/// Indices that all name entries of a table.
pub(super) struct Indices<'a> {
    /// `width` bytes for each texel.
    stored: &'a [u8],
    width: usize,
    table: LookupTable<'a>,
}

pub(super) fn read<'a>(
    header: &Header,
    table: LookupTable<'a>,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<Vec<Part<'a>>> {
    let count = header.size.texels();
    let width = (reading.index_width)(header.format, table.entries, input.rest(), count);
    let start = input.at();
    let stored = input.take("2.8.1/1", "the indices", count.saturating_mul(width))?;
    let colors = texels::read(header, input, reading)?;

    let entry_size = table.entry_size;
    let indices = Indices {
        stored,
        width,
        table,
    };
    indices.check(start, reading)?;
    let looked_up = Part {
        channel: 0,
        channels: entry_size,
        values: Values::Indices(indices),
    };
    Ok(std::iter::once(looked_up).chain(colors).collect())
}

impl Indices<'_> {
    /// Whether each index names an entry; `start` is where they start, for the error.
    fn check(&self, start: usize, reading: &Reading) -> Result<()> {
        let mut indices = self.stored.chunks_exact(self.width);
        match indices.position(|index| self.entry(index, reading).is_none()) {
            None => Ok(()),
            Some(i) => Err(Error::new(
                "2.8/1",
                start + i * self.width,
                Kind::IndexOutOfRange {
                    index: (reading.index)(&self.stored[i * self.width..][..self.width]),
                    entries: self.table.entries,
                },
            )),
        }
    }

    /// The number of the entry that a stored index names, if there is one.
    fn entry(&self, index: &[u8], reading: &Reading) -> Option<usize> {
        let entries = self.table.entries;
        (reading.entry)((reading.index)(index), entries).filter(|&entry| entry < entries)
    }

    /// Puts the entries of some stored texels at the front of `texels`, which have `size` channels each.
    pub fn read(&self, run: Range<usize>, texels: &mut [u8], size: usize, reading: &Reading) {
        match self.table.entry_size {
            6 => self.read_entries::<6>(run, texels, size, reading),
            _ => self.read_entries::<9>(run, texels, size, reading),
        }
    }

    fn read_entries<const N: usize>(
        &self,
        run: Range<usize>,
        texels: &mut [u8],
        size: usize,
        reading: &Reading,
    ) {
        let entries = self.table.bytes.as_chunks::<N>().0;
        let indices = &self.stored[run.start * self.width..run.end * self.width];
        for (texel, index) in texels
            .chunks_exact_mut(size)
            .zip(indices.chunks_exact(self.width))
        {
            let entry = self.entry(index, reading).expect("all were checked");
            texel[..N].copy_from_slice(&entries[entry]);
        }
    }
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
