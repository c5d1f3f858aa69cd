//! The runs of stored values in a file, and the clauses that place them.

use std::ops::Range;

use crate::diagnose::witness::Witness;
use crate::ptm::Format;

/// A run of stored values in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum Block {
    /// Each of them.
    All,
    Red,
    Green,
    Blue,
    Coefficients,
    Colors,
    /// Those into a table.
    Indices,
    /// The entries of a table.
    Table,
    /// Each of them, as if a row of one were followed by the same row of the next.
    Alternating,
}

/// Where some channels of every texel are looked for in the file.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Part {
    /// The byte of the first of them, of the first texel.
    pub start: usize,
    /// The first of the channels, and their number.
    pub first: usize,
    pub channels: usize,
    /// Bytes from a row to the next.
    pub row: usize,
}

impl Block {
    /// The blocks of a format and the channels of each.
    pub fn of(format: Format) -> &'static [(Block, usize, usize)] {
        match format {
            Format::Rgb => &[
                (Block::Red, 0, 6),
                (Block::Green, 6, 6),
                (Block::Blue, 12, 6),
            ],
            Format::Lum => &[(Block::Coefficients, 0, 8)],
            Format::Lrgb => &[(Block::Coefficients, 0, 6), (Block::Colors, 6, 3)],
            Format::PtmLut => &[(Block::Colors, 6, 3)],
            _ => &[],
        }
    }

    /// Its bytes in a file, which may be put together by hand.
    pub fn range(self, witness: &Witness) -> Option<Range<usize>> {
        let (what, place) = match self {
            Block::All | Block::Alternating => return None,
            Block::Table => ("the table's entries", 0),
            Block::Indices => ("the indices", 0),
            Block::Colors if witness.case.format() == Format::PtmLut => ("the texels", 0),
            Block::Red | Block::Coefficients => ("the texels", 0),
            Block::Green | Block::Colors => ("the texels", 1),
            Block::Blue => ("the texels", 2),
        };
        let mut fields = witness.fields().iter().filter(|field| field.name == what);
        fields.nth(place).map(|field| field.range.clone())
    }

    /// Where its channels are looked for in a file with rows of so many texels.
    pub fn parts(self, witness: &Witness, width: usize) -> Vec<Part> {
        let blocks = Block::of(witness.case.format());
        if self == Block::Alternating {
            let first = blocks.first().and_then(|(block, ..)| block.range(witness));
            let mut start = first.map_or(usize::MAX, |range| range.start);
            let row = blocks.iter().map(|(.., channels)| channels * width).sum();
            let part = |&(_, first, channels): &(Block, usize, usize)| {
                let part = Part {
                    start,
                    first,
                    channels,
                    row,
                };
                start = start.saturating_add(channels * width);
                part
            };
            return blocks.iter().map(part).collect();
        }
        let of = (blocks.iter()).filter(|(block, ..)| self == Block::All || *block == self);
        let part = |&(block, first, channels): &(Block, usize, usize)| {
            Some(Part {
                start: block.range(witness)?.start,
                first,
                channels,
                row: channels * width,
            })
        };
        of.filter_map(part).collect()
    }

    pub const fn name(self) -> &'static str {
        match self {
            Block::All => "every block of values",
            Block::Red => "the block of red",
            Block::Green => "the block of green",
            Block::Blue => "the block of blue",
            Block::Coefficients => "the block of coefficients",
            Block::Colors => "the block of colors",
            Block::Indices => "the block of indices",
            Block::Table => "the table",
            Block::Alternating => "blocks of which a row is followed by the same row of the next",
        }
    }
}

/// The clause of the order of values of one texel.
pub(in crate::diagnose) const fn texel_clause(format: Format) -> Option<&'static str> {
    match format {
        Format::Rgb => Some("2.7.1/1"),
        Format::Lum => Some("2.7.2/1"),
        Format::Lrgb => Some("2.7.3/1"),
        Format::PtmLut => Some("2.5/4"),
        Format::PtmCLut => Some("2.5/5"),
        _ => None,
    }
}

/// The clause of the order of rows.
pub(in crate::diagnose) const fn row_clause(format: Format) -> Option<&'static str> {
    match format {
        Format::Rgb => Some("2.7.1/3"),
        Format::Lum => Some("2.7.2/3"),
        Format::Lrgb => Some("2.7.3/3"),
        Format::PtmLut => Some("2.8.1/5"),
        Format::PtmCLut => Some("2.8.2/4"),
        _ => None,
    }
}

/// The clause of where a block stands and what is in it.
pub(in crate::diagnose) const fn block_clause(
    format: Format,
    block: Block,
) -> Option<&'static str> {
    match (format, block) {
        (Format::PtmLut, Block::Indices) => Some("2.8.1/1"),
        (Format::PtmCLut, Block::Indices) => Some("2.8.2/1"),
        (Format::Rgb, _) => Some("2.7.1/2"),
        (Format::Lum, _) => Some("2.7.2/1"),
        (Format::Lrgb, Block::Colors) => Some("2.7.3/2"),
        (Format::Lrgb, _) => Some("2.7.3/1"),
        (Format::PtmLut, _) => Some("2.8.1/4"),
        _ => None,
    }
}
