//! Some channels of every texel: the common representation of the parts of §2.7, §2.8 and §2.9.8
//!
//! A file stores its values in up to eighteen parts: blocks of a few channels (2.7), indices of table entries (2.8), or planes
//! (2.9.8). Each part contains some channels of every texel, row by row, in the order in which the rows are stored.
//!
//! ```text
//! RGB            0…5  6…11  12…17          three blocks
//! LUM            0…7                       one block
//! LRGB           0…5  6…8                  two blocks
//! PTM_LUT        0…5  6…8                  indices into a table of six, a block
//! PTM_C_LUT      0…8                       indices into a table of nine
//! JPEG_RGB …     0  1  2  3  …  17         a plane each
//! ```

use std::borrow::Cow;
use std::ops::Range;

use crate::parts::{Block, IndexBlock, LookupTable};
use crate::reading::Reading;

/// A part of the file: some channels of every texel.
pub(super) struct Channels<'a> {
    /// Channels in this part.
    pub block: Block,
    /// Values of these channels.
    pub values: ValueLayout<'a>,
}

/// Representation of the values, texel by texel, in the stored order of rows.
pub(super) enum ValueLayout<'a> {
    /// Plain bytes.
    Bytes(Cow<'a, [u8]>),
    /// Table entries. Every index has been checked.
    Entries(IndexBlock<'a>, LookupTable<'a>),
}

impl Channels<'_> {
    /// Returns the values of the texel with stored index `at`.
    pub fn texel_values(&self, at: usize, reading: &Reading) -> &[u8] {
        match &self.values {
            ValueLayout::Bytes(bytes) => &bytes[at * self.block.channels..][..self.block.channels],
            ValueLayout::Entries(indices, table) => {
                let entry =
                    table_entry(indices, table, at, reading).expect("every index was checked");
                &table.bytes[entry * table.entry_size..][..table.entry_size]
            }
        }
    }

    /// Copies the values of the stored texels in `run` into `texels`, which has `size` samples per texel.
    pub fn copy_to(&self, run: Range<usize>, texels: &mut [u8], size: usize, reading: &Reading) {
        for (at, texel) in run.zip(texels.chunks_exact_mut(size)) {
            let values = self.texel_values(at, reading);
            texel[self.block.channel..][..values.len()].copy_from_slice(values);
        }
    }

    /// Returns the number of bytes that this part occupies in addition to the file.
    pub fn held_bytes(&self) -> usize {
        match &self.values {
            ValueLayout::Bytes(Cow::Owned(bytes)) => bytes.len(),
            _ => 0,
        }
    }
}

/// Returns the index of the table entry for the stored texel `at`, or `None` if there is no such entry.
pub(super) fn table_entry(
    indices: &IndexBlock,
    table: &LookupTable,
    at: usize,
    reading: &Reading,
) -> Option<usize> {
    let index = (reading.index)(&indices.bytes[at * indices.width..][..indices.width]);
    (reading.entry)(index, table.entries).filter(|&entry| entry < table.entries)
}
