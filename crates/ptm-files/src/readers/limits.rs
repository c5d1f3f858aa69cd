//! Limits of readers. They are known from the source code of the readers and are not in the catalog of misreadings.

use std::borrow::Cow;

use serde::de::{Deserialize, Deserializer, Error};

use ptm::error::Error as PtmError;
use ptm::{Field, Format, Ptm};

/// A limit of a reader.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Name of the limit in `readers.yaml`.
    pub slug: &'static str,
    /// Behavior of a reader with this limit.
    pub behavior: &'static str,
    /// Effect on a file that exceeds the limit.
    effect: Effect,
    is_exceeded: fn(&FileTraits) -> bool,
}

/// Effect of a limit on a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// The file is refused for this reason.
    Refused(&'static str),
    /// The file is displayed incorrectly in this way.
    Wrong(&'static str),
}

const LIMITS: [Limit; 13] = [
    // These readers do not check the lists of motion vectors.
    Limit {
        slug: "blanks-of-compressed-refused",
        behavior: "refuses a compressed file in which a list ends in a space or has two adjacent spaces",
        effect: Effect::Refused("a list ends in a space or has two adjacent spaces"),
        is_exceeded: |file| file.is_compressed() && file.has_empty_list_items(),
    },
    // Motion vectors are two lists.
    Limit {
        slug: "lists-on-other-lines-refused",
        behavior: "refuses a compressed file unless each list has its own line",
        effect: Effect::Refused("a list is not on a separate line"),
        is_exceeded: |file| file.is_compressed() && !file.has_one_list_per_line(),
    },
    Limit {
        slug: "bytes-after-the-end-refused",
        behavior: "refuses bytes after the last value",
        effect: Effect::Refused("bytes follow the last value"),
        is_exceeded: |file| file.has_trailing_bytes(),
    },
    Limit {
        slug: "space-after-twelve-numbers-refused",
        behavior: "refuses a space after twelve scales and biases on one line",
        effect: Effect::Refused("a space follows twelve numbers on one line"),
        is_exceeded: |file| file.has_space_after_twelve_numbers(),
    },
    // These readers accept a space after the version.
    Limit {
        slug: "space-after-format-refused",
        behavior: "refuses a space after the name of the format",
        effect: Effect::Refused("a space follows the name of the format"),
        is_exceeded: |file| file.is_followed_by("2.2/1", b" \n"),
    },
    Limit {
        slug: "underflow-refused",
        behavior: "refuses a scale that is too small for the program's floating-point type",
        effect: Effect::Refused("a scale is close to zero"),
        is_exceeded: |file| file.has_underflow(),
    },
    Limit {
        slug: "small-payload-refused",
        behavior: "refuses a file with fewer than 36 bytes of values, or fewer than 9 · width + 18",
        effect: Effect::Refused("the map has one row or very few texels"),
        is_exceeded: |file| file.payload_bytes() < 36.max(9 * file.width() + 18),
    },
    Limit {
        slug: "coefficients-beyond-32-bits-wrong",
        behavior: "shows wrong colors if a coefficient does not fit in 32 bits",
        effect: Effect::Wrong("a coefficient does not fit in 32 bits"),
        is_exceeded: |file| file.has_coefficients_beyond_32_bits(),
    },
    // The padding is uninitialized, so the image changes from run to run.
    Limit {
        slug: "row-padding-shown",
        behavior: "shows uninitialized bytes as texels if a plane has several rows and its width is not a multiple of four",
        effect: Effect::Wrong("rows are displaced, with arbitrary texels between them"),
        is_exceeded: |file| file.is_compressed() && file.width() % 4 != 0 && file.height() > 1,
    },
    Limit {
        slug: "side-information-refused",
        behavior: "fails on planes with side information",
        effect: Effect::Refused("a plane has side information"),
        is_exceeded: |file| file.numbers("2.9.7/1").any(|size| size > 0),
    },
    Limit {
        slug: "motion-refused",
        behavior: "refuses planes with motion vectors",
        effect: Effect::Refused("a plane has a motion vector"),
        is_exceeded: |file| file.moves(),
    },
    Limit {
        slug: "motion-not-applied",
        behavior: "does not displace planes that have motion vectors",
        effect: Effect::Wrong("planes with motion vectors are not displaced"),
        is_exceeded: |file| file.moves() && file.numbers("2.9.3/1").any(|vector| vector != 0),
    },
    Limit {
        slug: "colors-lost-after-a-space",
        behavior: "reads no colors from an LRGB file whose version is followed by a space",
        effect: Effect::Wrong("the colors are missing"),
        is_exceeded: |file| {
            file.format == Some(Format::Lrgb) && file.file.starts_with(b"PTM_1.2 \n")
        },
    },
];

impl Limit {
    /// Returns the effect of the limit on a file, or `None` if the file is within the limit.
    pub(super) fn effect(&self, file: &FileTraits) -> Option<Effect> {
        (self.is_exceeded)(file).then_some(self.effect)
    }
}

impl<'de> Deserialize<'de> for Limit {
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
pub(super) struct FileTraits<'a> {
    file: &'a [u8],
    fields: Vec<Field>,
    /// Format of the file, if the file is legal.
    format: Option<Format>,
    payload: usize,
}

impl<'a> FileTraits<'a> {
    /// Returns the properties of a file from its fields and the result of decoding it.
    pub(super) fn new(
        file: &'a [u8],
        fields: Vec<Field>,
        outcome: &Result<Ptm, PtmError>,
    ) -> FileTraits<'a> {
        const PAYLOAD: [&str; 5] = ["2.5/3", "2.7/1", "2.8.1/1", "2.9.8/2", "2.9.8/4"];
        let header = fields
            .iter()
            .take_while(|field| !PAYLOAD.contains(&field.clause));
        let end = header.last().map_or(0, |field| field.range.end);
        let line_feed = file[end..].iter().position(|&byte| byte == b'\n');
        FileTraits {
            file,
            payload: line_feed.map_or(file.len(), |length| end + length + 1),
            format: outcome.as_ref().ok().map(|ptm| ptm.header.format),
            fields,
        }
    }

    /// Returns the number of bytes after the header.
    fn payload_bytes(&self) -> usize {
        self.file.len() - self.payload
    }

    fn width(&self) -> usize {
        self.length(0)
    }

    fn height(&self) -> usize {
        self.length(1)
    }

    /// Returns the width (0) or the height (1).
    fn length(&self, index: usize) -> usize {
        let length = self.numbers("2.3/1").nth(index);
        length
            .and_then(|length| length.try_into().ok())
            .unwrap_or(0)
    }

    fn fields_of_clause(&self, clause: &str) -> impl Iterator<Item = &Field> {
        let fields = self.fields.iter();
        fields.filter(move |field| field.clause == clause)
    }

    fn texts(&self, clause: &str) -> impl Iterator<Item = Cow<'_, str>> {
        let fields = self.fields_of_clause(clause);
        fields.map(|field| String::from_utf8_lossy(&self.file[field.range.clone()]))
    }

    /// Parses the numbers in the header fields of `clause`.
    fn numbers(&self, clause: &str) -> impl Iterator<Item = i64> {
        self.texts(clause).filter_map(|text| text.parse().ok())
    }

    /// Returns true if a header field of `clause` is followed by `bytes`.
    fn is_followed_by(&self, clause: &str, bytes: &[u8]) -> bool {
        let mut fields = self.fields_of_clause(clause);
        fields.any(|field| self.file[field.range.end..].starts_with(bytes))
    }

    /// Returns true if a list has an empty item when it is split at single spaces.
    fn has_empty_list_items(&self) -> bool {
        let lists = "2.4/3 2.4/4 2.9.2/1 2.9.4/1 2.9.5/1 2.9.6/1 2.9.7/1";
        let is_empty = |list| self.is_followed_by(list, b" \n") || self.is_followed_by(list, b"  ");
        lists.split(' ').any(is_empty)
    }

    fn has_underflow(&self) -> bool {
        self.texts("2.4/3").any(|text| {
            let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
            let is_zero = !mantissa.contains(|digit: char| ('1'..='9').contains(&digit));
            let value: f32 = text.parse().unwrap_or(1.0);
            !is_zero && value.abs() < f32::MIN_POSITIVE
        })
    }

    fn has_coefficients_beyond_32_bits(&self) -> bool {
        let scales = self.texts("2.4/3");
        let mut scales = scales.filter_map(|text| text.parse::<f64>().ok());
        scales.any(|scale| scale.abs() * 255.0 > f64::from(i32::MAX))
    }

    fn is_compressed(&self) -> bool {
        self.format.and_then(Format::coding).is_some()
    }

    /// Returns true if the lists of a compressed file have the line breaks of HP's encoder.
    fn has_one_list_per_line(&self) -> bool {
        let Some(first) = self.fields_of_clause("2.9.1/1").next() else {
            return true;
        };
        let lists = String::from_utf8_lossy(&self.file[first.range.start..self.payload]);
        let words = |line: &str| line.split(' ').filter(|word| !word.is_empty()).count();
        let counts = lists.split('\n').map(words).filter(|&count| count > 0);
        let planes = self.format.map_or(0, Format::channels);
        counts.eq([1, planes, planes, planes, planes, planes, planes, planes])
    }

    /// Returns true if a predicted plane has a motion vector, which may be zero.
    fn moves(&self) -> bool {
        let mut steps = self.numbers("2.9.2/1").zip(self.numbers("2.9.5/1"));
        steps.any(|(transform, reference)| transform & 2 != 0 && reference >= 0)
    }

    fn has_trailing_bytes(&self) -> bool {
        let mut fields = self.fields.iter();
        self.format.is_some() && fields.all(|field| field.range.end < self.file.len())
    }

    fn has_space_after_twelve_numbers(&self) -> bool {
        let [scale, bias] = ["2.4/3", "2.4/4"].map(|list| self.fields_of_clause(list).last());
        let is_on_one_line = scale.zip(bias).is_some_and(|(scale, bias)| {
            let gap = &self.file[scale.range.end..bias.range.start];
            !gap.contains(&b'\n') && self.file[bias.range.end..].starts_with(b" \n")
        });
        self.format.is_some() && is_on_one_line
    }
}
