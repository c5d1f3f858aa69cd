//! The bytes of a file from which a sample of its image is made.

use std::fmt::Write as _;
use std::ops::Range;

use crate::decode::fields;
use crate::ptm::{Field, Format, Size, channel_name};
use crate::suite::cases::Case;

/// A range of bytes and what it holds.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Origin {
    /// What they are.
    pub what: String,
    /// The clause that puts them there.
    pub clause: &'static str,
    /// Where they stand.
    pub range: Range<usize>,
}

/// Returns the bytes that hold the values of `channels` of the texel at column `x` and row `y`, counted from the top.
///
/// Empty where the file cannot be read that far.
pub(crate) fn of_samples(
    case: &Case,
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
    let found = match case.format() {
        Format::Rgb => map.block(channels.start / 6, 6, channels, "2.7.1/2"),
        Format::Lrgb if channels.start < 6 => map.block(0, 6, channels, "2.7.3/1"),
        Format::Lrgb => map.block(1, 3, channels, "2.7.3/2"),
        Format::Lum => map.block(0, 8, channels, "2.7.2/1"),
        Format::PtmLut if channels.start >= 6 => map.block(0, 3, channels, "2.8.1/4"),
        Format::PtmLut => map.entry(6, channels),
        Format::PtmCLut => map.entry(9, channels),
        _ => map.plane(case, channels.start),
    };
    found.unwrap_or_default()
}

/// Returns the bytes that hold the scale and the bias of a coefficient.
pub(crate) fn of_scale_and_bias(file: &[u8], channel: usize) -> Vec<Origin> {
    let (fields, _) = fields(file);
    let one = |clause: &'static str, what: &str| {
        let field = fields
            .iter()
            .filter(|field| field.clause == clause)
            .nth(channel % 6)?;
        Some(Origin {
            what: format!("{what} of a{}", channel % 6),
            clause,
            range: field.range.clone(),
        })
    };
    [one("2.4/3", "scale"), one("2.4/4", "bias")]
        .into_iter()
        .flatten()
        .collect()
}

struct Map<'a> {
    file: &'a [u8],
    fields: &'a [Field],
    /// The texel as it is counted in the file.
    texel: usize,
    texels: usize,
}

impl Map<'_> {
    fn named(&self, name: &str, which: usize) -> Option<&Field> {
        self.fields
            .iter()
            .filter(|field| field.name == name)
            .nth(which)
    }

    /// Bytes of block `which`, which holds `stride` for each texel.
    fn block(
        &self,
        which: usize,
        stride: usize,
        channels: Range<usize>,
        clause: &'static str,
    ) -> Option<Vec<Origin>> {
        let field = self.named("the texels", which)?;
        let first = match stride {
            3 => channels.start - 6,
            6 => channels.start % 6,
            _ => channels.start,
        };
        let start = field.range.start + self.texel * stride + first;
        Some(vec![Origin {
            what: format!(
                "texel {} of {} as they are stored, the bottom row first",
                self.texel, self.texels
            ),
            clause,
            range: start..start + channels.len(),
        }])
    }

    /// An index, and bytes of the entry it names.
    fn entry(&self, stride: usize, channels: Range<usize>) -> Option<Vec<Origin>> {
        let (table, indices) = (
            self.named("the table's entries", 0)?,
            self.named("the indices", 0)?,
        );
        let width = indices.range.len() / self.texels;
        let at = indices.range.start + self.texel * width;
        let index = self
            .file
            .get(at..at + width)?
            .iter()
            .rev()
            .fold(0, |index, &byte| index << 8 | usize::from(byte));
        let start = table.range.start + index * stride + channels.start;
        Some(vec![
            Origin {
                what: format!("the texel's index: entry {index}"),
                clause: if stride == 6 { "2.8.1/1" } else { "2.8.2/1" },
                range: at..at + width,
            },
            Origin {
                what: format!("entry {index} of the table"),
                clause: if stride == 6 { "2.5/4" } else { "2.5/5" },
                range: start..start + channels.len(),
            },
        ])
    }

    /// The stream of a plane, and the record that corrects this texel.
    fn plane(&self, case: &Case, channel: usize) -> Option<Vec<Origin>> {
        let stream = self.named("a compressed plane", channel)?;
        let mut what = format!("the stream of plane {channel}");
        if let Some(plan) = case.compression() {
            let reference = plan.references.get(channel).copied().unwrap_or(-1);
            if let Ok(reference) = usize::try_from(reference) {
                let name = channel_name(case.format().channels(), reference);
                let _ = write!(what, ", predicted from plane {reference} ({name})");
            }
        }
        let mut origins = vec![Origin {
            what,
            clause: "2.9.8/2",
            range: stream.range.clone(),
        }];
        if let Some(side) = self.named("side information", channel) {
            let records = self.file.get(side.range.clone())?.chunks_exact(5);
            let here = |record: &[u8]| {
                let position = record[..4]
                    .iter()
                    .fold(0, |position, &byte| position << 8 | usize::from(byte));
                position == self.texel
            };
            for (i, _) in records.enumerate().filter(|(_, record)| here(record)) {
                let start = side.range.start + 5 * i;
                origins.push(Origin {
                    what: format!("record {i} of its side information corrects this texel"),
                    clause: "2.9.8/5",
                    range: start..start + 5,
                });
            }
        }
        Some(origins)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::cases::{Expect, Suite, TableSpelling};
    use crate::suite::values::Values;

    /// The bytes that a sample is said to come from hold the value that was painted.
    #[test]
    fn the_origin_of_a_sample_holds_its_value() {
        let suite = Suite::load().expect("the suite");
        let mut checked = 0;
        for case in suite.cases.iter().filter(|case| {
            case.expect == Expect::Decode
                && case.damage().is_none()
                && !case.format().is_compressed()
        }) {
            let built = case.build(TableSpelling::default());
            let Values::Painted(model) = &built.values else {
                continue;
            };
            let (width, height) = (model.size.width as usize, model.size.height as usize);
            let channels = model.format.channels();
            for (x, y) in [
                (0, 0),
                (width - 1, 0),
                (0, height - 1),
                (width / 2, height / 2),
            ] {
                for channel in 0..channels {
                    let origins =
                        of_samples(case, &built.file, model.size, (x, y), channel..channel + 1);
                    let last = origins.last().expect("an origin");
                    assert_eq!(last.range.len(), 1, "{}", case.id);
                    let expected = model.samples[(y * width + x) * channels + channel];
                    assert_eq!(
                        built.file[last.range.start], expected,
                        "{} {channel}",
                        case.id
                    );
                    checked += 1;
                }
            }
        }
        assert!(checked > 5000, "{checked}");
    }
}
