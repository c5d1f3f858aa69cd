//! The bytes of a file that determine a sample of its image.

use std::fmt::Write as _;
use std::ops::Range;

use ptm::decode::{fields, texels::block_containing};
use ptm::parts::Block;
use ptm::{Field, Format, Size, channel_name};

/// A description of bytes, the clause that defines them, and their position in the file.
pub type Origin = (String, &'static str, Range<usize>);

/// Returns the bytes that determine `channels` of the texel in column `x` and row `y`, counted from the top.
///
/// Returns an empty list if the file ends before these bytes.
#[must_use]
pub fn origin_of_samples(
    format: Format,
    file: &[u8],
    size: Size,
    (x, y): (usize, usize),
    channels: Range<usize>,
) -> Vec<Origin> {
    let (fields, _) = fields(file);
    let (width, height) = (size.width as usize, size.height as usize);
    // The bottom row is stored first.
    let texel = (height - 1 - y) * width + x;
    let map = Map {
        file,
        fields: &fields,
        texel,
        texels: width * height,
    };
    let found = match (block_containing(format, channels.start), format.coding()) {
        (Some((index, block)), _) => map.block(index, block, channels),
        (None, None) => map.entry(format.entry_size(), channels),
        (None, Some(_)) => map.plane(format, channels.start),
    };
    found.unwrap_or_default()
}

/// Returns the bytes of the scale and the bias of a coefficient.
#[must_use]
pub fn origin_of_scale_and_bias(file: &[u8], channel: usize) -> Vec<Origin> {
    let (fields, _) = fields(file);
    let coefficient = channel % 6;
    let mut origins = Vec::new();
    for (clause, name) in [("2.4/3", "scale"), ("2.4/4", "bias")] {
        let mut numbers = fields.iter().filter(|field| field.clause == clause);
        if let Some(field) = numbers.nth(coefficient) {
            let name = format!("{name} of a{coefficient}");
            origins.push((name, clause, field.range.clone()));
        }
    }
    origins
}

struct Map<'a> {
    file: &'a [u8],
    fields: &'a [Field],
    /// The index of the texel in the file.
    texel: usize,
    texels: usize,
}

impl Map<'_> {
    /// Returns the byte range of the field called `name`. `index` selects one of several fields with that name.
    fn range(&self, name: &str, index: usize) -> Option<Range<usize>> {
        let mut named = self.fields.iter().filter(|field| field.name == name);
        Some(named.nth(index)?.range.clone())
    }

    fn block(&self, index: usize, block: &Block, channels: Range<usize>) -> Option<Vec<Origin>> {
        let first = self.texel * block.channels + channels.start - block.channel;
        let start = self.range("the texels", index)?.start + first;
        let Map { texel, texels, .. } = self;
        let name = format!("texel {texel} of {texels} in stored order, bottom row first");
        Some(vec![(name, block.clause, start..start + channels.len())])
    }

    /// Returns the bytes of an index and of the table entry to which it refers.
    fn entry(&self, stride: usize, channels: Range<usize>) -> Option<Vec<Origin>> {
        let table = self.range("the table's entries", 0)?;
        let indices = self.range("the indices", 0)?;
        let width = indices.len() / self.texels;
        let at = indices.start + self.texel * width;
        let index = number(self.file.get(at..at + width)?.iter().rev());
        let start = table.start + index * stride + channels.start;
        let (index_clause, entry_clause) = match stride {
            6 => ("2.8.1/1", "2.5/4"),
            _ => ("2.8.2/1", "2.5/5"),
        };
        let name = format!("the texel's index: entry {index}");
        let entry = format!("entry {index} of the table");
        Some(vec![
            (name, index_clause, at..at + width),
            (entry, entry_clause, start..start + channels.len()),
        ])
    }

    /// Returns the bytes of the stream of a plane, and of the record that corrects this texel.
    fn plane(&self, format: Format, channel: usize) -> Option<Vec<Origin>> {
        let stream = self.range("a compressed plane", channel)?;
        let mut text = format!("the stream of plane {channel}");
        let reference = self.file.get(self.range("a reference plane", channel)?)?;
        // A negative number means that the plane is not predicted.
        if let Ok(reference) = str::from_utf8(reference).unwrap_or_default().parse() {
            let name = channel_name(format.channels(), reference);
            let _ = write!(text, ", predicted from plane {reference} ({name})");
        }
        let mut origins = vec![(text, "2.9.8/2", stream)];
        let side = self.range("side information", channel).unwrap_or(0..0);
        let records = self.file.get(side.clone())?.chunks_exact(5).enumerate();
        for (i, _) in records.filter(|(_, record)| number(record[..4].iter()) == self.texel) {
            let start = side.start + 5 * i;
            let text = format!("record {i} of the plane's side information corrects this texel");
            origins.push((text, "2.9.8/5", start..start + 5));
        }
        Some(origins)
    }
}

/// Parses a big-endian number.
fn number<'a>(bytes: impl Iterator<Item = &'a u8>) -> usize {
    bytes.fold(0, |number, &byte| number << 8 | usize::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::{Expect, Suite, TableSpelling};
    use crate::values::Values;

    #[test]
    fn origin_of_a_sample_has_the_painted_value() {
        let suite = Suite::load().expect("the suite");
        let mut checked = 0;
        for case in &suite.cases {
            let built = case.build(TableSpelling::default());
            let is_edited = case.expect != Expect::Decode || case.damage().is_some();
            let Values::Painted(model) = &built.values else {
                continue;
            };
            if is_edited || case.format().coding().is_some() {
                continue;
            }
            let (w, h) = (model.size.width as usize, model.size.height as usize);
            let channels = model.format.channels();
            for (x, y) in [(0, 0), (w - 1, 0), (0, h - 1), (w / 2, h / 2)] {
                for channel in 0..channels {
                    let only = channel..channel + 1;
                    let mut origins =
                        origin_of_samples(case.format(), &built.file, model.size, (x, y), only);
                    let (_, _, range) = origins.pop().expect("an origin");
                    let sample = model.samples[(y * w + x) * channels + channel];
                    assert_eq!(built.file[range], [sample], "{} {channel}", case.id);
                    checked += 1;
                }
            }
        }
        assert!(checked > 5000, "{checked}");
    }
}
