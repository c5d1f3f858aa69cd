//! Limits of readers that are known from their source and are not in the catalog of misreadings.

use serde::de::{Deserialize, Deserializer, Error};

use crate::decode::examine;
use crate::ptm::{Field, Format};

/// A limit of a reader.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Name of the limit in `readers.yaml`.
    pub slug: &'static str,
    /// Behavior of a reader with this limit.
    pub words: &'static str,
    /// Effect on a file that exceeds the limit.
    effect: Effect,
    is_exceeded: fn(&Marks) -> bool,
}

/// Effect of a limit on a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// The file is refused, with the reason.
    Refused(&'static str),
    /// The file is displayed incorrectly, with a description.
    Wrong(&'static str),
}

const LIMITS: [Limit; 9] = [
    // Lines of vectors are not checked.
    Limit {
        slug: "blanks-of-compressed-refused",
        words: "refuses a compressed file in which a list ends in a space or has two adjacent spaces",
        effect: Effect::Refused("a list ends in a space or has two adjacent spaces"),
        is_exceeded: |file| file.is_compressed() && file.has_empty_list_items(),
    },
    // The vectors have two lines.
    Limit {
        slug: "lists-on-other-lines-refused",
        words: "refuses a compressed file unless each list has its own line",
        effect: Effect::Refused("a list is not on a separate line"),
        is_exceeded: |file| file.is_compressed() && !file.has_one_list_per_line(),
    },
    Limit {
        slug: "bytes-after-the-end-refused",
        words: "refuses bytes after the last value",
        effect: Effect::Refused("bytes follow the last value"),
        is_exceeded: |file| file.is_legal && file.end() < file.file.len(),
    },
    Limit {
        slug: "space-after-twelve-numbers-refused",
        words: "refuses a space after twelve scales and biases on one line",
        effect: Effect::Refused("a space follows twelve numbers on one line"),
        is_exceeded: |file| file.is_legal && file.has_space_after_twelve_numbers(),
    },
    // It accepts a space after the version.
    Limit {
        slug: "space-after-format-refused",
        words: "refuses a space after the name of the format",
        effect: Effect::Refused("a space follows the name of the format"),
        is_exceeded: |file| file.space_after_format(),
    },
    Limit {
        slug: "underflow-refused",
        words: "refuses a scale that is too small for its floating-point type",
        effect: Effect::Refused("a scale is close to zero"),
        is_exceeded: |file| file.has_underflow(),
    },
    Limit {
        slug: "motion-refused",
        words: "refuses planes with motion vectors",
        effect: Effect::Refused("a plane has a motion vector"),
        is_exceeded: |file| file.moves(),
    },
    Limit {
        slug: "motion-not-applied",
        words: "does not move planes that have motion vectors",
        effect: Effect::Wrong("planes with motion vectors are not moved"),
        is_exceeded: |file| file.moves() && file.field_values("2.9.3/1").any(|vector| vector != 0),
    },
    Limit {
        slug: "colors-lost-after-a-space",
        words: "reads no colors from an LRGB file whose version is followed by a space",
        effect: Effect::Wrong("the colors are missing"),
        is_exceeded: |file| {
            file.format == Some(Format::Lrgb) && file.file.starts_with(b"PTM_1.2 \n")
        },
    },
];

impl Limit {
    /// Returns the effect on a file, or `None` if the file is within the limit.
    pub(super) fn effect(&self, file: &Marks) -> Option<Effect> {
        (self.is_exceeded)(file).then_some(self.effect)
    }
}

impl<'de> Deserialize<'de> for Limit {
    /// Deserializes the limit from its slug.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Limit, D::Error> {
        let slug = String::deserialize(deserializer)?;
        let known = LIMITS.iter().find(|limit| limit.slug == slug);
        known.copied().ok_or_else(|| {
            let slugs = LIMITS.map(|limit| limit.slug).join(", ");
            Error::custom(format!("unknown limit `{slug}`, expected one of {slugs}"))
        })
    }
}

/// Properties of a file that the limits depend on.
pub(super) struct Marks<'a> {
    file: &'a [u8],
    fields: Vec<Field>,
    format: Option<Format>,
    payload: usize,
    is_legal: bool,
}

impl<'a> Marks<'a> {
    pub(super) fn new(file: &'a [u8]) -> Marks<'a> {
        let (fields, outcome) = examine(file);
        let is_payload = |field: &&Field| {
            !matches!(
                field.clause,
                "2.5/3" | "2.7/1" | "2.8.1/1" | "2.9.8/2" | "2.9.8/4"
            )
        };
        let end = fields.iter().take_while(is_payload).last();
        let end = end.map_or(0, |field| field.range.end);
        let line_feed = file[end..].iter().position(|&byte| byte == b'\n');
        Marks {
            file,
            payload: line_feed.map_or(file.len(), |length| end + length + 1),
            format: outcome.as_ref().ok().map(|ptm| ptm.header.format),
            is_legal: outcome.is_ok(),
            fields,
        }
    }

    fn fields_of_clause<'s>(&'s self, clause: &'s str) -> impl Iterator<Item = &'s Field> {
        self.fields
            .iter()
            .filter(move |field| field.clause == clause)
    }

    /// Returns true if a list that is split at single spaces has an empty part.
    fn has_empty_list_items(&self) -> bool {
        let lists = [
            "2.4/3", "2.4/4", "2.9.2/1", "2.9.4/1", "2.9.5/1", "2.9.6/1", "2.9.7/1",
        ];
        let mut numbers = lists.iter().flat_map(|list| self.fields_of_clause(list));
        numbers.any(|field| {
            let after = &self.file[field.range.end..self.payload];
            after.starts_with(b" \n") || after.starts_with(b"  ")
        })
    }

    fn has_underflow(&self) -> bool {
        self.fields_of_clause("2.4/3").any(|field| {
            let text = String::from_utf8_lossy(&self.file[field.range.clone()]);
            let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
            let is_zero = !mantissa.contains(|digit: char| ('1'..='9').contains(&digit));
            let value: f32 = text.parse().unwrap_or(1.0);
            !is_zero && value.abs() < f32::MIN_POSITIVE
        })
    }

    fn is_compressed(&self) -> bool {
        self.format.and_then(Format::coding).is_some()
    }

    /// Parses the numbers in the header fields of `clause`.
    fn field_values<'s>(&'s self, clause: &'s str) -> impl Iterator<Item = i64> + 's {
        self.fields_of_clause(clause).filter_map(|field| {
            std::str::from_utf8(&self.file[field.range.clone()])
                .ok()?
                .parse()
                .ok()
        })
    }

    /// Returns true if the lists of a compressed file have the line breaks of HP's encoder.
    fn has_one_list_per_line(&self) -> bool {
        let Some(Field { range, .. }) = self.fields_of_clause("2.9.1/1").next() else {
            return true;
        };
        let planes = self.format.map_or(0, Format::channels);
        let lines = self.file[range.start..self.payload].split(|&byte| byte == b'\n');
        let words = |line: &[u8]| {
            line.split(|&byte| byte == b' ')
                .filter(|word| !word.is_empty())
                .count()
        };
        let counts: Vec<usize> = lines.map(words).filter(|&count| count > 0).collect();
        counts == [1, planes, planes, planes, planes, planes, planes, planes]
    }

    fn moves(&self) -> bool {
        self.field_values("2.9.2/1")
            .any(|transform| transform & 2 != 0)
    }

    /// Returns the offset of the byte after the last value.
    fn end(&self) -> usize {
        self.fields
            .iter()
            .map(|field| field.range.end)
            .max()
            .unwrap_or(0)
    }

    fn space_after_format(&self) -> bool {
        let mut format = self.fields_of_clause("2.2/1");
        format.any(|field| self.file[field.range.end..].starts_with(b" \n"))
    }

    fn has_space_after_twelve_numbers(&self) -> bool {
        let [Some(scale), Some(bias)] =
            ["2.4/3", "2.4/4"].map(|list| self.fields_of_clause(list).last())
        else {
            return false;
        };
        let between = &self.file[scale.range.end..bias.range.start];
        !between.contains(&b'\n') && self.file[bias.range.end..].starts_with(b" \n")
    }
}
