//! The runs of stored values in a file, and the clauses that place them.

use super::witness::Witness;
use crate::ptm::Format;

/// A run of stored values in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// Each of them.
    All,
    Red,
    Green,
    Blue,
    Coefficients,
    Colors,
    /// Those into a table.
    Indices,
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

    /// Where it begins in the file.
    pub fn start(self, witness: &Witness) -> Option<usize> {
        let name = match (self, witness.case.format()) {
            (Block::All, _) => return None,
            (Block::Red, _) => "red coefficients",
            (Block::Green, _) => "green coefficients",
            (Block::Blue, _) => "blue coefficients",
            (Block::Coefficients, Format::Lum) => "coefficients, Cr and Cb",
            (Block::Coefficients, _) => "coefficients",
            (Block::Colors, _) => "colors",
            (Block::Indices, _) => "indices",
        };
        let mut fields = witness.built.fields.iter();
        fields
            .find(|field| field.name == name)
            .map(|field| field.range.start)
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
        }
    }
}

/// The clause of the order of values of one texel.
pub(super) const fn texel_clause(format: Format) -> Option<&'static str> {
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
pub(super) const fn row_clause(format: Format) -> Option<&'static str> {
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
pub(super) const fn block_clause(format: Format, block: Block) -> Option<&'static str> {
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
