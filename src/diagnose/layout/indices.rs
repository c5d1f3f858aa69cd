//! Wrong entries of a table: where a decoder looks for an index, and what it makes of it.

use std::sync::LazyLock;

use super::blocks::Block;
use super::strides::{Extent, Strides};
use crate::diagnose::values::changes::{Change, Values, short};
use crate::diagnose::values::grid::{self, Places};
use crate::diagnose::witness::Witness;
use crate::protocol::frame::Answer;
use crate::ptm::{Format, Ptm, Size};
use crate::session::observation::Response;

/// What is made of an index.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::diagnose) enum Index {
    /// Something of the right one.
    Changed(Change),
    /// Something of its two bytes: a place in [`JOINS`], one in [`OFFSETS`] and one in [`LIMITS`].
    Joined(Places<3>),
    /// One of [`RULES`], by its place.
    Rule(usize),
    /// The number of texels, not of entries, decides whether it has one byte or two.
    WidthByTexels,
    /// Two bytes in tables of so many entries and more, one in those of so many and fewer; no file lies between them.
    WidthFrom { from: usize, below: usize },
}

/// What is looked up instead of index i of n entries, in words and as a function.
const RULES: &[(&str, fn(i64, i64) -> i64)] = &[
    ("the entry before it, and for index 0 the first", |i, _| {
        (i - 1).max(0)
    }),
    ("the entry before it, and for index 0 the last", |i, n| {
        (i + n - 1) % n
    }),
    (
        "the entry behind it, and for the last index the last",
        |i, n| (i + 1).min(n - 1),
    ),
    (
        "the entry behind it, and for the last index the first",
        |i, n| (i + 1) % n,
    ),
    ("entries from the end of the table", |i, n| n - 1 - i),
    ("the index modulo the number of entries less 1", |i, n| {
        i % (n - 1).max(1)
    }),
    ("the index modulo 255", |i, _| i % 255),
    ("the index modulo 256", |i, _| i % 256),
    ("the index modulo 128", |i, _| i % 128),
    (
        "the first entry for indices over 127 of one byte, taken for negative,",
        |i, n| if n <= 256 && i > 127 { 0 } else { i },
    ),
    (
        "no entry, and shows 0, for indices over 127 of one byte, taken for negative,",
        |i, n| if n <= 256 && i > 127 { -1 } else { i },
    ),
    (
        "no entry, and shows 0, for index 255 of one byte",
        |i, n| if n <= 256 && i == 255 { -1 } else { i },
    ),
    ("the entry before the last for the last index", |i, n| {
        if i == n - 1 { (i - 1).max(0) } else { i }
    }),
    ("the first entry for the last index", |i, n| {
        if i == n - 1 { 0 } else { i }
    }),
    (
        "the second entry for index 0, and the first for index 1,",
        |i, n| {
            if i < 2 && n > 1 { 1 - i } else { i }
        },
    ),
    ("half the index", |i, _| i / 2),
    ("twice the index", |i, _| i * 2),
    ("the index with its lowest bit changed", |i, _| i ^ 1),
    ("the first entry, whatever the index", |_, _| 0),
];

/// How two bytes may be joined to one index; low + high · 256 is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Join {
    /// low + high · factor
    Sum(i64),
    /// low | high << bits
    Or(u32),
    /// low · factor + high
    Swapped(i64),
    /// (low + high) · 256: in most languages `+` binds more tightly than `<<`.
    SumShifted,
    /// The same in 16 bits.
    SumShiftedIn16Bits,
    /// Only so many of the 16 bits.
    Bits(u32),
    /// The low byte counts from −128 to 127.
    LowSigned,
    /// The high byte alone.
    High,
    /// low ^ high
    Xor,
    /// low · high
    Product,
}

/// The right one, and all others that are tried.
static JOINS: LazyLock<Vec<Join>> = LazyLock::new(|| {
    std::iter::once(Join::Sum(256))
        .chain(Join::wrong())
        .collect()
});

/// What is added to the index that the bytes make.
const OFFSETS: &[(&str, i64)] = &[("", 0), (", less 1", -1), (", plus 1", 1)];

/// What becomes of it in a table of n entries, in words and as a function.
const LIMITS: &[(&str, fn(i64, i64) -> i64)] = &[
    ("", |i, _| i),
    (", modulo the number of entries", |i, n| {
        i.rem_euclid(n.max(1))
    }),
    (", at most the last entry", |i, n| i.min(n - 1)),
    (", at least 0", |i, _| i.max(0)),
    (", its lowest eight bits", |i, _| i & 255),
    (", its lowest nine bits", |i, _| i & 511),
    (", its lowest ten bits", |i, _| i & 1023),
    (", its lowest twelve bits", |i, _| i & 4095),
];

impl Join {
    fn wrong() -> impl Iterator<Item = Join> {
        let shifts = || (0..16).filter(|&bits| bits != 8);
        let sums = shifts().map(|bits| Join::Sum(1 << bits));
        let factors = [10, 100, 127, 255, 256, 257, 1000].into_iter();
        let others = [
            Join::SumShifted,
            Join::SumShiftedIn16Bits,
            Join::LowSigned,
            Join::High,
            Join::Xor,
            Join::Product,
        ];
        sums.chain(shifts().map(Join::Or))
            .chain([9, 10, 11, 13, 14, 15].map(Join::Bits))
            .chain(
                factors
                    .clone()
                    .filter(|&factor| factor != 256)
                    .map(Join::Sum),
            )
            .chain(factors.map(Join::Swapped))
            .chain(others)
    }

    fn of(self, low: i64, high: i64) -> i64 {
        match self {
            Join::Sum(factor) => low + high * factor,
            Join::Or(bits) => low | high << bits,
            Join::Swapped(factor) => low * factor + high,
            Join::SumShifted => (low + high) << 8,
            Join::SumShiftedIn16Bits => (low + high) << 8 & 0xffff,
            Join::Bits(count) => (low + high * 256) & ((1 << count) - 1),
            Join::LowSigned => i64::from(low as i8) + high * 256,
            Join::High => high,
            Join::Xor => low ^ high,
            Join::Product => low * high,
        }
    }

    fn says(self) -> String {
        match self {
            Join::Sum(factor) => format!("low + high · {factor}"),
            Join::Or(bits) => format!("low | high << {bits}"),
            Join::Swapped(factor) => format!("low · {factor} + high"),
            Join::SumShifted => {
                "(low + high) · 256, as `low + high << 8` is read where + binds more tightly than <<"
                    .to_owned()
            }
            Join::SumShiftedIn16Bits => "(low + high) · 256 in 16 bits, as `low + high << 8` is read where + binds more tightly than <<".to_owned(),
            Join::Bits(count) => format!("its lowest {count} bits alone"),
            Join::LowSigned => "low + high · 256 with a signed low byte".to_owned(),
            Join::High => "the high byte alone".to_owned(),
            Join::Xor => "low ^ high".to_owned(),
            Join::Product => "low · high".to_owned(),
        }
    }
}

impl Index {
    /// All that are tried on tables, whether their entries can be told or not.
    pub fn all() -> impl Iterator<Item = Index> {
        let neighbors = [-1.0, 1.0].map(|offset| Index::Changed(Change::Offset(offset)));
        (neighbors.into_iter())
            .chain([Index::WidthByTexels])
            .chain((0..RULES.len()).map(Index::Rule))
            .chain(grid::all([JOINS.len(), OFFSETS.len(), LIMITS.len()]).map(Index::Joined))
    }

    fn of(&self, right: u32, entries: usize) -> i64 {
        match self {
            Index::WidthByTexels | Index::WidthFrom { .. } => right.into(),
            Index::Rule(rule) => RULES[*rule].1(right.into(), entries as i64),
            Index::Changed(change) => change.apply(f64::from(right), Values::Reals) as i64,
            Index::Joined([join, offset, limit]) => {
                let (low, high) = (i64::from(right & 0xff), i64::from(right >> 8));
                let joined = JOINS[*join].of(low, high) + OFFSETS[*offset].1;
                LIMITS[*limit].1(joined, entries as i64)
            }
        }
    }

    /// All widths that depend on the number of entries and not as they should, where tables have so many entries, in order.
    pub fn widths(entries: &[usize]) -> impl Iterator<Item = Index> {
        let below = std::iter::once(0).chain(entries.iter().copied());
        let is_wrong = |&(below, from): &(usize, usize)| below >= WIDE || from < WIDE;
        below
            .zip(entries.iter().copied())
            .filter(is_wrong)
            .map(|(below, from)| Index::WidthFrom { from, below })
    }

    /// As a sentence without its subject.
    pub fn says(&self) -> String {
        match self {
            Index::Changed(Change::Offset(offset)) => format!(
                "looks up the entry of index {} {} in the table where index i is stored",
                if *offset < 0.0 { "i −" } else { "i +" },
                short(offset.abs())
            ),
            Index::Changed(change) => format!(
                "looks up indices wrongly: it takes {}",
                change.says(Values::Reals)
            ),
            Index::Rule(rule) => format!("looks up {} in the table", RULES[*rule].0),
            Index::WidthByTexels => "uses one byte for an index in maps of up to 256 texels and two bytes in larger ones".to_owned(),
            Index::WidthFrom { from, below: 0 } => {
                format!("uses two bytes for an index also in tables of {from} entries")
            }
            Index::WidthFrom { from, below } => format!(
                "uses two bytes for an index in tables of {from} entries and more, and one byte in those of {below} and fewer"
            ),
            Index::Joined([join, offset, limit]) => format!(
                "joins the two bytes of an index wrongly: {}{}{} instead of low + high · 256",
                JOINS[*join].says(),
                OFFSETS[*offset].0,
                LIMITS[*limit].0
            ),
        }
    }

    pub const fn fix(&self) -> &'static str {
        match self {
            Index::Changed(_) | Index::Rule(_) => {
                "index 0 names the first entry of the table; take indices as they are stored"
            }
            Index::WidthByTexels | Index::WidthFrom { .. } => {
                "use one byte for up to 256 entries and two bytes for more; the number of entries decides"
            }
            Index::Joined(_) => {
                "an index of two bytes is low + high · 256, both from 0 to 255, the low byte first in the file"
            }
        }
    }

    pub const fn clause(&self) -> &'static str {
        match self {
            Index::Changed(_) | Index::Rule(_) => "2.8/1",
            Index::Joined(_) | Index::WidthByTexels | Index::WidthFrom { .. } => "2.8.1/3",
        }
    }
}

/// Tables of so many entries have indices of two bytes (2.8.1/3).
const WIDE: usize = 257;

/// The bytes of an index that has two where what decides counts so many or more.
const fn bytes_from(from: usize, count: usize) -> usize {
    if count < from { 1 } else { 2 }
}

/// The indices of a file and the table that they name entries of, as bytes.
pub(in crate::diagnose) struct IndexBlock<'a> {
    file: &'a [u8],
    start: usize,
    /// Entries, one after another.
    table: &'a [u8],
    /// Bytes of an index.
    pub bytes: usize,
    /// Values of an entry.
    pub size: usize,
}

impl<'a> IndexBlock<'a> {
    /// Those of a file that the reference reads, but for indices that are out of range.
    pub fn of(witness: &'a Witness) -> Option<IndexBlock<'a>> {
        let format = witness.case.format();
        let size = if format == Format::PtmCLut { 9 } else { 6 };
        let table = Block::Table.range(witness)?;
        Some(IndexBlock {
            file: &witness.built.file,
            start: Block::Indices.range(witness)?.start,
            bytes: bytes_from(WIDE, table.len() / size),
            table: &witness.built.file[table],
            size,
        })
    }

    /// The entries of the table.
    pub fn entries(&self) -> impl ExactSizeIterator<Item = &'a [u8]> + use<'a> {
        self.table.chunks_exact(self.size)
    }

    /// The index of a texel of the picture.
    pub fn stored(&self, texel: usize, extent: Extent) -> usize {
        self.read(texel, &Strides::RIGHT, extent)
    }

    /// What the index of a texel of the picture names, if it is read with these strides.
    pub fn entry(&self, texel: usize, strides: &Strides, extent: Extent) -> Option<&'a [u8]> {
        self.look_up(self.read(texel, strides, extent))
    }

    /// An index; behind the end of the file stand zeros.
    fn read(&self, texel: usize, strides: &Strides, extent: Extent) -> usize {
        let (column, row) = (texel % extent.w, extent.h - 1 - texel / extent.w);
        let byte = |k: usize| {
            let place = self.start as isize + strides.place(column, row, k, extent);
            let byte = usize::try_from(place).ok().and_then(|at| self.file.get(at));
            usize::from(byte.copied().unwrap_or_default())
        };
        (0..extent.c).map(|k| byte(k) << (8 * k)).sum()
    }

    fn look_up(&self, index: usize) -> Option<&'a [u8]> {
        self.entries().nth(index)
    }

    pub fn extent(&self, Size { width, height }: Size) -> Extent {
        Extent::of(width as usize, height as usize, self.bytes)
    }
}

/// Entries of the indices that are read with other strides.
pub(in crate::diagnose) fn read_indices(
    ptm: &mut Ptm,
    witness: &Witness,
    strides: &Strides,
) -> Result<(), Answer> {
    let Some(indices) = IndexBlock::of(witness) else {
        return Ok(());
    };
    let extent = indices.extent(ptm.planes.size);
    fill(ptm, witness, indices.size, |texel| {
        indices.entry(texel, strides, extent)
    })
}

/// Entries of other indices than those that are stored.
pub(in crate::diagnose) fn look_up(
    ptm: &mut Ptm,
    witness: &Witness,
    index: &Index,
) -> Result<(), Answer> {
    let Some(indices) = IndexBlock::of(witness) else {
        return Ok(());
    };
    let bytes = match *index {
        Index::WidthByTexels => Some(bytes_from(WIDE, ptm.planes.size.texels())),
        Index::WidthFrom { from, .. } => Some(bytes_from(from, indices.entries().len())),
        _ => None,
    };
    if let Some(bytes) = bytes {
        return read_as_wide(ptm, witness, indices, bytes);
    }
    if matches!(index, Index::Joined(_)) && indices.bytes == 1 {
        return Ok(());
    }
    let (extent, entries) = (indices.extent(ptm.planes.size), indices.entries().len());
    fill(ptm, witness, indices.size, |texel| {
        let index = index.of(indices.stored(texel, extent) as u32, entries);
        indices.look_up(usize::try_from(index).ok()?)
    })
}

/// Indices of so many bytes, and the colors behind them, which stand elsewhere then.
fn read_as_wide(
    ptm: &mut Ptm,
    witness: &Witness,
    mut indices: IndexBlock,
    bytes: usize,
) -> Result<(), Answer> {
    let size = ptm.planes.size;
    indices.bytes = bytes;
    let colors = indices.start + size.texels() * indices.bytes;
    let of_colors = ptm.planes.shape.channels() - indices.size;
    if indices.file.len() < colors + size.texels() * of_colors {
        return Err(Answer::Rejected);
    }
    let extent = indices.extent(size);
    fill(ptm, witness, indices.size, |texel| {
        indices.look_up(indices.stored(texel, extent))
    })?;
    let count = ptm.planes.shape.channels();
    for (texel, samples) in ptm.planes.samples.chunks_exact_mut(count).enumerate() {
        let stored = (extent.h - 1 - texel / extent.w) * extent.w + texel % extent.w;
        let at = colors + stored * of_colors;
        samples[indices.size..].copy_from_slice(&indices.file[at..at + of_colors]);
    }
    Ok(())
}

/// Of every texel its entry. Where the table has none, the file is refused, or 0 is shown, as this decoder did.
fn fill<'a>(
    ptm: &mut Ptm,
    witness: &Witness,
    size: usize,
    entry: impl Fn(usize) -> Option<&'a [u8]>,
) -> Result<(), Answer> {
    let is_shown = matches!(witness.observation.response, Response::Picture { .. });
    let count = ptm.planes.shape.channels();
    for (texel, samples) in ptm.planes.samples.chunks_exact_mut(count).enumerate() {
        match entry(texel) {
            Some(entry) => samples[..size].copy_from_slice(entry),
            None if is_shown => samples[..size].fill(0),
            None => return Err(Answer::Rejected),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::diagnose::tests::first_cause;
    use crate::reading::Reading;

    fn joined(stored: &[u8], join: fn(i64, i64) -> i64) -> usize {
        match *stored {
            [low, high] => join(low.into(), high.into()) as usize,
            _ => stored[0].into(),
        }
    }

    #[test]
    fn indices_that_are_read_wrongly_are_told_by_the_expression() {
        let wrong: [(fn(&[u8]) -> usize, &str); 5] = [
            (
                |bytes| joined(bytes, |low, high| ((high | low << 8) - 1) & 511),
                "low · 256 + high, less 1, its lowest nine bits",
            ),
            (
                |bytes| joined(bytes, |low, high| (low + high) << 8),
                "(low + high) · 256",
            ),
            (
                |bytes| joined(bytes, |low, high| low | high << 7),
                "low | high << 7",
            ),
            (
                |bytes| joined(bytes, |low, high| low + high * 255),
                "low + high · 255",
            ),
            (
                |bytes| match *bytes {
                    [index] if index > 127 => 0,
                    _ => joined(bytes, |low, high| low + high * 256),
                },
                "the first entry for indices over 127 of one byte, taken for negative",
            ),
        ];
        for (index, says) in wrong {
            let told = first_cause(
                Reading {
                    index,
                    ..Reading::SPEC
                },
                |case| case.format().has_table(),
            );
            assert!(told.contains(says), "{says}: {told}");
        }
    }
}
