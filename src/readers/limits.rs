//! Limits of readers that misread no clause: facts of their source that have no misreading in the catalog.

use serde::Deserialize;

use crate::decode::examine;
use crate::ptm::{Field, Format};

/// A limit of a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// Refuses a compressed file with a space after a list or two spaces within one; lines of vectors are not checked.
    BlanksOfCompressedRefused,
    /// Refuses a compressed file unless each list has one line, and the vectors two.
    ListsOnOtherLinesRefused,
    /// Refuses a file with bytes after the last value.
    BytesAfterTheEndRefused,
    /// Refuses a file whose twelve scales and biases are on one line that ends in a space.
    SpaceAfterTwelveNumbersRefused,
    /// Refuses a space after the name of the format, though not after the version.
    SpaceAfterFormatRefused,
    /// Refuses a scale that is too small for its floating-point type.
    UnderflowRefused,
    /// Refuses a file in which a transform has the bit of motion compensation.
    MotionRefused,
    /// Does not displace references, whatever the transform says.
    MotionNotApplied,
    /// Reads no colors from an LRGB file whose version is followed by a space.
    ColorsLostAfterASpace,
}

/// The effect of a limit on a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Struck {
    /// The file is refused, with the reason.
    Refused(&'static str),
    /// The file is shown wrong, with a description.
    Wrong(&'static str),
}

/// The properties of a file that limits depend on.
pub(super) struct Marks<'a> {
    file: &'a [u8],
    fields: Vec<Field>,
    format: Option<Format>,
    payload: usize,
    is_legal: bool,
}

impl<'a> Marks<'a> {
    pub(super) fn of(file: &'a [u8]) -> Marks<'a> {
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

    fn header(&self) -> &'a [u8] {
        &self.file[..self.payload]
    }

    /// Returns true if a list that is split at single spaces has an empty part.
    fn has_blanks_in_lists(&self) -> bool {
        let lists = [
            "2.4/3", "2.4/4", "2.9.2/1", "2.9.4/1", "2.9.5/1", "2.9.6/1", "2.9.7/1",
        ];
        let mut numbers = self
            .fields
            .iter()
            .filter(|field| lists.contains(&field.clause));
        numbers.any(|field| {
            let after = &self.header()[field.range.end..];
            after.starts_with(b" \n") || after.starts_with(b"  ")
        })
    }

    fn has_underflow(&self) -> bool {
        let mut scales = self.fields.iter().filter(|field| field.clause == "2.4/3");
        scales.any(|field| {
            let text = String::from_utf8_lossy(&self.file[field.range.clone()]);
            let mantissa = text.split(['e', 'E']).next().unwrap_or_default();
            let is_zero = !mantissa.contains(|digit: char| ('1'..='9').contains(&digit));
            let value: f32 = text.parse().unwrap_or(1.0);
            !is_zero && value.abs() < f32::MIN_POSITIVE
        })
    }

    fn is_compressed(&self) -> bool {
        self.format.is_some_and(Format::is_compressed)
    }

    /// Returns the numbers of a clause in the header.
    fn numbers(&self, clause: &str) -> impl Iterator<Item = i64> {
        let of_it = self
            .fields
            .iter()
            .filter(move |field| field.clause == clause);
        of_it.filter_map(|field| {
            std::str::from_utf8(&self.file[field.range.clone()])
                .ok()?
                .parse()
                .ok()
        })
    }

    /// Returns true if the lists of a compressed file have the line breaks of HP's encoder.
    fn lists_have_a_line_each(&self) -> bool {
        let start = self.fields.iter().find(|field| field.clause == "2.9.1/1");
        let Some(start) = start.map(|field| field.range.start) else {
            return true;
        };
        let planes = self.format.map_or(0, Format::channels);
        let lines = self.file[start..self.payload].split(|&byte| byte == b'\n');
        let words = |line: &[u8]| {
            line.split(|&byte| byte == b' ')
                .filter(|word| !word.is_empty())
                .count()
        };
        let counts: Vec<usize> = lines.map(words).filter(|&count| count > 0).collect();
        counts == [1, planes, planes, planes, planes, planes, planes, planes]
    }

    fn moves(&self) -> bool {
        self.numbers("2.9.2/1").any(|transform| transform & 2 != 0)
    }

    /// Returns the end of the last value.
    fn end(&self) -> usize {
        self.fields
            .iter()
            .map(|field| field.range.end)
            .max()
            .unwrap_or(0)
    }
}

impl Limit {
    /// Describes the behavior of such a reader.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Limit::BlanksOfCompressedRefused => {
                "refuses a compressed file in which a list ends in a space or has two in a row"
            }
            Limit::ListsOnOtherLinesRefused => {
                "refuses a compressed file whose lists do not have a line each"
            }
            Limit::BytesAfterTheEndRefused => "refuses bytes after the last value",
            Limit::SpaceAfterTwelveNumbersRefused => {
                "refuses a space after twelve scales and biases on one line"
            }
            Limit::SpaceAfterFormatRefused => "refuses a space after the name of the format",
            Limit::UnderflowRefused => {
                "refuses a scale that is too small for its floating-point type"
            }
            Limit::MotionRefused => "refuses planes with motion vectors",
            Limit::MotionNotApplied => "does not move planes that have motion vectors",
            Limit::ColorsLostAfterASpace => {
                "reads no colors from an LRGB file whose version is followed by a space"
            }
        }
    }

    /// Returns its effect on a file; None if the file is within the limit.
    pub(super) fn strikes(self, marks: &Marks) -> Option<Struck> {
        let refused = |so: bool, why| so.then_some(Struck::Refused(why));
        let wrong = |so: bool, how| so.then_some(Struck::Wrong(how));
        match self {
            Limit::BlanksOfCompressedRefused => refused(
                marks.is_compressed() && marks.has_blanks_in_lists(),
                "a list ends in a space or has two in a row",
            ),
            Limit::ListsOnOtherLinesRefused => refused(
                marks.is_compressed() && !marks.lists_have_a_line_each(),
                "a list does not have a line of its own",
            ),
            Limit::BytesAfterTheEndRefused => refused(
                marks.is_legal && marks.end() < marks.file.len(),
                "bytes follow the last value",
            ),
            Limit::SpaceAfterTwelveNumbersRefused => refused(
                marks.is_legal && marks.twelve_numbers_end_in_a_space(),
                "a space follows twelve numbers on one line",
            ),
            Limit::SpaceAfterFormatRefused => refused(
                marks.space_after_format(),
                "a space follows the name of the format",
            ),
            Limit::UnderflowRefused => refused(marks.has_underflow(), "a scale is next to nothing"),
            Limit::MotionRefused => refused(marks.moves(), "a plane has a motion vector"),
            Limit::MotionNotApplied => wrong(
                marks.moves()
                    && marks
                        .numbers("2.9.3/1")
                        .any(|displacement| displacement != 0),
                "planes with motion vectors are not moved",
            ),
            Limit::ColorsLostAfterASpace => wrong(
                marks.format == Some(Format::Lrgb) && marks.file.starts_with(b"PTM_1.2 \n"),
                "the colors are missing",
            ),
        }
    }
}

impl Marks<'_> {
    fn space_after_format(&self) -> bool {
        let format = self.fields.iter().find(|field| field.clause == "2.2/1");
        format.is_some_and(|field| self.file[field.range.end..].starts_with(b" \n"))
    }

    fn twelve_numbers_end_in_a_space(&self) -> bool {
        let of_clause = |clause: &'static str| {
            self.fields
                .iter()
                .filter(move |field| field.clause == clause)
        };
        let (Some(scale), Some(bias)) = (
            of_clause("2.4/3").next_back(),
            of_clause("2.4/4").next_back(),
        ) else {
            return false;
        };
        let between = &self.file[scale.range.end..bias.range.start];
        !between.contains(&b'\n') && self.file[bias.range.end..].starts_with(b" \n")
    }
}
