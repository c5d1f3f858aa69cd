//! Checks the user's files, which have no expected output.
//!
//! An image is correct if it matches the reference in any combination of readings of the open questions. The decoder is also
//! compared with itself: other encodings of the same values must produce the same image.

use std::fmt::Write;

use serde::Serialize;

use ptm::decode::{decode_as, fields};
use ptm::error::Class;
use ptm::reading::Reading;
use ptm::{Coding, Format, Limits, Ptm, Shape};
use ptm_generate::{Model, Numbers, Recipe, Spelling, spelling::Line, write};
use ptm_suite::protocol::frame::{Answer, View};
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::verdicts::outcome::Outcome;
use ptm_suite::{choices::CHOICES, compare::Expected, dialect::Dialect, values::Values};

/// Results for a directory of files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FilesReport {
    /// `fail` if a file fails, or else `not run` if a file cannot be read, or else `pass`.
    pub verdict: Outcome,
    /// Results, one per file.
    pub files: Vec<FileResult>,
}

/// The result for one file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FileResult {
    /// File name without directories.
    pub file: String,
    /// View in which the file was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// Result of the comparison with the reference.
    pub outcome: Outcome,
    /// The reason for the outcome.
    #[serde(rename = "says", skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// Descriptions of other encodings of the same values for which the decoder returns a different image or no image.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub relations: Vec<String>,
    /// Number of other encodings that the decoder supports.
    pub encodings: usize,
}

impl FileResult {
    /// Creates the result for a file that was not requested. `message` states the reason.
    #[must_use]
    pub fn not_run(file: &str, message: Option<String>) -> FileResult {
        FileResult {
            file: file.to_owned(),
            view: None,
            outcome: Outcome::NotRun,
            message,
            relations: Vec::new(),
            encodings: 0,
        }
    }
}

/// Checks one file with the decoder `ask`, in the first of `views` that the decoder supports.
pub fn check_file(
    name: &str,
    file: &[u8],
    views: &[View],
    ask: &dyn Fn(&Request) -> Reply,
) -> FileResult {
    let answer = |view: &View, file: &[u8]| {
        let texels = ptm::decode(file).map_or(file.len(), |ptm| ptm.planes.size.texels());
        ask(&Request::new(name, view, file, texels * 72)).answer
    };
    let mut result = FileResult::not_run(name, None);
    let mut answered = views.iter().map(|view| (view, answer(view, file)));
    let Some((view, shown)) = answered.find(|(_, shown)| *shown != Answer::Unsupported) else {
        result.outcome = Outcome::Unsupported;
        return result;
    };
    result.view = Some(view.to_string());
    let compared = compare_with_reference(file, view, &shown);
    if let (Answer::Decoded(shown), Ok(ptm)) = (&shown, ptm::decode(file)) {
        let slack = expected(file, view, &Reading::SPEC).map(|right| right.slack);
        let first = Expected {
            slack: slack.unwrap_or_default(),
            ..Expected::from_frame(shown)
        };
        for (label, other) in encodings(&ptm) {
            let broken = match answer(view, &other) {
                Answer::Unsupported => continue,
                Answer::Decoded(again) => (first.compare(&again))
                    .map(|difference| format!("{label}: a different image: {difference}")),
                Answer::TimedOut(limit) => Some(format!("{label}: no image: the decoder {limit}")),
                other => Some(format!("{label}: no image, but {}", other.name())),
            };
            result.encodings += 1;
            result.relations.extend(broken);
        }
    }
    result.outcome = match compared.is_ok() && result.relations.is_empty() {
        true => Outcome::Pass,
        false => Outcome::Fail,
    };
    result.message = Some(compared.unwrap_or_else(|fault| fault)).filter(|says| !says.is_empty());
    result
}

/// Encodes the values of a map in each lossless format with the same channels, and in other header spellings. Returns each file
/// with a description. A correct decoder outputs the same image for all of them, so no expected output is needed.
fn encodings(ptm: &Ptm) -> Vec<(String, Vec<u8>)> {
    let mut formats = Format::ALL.to_vec();
    formats.retain(|format| {
        let is_exact = format.coding() != Some(Coding::Jpeg);
        is_exact && format.channels() == ptm.planes.shape.channels()
    });
    let mut encodings = Vec::new();
    let mut add = |format: Format, label: &str, spelling: Spelling| {
        let label = format!("as {}{label}", format.short_name());
        encodings.extend(encode(ptm, format, spelling).map(|file| (label, file)));
    };
    for &format in &formats {
        add(format, "", Spelling::default());
    }
    let [mut size, mut lists, mut blanks] = [(); 3].map(|()| Spelling::default());
    size.size_on_two_lines = false;
    add(formats[0], ", with width and height on one line", size);
    lists.scale_bias_on_two_lines = false;
    add(formats[0], ", with scales and biases on one line", lists);
    blanks.space_before_newline = Line::SECTION_ENDS.to_vec();
    let label = ", with a space at the end of each section of the header";
    add(formats[0], label, blanks);
    encodings
}

/// Encodes the values of `ptm` in a format with the same channels. Returns `None` if the format cannot hold them.
fn encode(ptm: &Ptm, format: Format, spelling: Spelling) -> Option<Vec<u8>> {
    let size = ptm.planes.size;
    // A JPEG-LS stream has at most 65,535 columns and rows.
    if format.coding().is_some() && size.width.max(size.height) > 65_535 {
        return None;
    }
    let mut recipe = Recipe {
        spelling,
        ..Recipe::default_for(format, size)
    };
    recipe.scale = numbers(&ptm.header.scale_bias.scale)?;
    recipe.bias = numbers(&ptm.header.scale_bias.bias)?;
    if let Shape::Lum(matrix) = ptm.planes.shape {
        recipe.matrix = numbers(&matrix.0)?;
    }
    let model = Model::new(&recipe, &ptm.planes.samples).ok()?;
    Some(write(&recipe, &model).bytes)
}

/// Formats numbers so that parsing returns the same values.
fn numbers<const N: usize>(values: &[f64; N]) -> Option<Numbers<N>> {
    let texts: Vec<String> = values.iter().map(f64::to_string).collect();
    texts.join(" ").parse().ok()
}

/// Returns the expected image of a file. Lossy JPEG planes get a tolerance for different inverse DCTs (ruling `jpeg-samples`).
fn expected(file: &[u8], view: &View, reading: &Reading) -> Option<Expected> {
    let exact = Expected::from_file(file, view, reading)?;
    let ptm = decode_as(file, reading, &Limits::default()).ok()?;
    let (format, planes) = (ptm.header.format, ptm.planes);
    if format.coding() != Some(Coding::Jpeg) {
        return Some(exact);
    }
    let model = Model {
        format,
        size: planes.size,
        slack: inverse_dct_counts(file).repeat(planes.size.texels()),
        samples: planes.samples,
        table: Vec::new(),
        indices: Vec::new(),
        scale: ptm.header.scale_bias.scale,
        bias: ptm.header.scale_bias.bias,
        matrix: [0.0; 16],
        compressed: None,
    };
    let slack = Expected::new(&Values::Painted(model), view)?.slack;
    Some(Expected { slack, ..exact })
}

/// Returns the numbers in a list of the header, given its clause.
fn numbers_of(file: &[u8], clause: &'static str) -> impl Iterator<Item = i64> {
    let (fields, _) = fields(file);
    let fields = fields
        .into_iter()
        .filter(move |field| field.clause == clause);
    fields.filter_map(|field| std::str::from_utf8(&file[field.range]).ok()?.parse().ok())
}

/// Returns the number of inverse DCTs that affect each plane: its own, and those of the planes from which it is predicted.
fn inverse_dct_counts(file: &[u8]) -> Vec<u8> {
    let references: Vec<Option<usize>> = numbers_of(file, "2.9.5/1")
        .map(|plane| usize::try_from(plane).ok())
        .collect();
    let reference = |&plane: &usize| references.get(plane).copied().flatten();
    let chain = |plane| std::iter::successors(Some(plane), reference).take(references.len());
    let planes = 0..references.len();
    planes.map(|plane| chain(plane).count() as u8).collect()
}

/// Compares an answer with the reference. Returns a remark on a correct answer, or the fault as an error.
fn compare_with_reference(file: &[u8], view: &View, answer: &Answer) -> Result<String, String> {
    match (answer, ptm::decode(file)) {
        (Answer::Decoded(shown), Ok(ptm)) => {
            let right = |reading: &Reading| expected(file, view, reading);
            let spec = right(&Reading::SPEC).expect("the reference decoded the file");
            let Some(difference) = spec.compare(shown) else {
                return Ok(String::new());
            };
            let format = ptm.header.format;
            let moves = numbers_of(file, "2.9.2/1").any(|transform| transform & 2 != 0);
            let is_open = |&axis: &usize| match CHOICES[axis].ruling {
                "luminance-clamp" => format.channels() == 9,
                ruling if ruling.starts_with("lum-") => format == Format::Lum,
                ruling if ruling.starts_with("motion-") => moves,
                _ => format.coding() == Some(Coding::JpegLs),
            };
            let open: Vec<usize> = (0..CHOICES.len()).filter(is_open).collect();
            let fits = |dialect: &&Dialect| {
                let right = right(&CHOICES.apply(dialect, Reading::SPEC));
                right.is_some_and(|right| right.compare(shown).is_none())
            };
            let dialects = CHOICES.combinations(&open);
            let dialect = dialects.iter().skip(1).find(fits);
            let dialect = dialect.ok_or(difference.to_string())?;
            let readings = CHOICES.iter().zip(&dialect.0);
            let others = readings.filter(|&(_, &taken)| taken > 0);
            let names = others.map(|(choice, &taken)| choice.readings[taken].0);
            let names: Vec<&str> = names.collect();
            Ok(format!("correct under this reading: {}", names.join("; ")))
        }
        (Answer::Decoded(_), Err(error)) if error.class() == Class::Malformed => Err(format!(
            "shows an image of a file that the reference refuses: {error}"
        )),
        (Answer::Decoded(_), Err(error)) => {
            Ok(format!("the reference does not support this file: {error}"))
        }
        (Answer::Rejected, Ok(_)) => Err("refuses a file that the reference reads".to_owned()),
        (Answer::Rejected, Err(_)) => Ok("refused by the decoder and the reference".to_owned()),
        (answer, _) => Err(answer.describe()),
    }
}

impl FilesReport {
    /// Creates a report on these files.
    #[must_use]
    pub fn new(files: Vec<FileResult>) -> FilesReport {
        let is_one = |outcome: &Outcome| files.iter().any(|file| file.outcome == *outcome);
        let verdict = [Outcome::Fail, Outcome::NotRun].into_iter().find(is_one);
        let verdict = verdict.unwrap_or(Outcome::Pass);
        FilesReport { verdict, files }
    }

    /// Returns the exit status: 3 if all files are unsupported, or else 0 for the verdict `pass` and 1 for any other.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        let mut files = self.files.iter();
        match files.all(|file| file.outcome == Outcome::Unsupported) {
            true => 3,
            false => u8::from(self.verdict != Outcome::Pass),
        }
    }

    /// Returns the report as text for a terminal.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for result in &self.files {
            let _ = write!(text, "{} {}", result.outcome, result.file);
            if result.outcome != Outcome::NotRun {
                let view = result.view.as_deref().unwrap_or("in no view");
                let _ = write!(text, " {view}: {} other encodings", result.encodings);
            }
            text.extend(result.message.iter().map(|says| format!("; {says}")));
            text.push('\n');
            for relation in &result.relations {
                let _ = writeln!(text, "  {relation}");
            }
        }
        let count = self.files.len();
        let plural = if count == 1 { "" } else { "s" };
        let _ = writeln!(text, "{}: {count} file{plural}", self.verdict);
        text
    }
}
