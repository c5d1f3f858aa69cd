//! Checks on the user's files, which have no expected output.
//!
//! The decoder is compared with the reference, in the best matching reading of the open questions, and with itself: other
//! encodings of the same values must give the same image.

use std::fmt::Write;

use serde::Serialize;

use crate::decode::{decode_as, fields};
use crate::error::Class;
use crate::generate::Model;
use crate::protocol::frame::{Answer, View};
use crate::ptm::{Field, Format, Limits};
use crate::reading::Reading;
use crate::runner::run::{Reply, Request};
use crate::session::metamorphic::encodings;
use crate::session::outcome::Outcome;
use crate::suite::choices::CHOICES;
use crate::suite::compare::Expected;
use crate::suite::dialect::Dialect;
use crate::suite::values::Values;

/// The results for a directory of files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FilesReport {
    /// `pass` or `fail`.
    pub verdict: &'static str,
    /// The result for each file.
    pub files: Vec<FileResult>,
}

/// The result for one file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FileResult {
    /// Its name, without directories.
    pub file: String,
    /// The view in which it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// Comparison with the reference: pass, fail, unsupported.
    pub outcome: &'static str,
    /// The reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub says: Option<String>,
    /// Other encodings of the same values that give another image, or none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub relations: Vec<String>,
    /// The number of other encodings that were tried.
    pub encodings: usize,
}

/// Checks one file with the decoder behind `ask`, in the first of `views` that it offers.
pub fn check_file(
    name: &str,
    file: &[u8],
    views: &[View],
    ask: &dyn Fn(&Request) -> Reply,
) -> FileResult {
    let answer = |view: &View, file: &[u8]| {
        let request = Request {
            name,
            view,
            file,
            largest_frame: largest_frame(file),
            timeout_factor: 3,
            alone: true,
        };
        ask(&request).answer
    };
    let mut result = FileResult {
        file: name.to_owned(),
        view: None,
        outcome: Outcome::Unsupported.name(),
        says: None,
        relations: Vec::new(),
        encodings: 0,
    };
    let mut answered = views.iter().map(|view| (view, answer(view, file)));
    let Some((view, shown)) = answered.find(|(_, shown)| *shown != Answer::Unsupported) else {
        return result;
    };
    result.view = Some(view.to_string());
    let (mut outcome, says) = match held_against_reference(file, view, &shown) {
        Ok(says) => (Outcome::Pass, says),
        Err(says) => (Outcome::Fail, says),
    };
    result.says = Some(says).filter(|says| !says.is_empty());
    if let (Answer::Decoded(shown), Ok(ptm)) = (&shown, crate::decode(file)) {
        let slack = expected(file, view, &Reading::SPEC).map(|right| right.slack);
        let first = Expected {
            slack: slack.unwrap_or_default(),
            ..Expected::of_frame(shown)
        };
        for encoding in encodings(&ptm) {
            let again = answer(view, &encoding.file);
            if again != Answer::Unsupported {
                result.encodings += 1;
                let broken = relation(&first, &again);
                let broken = broken.map(|says| format!("{}: {says}", encoding.how));
                result.relations.extend(broken);
            }
        }
    }
    if !result.relations.is_empty() {
        outcome = Outcome::Fail;
    }
    result.outcome = outcome.name();
    result
}

/// Returns the expected image of a file. Lossy JPEG planes have the tolerance of inverse DCTs (ruling `jpeg-samples`).
fn expected(file: &[u8], view: &View, reading: &Reading) -> Option<Expected> {
    let ptm = decode_as(file, reading, &Limits::default()).ok()?;
    let (format, planes) = (ptm.header.format, ptm.planes);
    if !matches!(format, Format::JpegRgb | Format::JpegLrgb) {
        return Expected::under(file, view, reading);
    }
    let model = Model {
        format,
        size: planes.size,
        slack: transforms_in_a_row(file).repeat(planes.size.texels()),
        samples: planes.samples,
        table: Vec::new(),
        indices: Vec::new(),
        scale: ptm.header.scale_bias.scale,
        bias: ptm.header.scale_bias.bias,
        matrix: [0.0; 16],
        compressed: None,
    };
    Expected::of(&Values::Painted(model), view)
}

/// Returns the number of inverse DCTs that affect each plane: its own, and those of the planes it is predicted from.
fn transforms_in_a_row(file: &[u8]) -> Vec<u8> {
    let (fields, _) = fields(file);
    let reference_of = |field: &Field| {
        let text = std::str::from_utf8(&file[field.range.clone()]).ok()?;
        text.parse::<usize>().ok()
    };
    let fields = fields.iter().filter(|field| field.clause == "2.9.5/1");
    let references: Vec<Option<usize>> = fields.map(reference_of).collect();
    let count = |plane: usize| {
        let reference = |&plane: &usize| references.get(plane).copied().flatten();
        let row = std::iter::successors(Some(plane), reference);
        row.take(references.len()).count() as u8
    };
    (0..references.len()).map(count).collect()
}

/// Returns the fault of an answer, or a remark on a right one.
fn held_against_reference(file: &[u8], view: &View, shown: &Answer) -> Result<String, String> {
    let reference = decode_as(file, &Reading::SPEC, &Limits::default());
    match (shown, reference) {
        (Answer::Decoded(shown), Ok(ptm)) => {
            let right =
                expected(file, view, &Reading::SPEC).expect("the reference has just decoded it");
            let Some(difference) = right.compare(shown) else {
                return Ok(String::new());
            };
            let open = match ptm.header.format {
                Format::Lum => CHOICES.axes(&["lum-vector", "lum-major", "lum-range"]),
                format if format.is_compressed() => (0..CHOICES.len())
                    .filter(|&axis| !CHOICES[axis].ruling.starts_with("lum"))
                    .collect(),
                _ => Vec::new(),
            };
            let fits = |dialect: &Dialect| {
                expected(file, view, &CHOICES.under(dialect, Reading::SPEC))
                    .is_some_and(|right| right.compare(shown).is_none())
            };
            let dialects = CHOICES.combinations(&open);
            match dialects.iter().skip(1).find(|dialect| fits(dialect)) {
                Some(dialect) => Ok(format!(
                    "right in its own reading: {}",
                    other_readings(dialect)
                )),
                None => Err(difference.to_string()),
            }
        }
        (Answer::Decoded(_), Err(error)) if error.class() == Class::Malformed => Err(format!(
            "shows a picture of a file that the reference refuses: {error}"
        )),
        (Answer::Decoded(_), Err(error)) => Ok(format!("the reference does not read it: {error}")),
        (Answer::Rejected, Ok(_)) => Err("refuses a file that the reference reads".to_owned()),
        (Answer::Rejected, Err(_)) => Ok("refused, as the reference does".to_owned()),
        (answer, _) => Err(answer.describe()),
    }
}

/// Returns the readings in which a dialect differs from the reference.
fn other_readings(dialect: &Dialect) -> String {
    let readings = CHOICES.iter().zip(&dialect.0);
    let others = readings.filter(|&(_, &taken)| taken > 0);
    let names: Vec<&str> = others
        .map(|(choice, &taken)| choice.readings[taken].0)
        .collect();
    names.join("; ")
}

/// Describes the difference between the image of another encoding and the first one.
fn relation(first: &Expected, again: &Answer) -> Option<String> {
    match again {
        Answer::Decoded(again) => {
            let difference = first.compare(again)?;
            Some(format!("another picture: {difference}"))
        }
        other => Some(format!("no picture, but {}", other.name())),
    }
}

/// Returns the maximum number of bytes of a frame of that file.
fn largest_frame(file: &[u8]) -> usize {
    crate::decode(file).map_or(file.len() * 72, |ptm| ptm.planes.size.texels() * 72)
}

impl FilesReport {
    /// Creates the report of some files.
    #[must_use]
    pub fn new(files: Vec<FileResult>) -> FilesReport {
        let has_failed = |file: &FileResult| file.outcome == Outcome::Fail.name();
        let verdict = match files.iter().any(has_failed) {
            true => "fail",
            false => "pass",
        };
        FilesReport { verdict, files }
    }

    /// Returns 0, 1, or 3 if no file was read at all.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        let is_unread = |file: &FileResult| file.outcome == Outcome::Unsupported.name();
        match self.verdict {
            _ if self.files.iter().all(is_unread) => 3,
            "pass" => 0,
            _ => 1,
        }
    }

    /// Returns the report as text for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for file in &self.files {
            let says = file.says.as_deref().unwrap_or_default();
            let _ = writeln!(
                text,
                "{} {} {}: {} other encodings{}{says}",
                file.outcome,
                file.file,
                file.view.as_deref().unwrap_or("in no view"),
                file.encodings,
                if says.is_empty() { "" } else { "; " },
            );
            for relation in &file.relations {
                let _ = writeln!(text, "  {relation}");
            }
        }
        let _ = writeln!(text, "{}: {} files", self.verdict, self.files.len());
        text
    }
}
