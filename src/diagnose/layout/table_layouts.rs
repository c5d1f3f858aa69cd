//! Tables whose values a decoder looks for in other places than they stand.

use super::blocks::Block;
use super::indices::IndexBlock;
use crate::diagnose::witness::Witness;
use crate::ptm::{Format, Ptm};

/// The byte of value k of entry i, in a table of n entries of c values; one before the table wraps around.
type Layout = (&'static str, fn([usize; 4]) -> usize);

const LAYOUTS: &[Layout] = &[
    (
        "takes a table to have all first values, then all second ones, and so on",
        |[i, k, n, _]| k * n + i,
    ),
    (
        "takes a table of PTM_C_LUT to have all polynomials, then all colors",
        |[i, k, n, c]| match k {
            0..6 => 6 * i + k,
            _ => 6 * n + (c - 6) * i + k - 6,
        },
    ),
    (
        "takes a table of PTM_C_LUT to have all colors, then all polynomials",
        |[i, k, n, c]| match k {
            0..6 => (c - 6) * n + 6 * i + k,
            _ => (c - 6) * i + k - 6,
        },
    ),
    (
        "takes the entries of a table to be six bytes apart",
        |[i, k, ..]| 6 * i + k,
    ),
    (
        "takes the entries of a table to be nine bytes apart",
        |[i, k, ..]| 9 * i + k,
    ),
    (
        "takes the entries of a table to be one byte longer than they are",
        |[i, k, _, c]| (c + 1) * i + k,
    ),
    (
        "takes the entries of a table to be one byte shorter than they are",
        |[i, k, _, c]| (c - 1) * i + k,
    ),
    ("reads a table from one byte too late on", |[i, k, _, c]| {
        c * i + k + 1
    }),
    (
        "reads a table from one byte too early on",
        |[i, k, _, c]| (c * i + k).wrapping_sub(1),
    ),
    (
        "takes the polynomials of the entries of PTM_C_LUT to be six bytes apart, and their colors nine",
        |[i, k, ..]| if k < 6 { 6 * i + k } else { 9 * i + k },
    ),
    (
        "takes the values of an entry in reverse order",
        |[i, k, _, c]| c * i + c - 1 - k,
    ),
];

/// Another place of what a texel has from a table or beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum TableLayout {
    /// One of [`LAYOUTS`], by its place.
    Entries(usize),
    /// The colors of `PTM_LUT` are taken for those of entries, not of texels.
    ColorsByIndex(PastTexels),
}

/// What the color of a texel is taken from whose index is no number of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum PastTexels {
    /// What stands behind the colors: nothing.
    Zeros,
    Own,
    Modulo,
}

impl TableLayout {
    /// All that are tried.
    pub fn all() -> impl Iterator<Item = TableLayout> {
        let entries = (0..LAYOUTS.len()).map(TableLayout::Entries);
        let past = [PastTexels::Zeros, PastTexels::Own, PastTexels::Modulo];
        entries.chain(past.map(TableLayout::ColorsByIndex))
    }

    /// The values of every texel, from the bytes of the file; behind its end stand zeros.
    pub fn apply(self, ptm: &mut Ptm, witness: &Witness) {
        let (Some(indices), Some(table)) = (IndexBlock::of(witness), Block::Table.range(witness))
        else {
            return;
        };
        let colors = Block::Colors.range(witness).map(|range| range.start);
        let (extent, entries, size) = (
            indices.extent(ptm.planes.size),
            indices.entries().len(),
            indices.size,
        );
        let file = &witness.built.file;
        let texels = ptm.planes.size.texels();
        let count = ptm.planes.shape.channels();
        for (texel, samples) in ptm.planes.samples.chunks_exact_mut(count).enumerate() {
            let i = indices.stored(texel, extent);
            let byte = |at: usize| file.get(at).copied().unwrap_or_default();
            match (self, colors) {
                (TableLayout::Entries(layout), _) => {
                    for (k, value) in samples[..size].iter_mut().enumerate() {
                        let at = LAYOUTS[layout].1([i, k, entries, size]);
                        *value = byte(table.start.wrapping_add(at));
                    }
                }
                (TableLayout::ColorsByIndex(past), Some(colors)) if size == 6 => {
                    let of = match past {
                        _ if i < texels => i,
                        PastTexels::Zeros => i,
                        PastTexels::Own => continue,
                        PastTexels::Modulo => i % texels,
                    };
                    for (k, value) in samples[6..].iter_mut().enumerate() {
                        *value = byte(colors + 3 * of + k);
                    }
                }
                _ => {}
            }
        }
    }

    /// As a sentence without its subject.
    pub fn says(self) -> &'static str {
        match self {
            TableLayout::Entries(layout) => LAYOUTS[layout].0,
            TableLayout::ColorsByIndex(PastTexels::Zeros | PastTexels::Own) => {
                "takes the color of a texel of PTM_LUT from the place of its index among the colors"
            }
            TableLayout::ColorsByIndex(PastTexels::Modulo) => {
                "takes the color of a texel of PTM_LUT from the place of its index, modulo the number of texels, among the colors"
            }
        }
    }

    pub const fn fix(self) -> &'static str {
        match self {
            TableLayout::Entries(_) => {
                "entry i of PTM_LUT is the six bytes from 6 · i on, of PTM_C_LUT the nine bytes from 9 · i on"
            }
            TableLayout::ColorsByIndex(_) => {
                "the colors of PTM_LUT are those of texels, in their own order, and have nothing to do with the table"
            }
        }
    }

    pub const fn clause(self, format: Format) -> &'static str {
        match (self, format) {
            (TableLayout::ColorsByIndex(_), _) => "2.8.1/4",
            (_, Format::PtmLut) => "2.5/4",
            _ => "2.5/5",
        }
    }
}
