//! Parts of a file (§2.7, §2.8, §2.9.8): each contains some channels of every texel
//!
//! A file stores its values in up to eighteen parts: blocks of a few channels (2.7), indices of table entries (2.8), or planes
//! (2.9.8). Each part contains some channels of every texel, row by row, in the order in which the rows are stored.
//!
//! ```text
//! RGB            0…5  6…11  12…17          three blocks
//! LUM            0…7                       one block
//! LRGB           0…5  6…8                  two blocks
//! PTM_LUT        0…5  6…8                  indices into a table of six, one block
//! PTM_C_LUT      0…8                       indices into a table of nine
//! JPEG_RGB …     0  1  2  3  …  17         one plane each
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
    /// Plain bytes, one per value.
    Bytes(Cow<'a, [u8]>),
    /// Indices of table entries. Every index is valid.
    Entries(IndexBlock<'a>, LookupTable<'a>),
}

impl Channels<'_> {
    /// Returns the values of the texel with stored index `i`.
    pub fn texel_values(&self, i: usize, reading: &Reading) -> &[u8] {
        match &self.values {
            ValueLayout::Bytes(bytes) => &bytes[i * self.block.channels..][..self.block.channels],
            ValueLayout::Entries(indices, table) => {
                let entry =
                    table_entry(indices, table, i, reading).expect("every index was checked");
                &table.bytes[entry * table.entry_size..][..table.entry_size]
            }
        }
    }

    /// Copies the values of the stored texels in `run` into `texels`, which has `size` samples per texel.
    pub fn copy_to(&self, run: Range<usize>, texels: &mut [u8], size: usize, reading: &Reading) {
        for (i, texel) in run.zip(texels.chunks_exact_mut(size)) {
            let values = self.texel_values(i, reading);
            texel[self.block.channel..][..values.len()].copy_from_slice(values);
        }
    }

    /// Returns the number of bytes of memory that this part needs in addition to the file.
    pub fn owned_bytes(&self) -> usize {
        match &self.values {
            ValueLayout::Bytes(Cow::Owned(bytes)) => bytes.len(),
            _ => 0,
        }
    }
}

/// Returns the index of the table entry for a stored texel, or `None` if the index is out of range.
pub(super) fn table_entry(
    indices: &IndexBlock,
    table: &LookupTable,
    texel: usize,
    reading: &Reading,
) -> Option<usize> {
    let index = (reading.index)(&indices.bytes[texel * indices.width..][..indices.width]);
    (reading.entry)(index, table.entries).filter(|&entry| entry < table.entries)
}
