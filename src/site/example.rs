//! Executes worked examples. A wrong value is an error, so published examples are always correct.

use crate::site::annotated::{Annotated, AnnotatedClause, Files, WorkedExample};
use ptm::decode::decode_as;
use ptm::reading::Reading;
use ptm::{Limits, channel_name};
use ptm_suite::choices::CHOICES;
use ptm_suite::protocol::frame::View;

/// Successful execution of an example.
#[derive(Clone, Debug)]
pub struct Execution {
    /// Description and bytes of each part.
    pub parts: Vec<(String, Vec<u8>)>,
    /// Requested view.
    pub view: String,
    /// Result of decoding.
    pub found: Decoding,
    /// Results that differ from `found` under other readings of the clause, each with a description of the reading.
    pub alternatives: Vec<(&'static str, Decoding)>,
}

/// Result of decoding a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoding {
    /// Names of the requested channels, and one row per texel: its position and values.
    Values(Vec<String>, Vec<(String, Vec<f64>)>),
    /// The file is refused. Contains the violated clause and the error message.
    Refused(&'static str, String),
}

impl WorkedExample {
    /// Evaluates the example for the given file.
    ///
    /// # Errors
    /// Returns an error if the requested texel or channel does not exist.
    pub fn evaluate(&self, file: &[u8]) -> Result<Decoding, String> {
        self.evaluate_under(file, &Reading::SPEC)
    }

    fn evaluate_under(&self, file: &[u8], reading: &Reading) -> Result<Decoding, String> {
        let ptm = match decode_as(file, reading, &Limits::default()) {
            Ok(ptm) => ptm,
            Err(error) => return Ok(Decoding::Refused(error.clause(), error.to_string())),
        };
        let view: View = self.requested_view().parse()?;
        let count = view.kind().channels(ptm.planes.shape.channels());
        let values = view.values(&ptm, reading);
        let channels = match numbers(self.channels.as_deref().unwrap_or_default())? {
            all if all.is_empty() => (0..count).collect(),
            some if some.iter().all(|&channel| channel < count) => some,
            _ => {
                return Err(format!(
                    "channel out of range: a texel has {count} channels"
                ));
            }
        };
        let size = ptm.header.size;
        let (width, height) = (size.width as usize, size.height as usize);
        let texels = match self.texel.as_deref() {
            Some("all") => 0..size.texels(),
            texel => match numbers(texel.unwrap_or("0 0"))?[..] {
                [x, y] if x < width && y < height => y * width + x..y * width + x + 1,
                [_, _] => return Err(format!("the map is {size}")),
                _ => return Err(format!("expected column and row, found {texel:?}")),
            },
        };
        let row = |texel: usize| {
            let name = format!("({}, {})", texel % width, texel / width);
            let values = channels.iter().map(|i| values[texel * count + i]);
            (name, values.collect())
        };
        let names = channels.iter().map(|&i| channel_name(count, i));
        Ok(Decoding::Values(names.collect(), texels.map(row).collect()))
    }

    fn requested_view(&self) -> &str {
        self.view.as_deref().unwrap_or("raw")
    }
}

fn numbers(text: &str) -> Result<Vec<usize>, String> {
    let numbers: Result<_, _> = text.split_whitespace().map(str::parse).collect();
    numbers.map_err(|_| format!("expected numbers, found {text:?}"))
}

/// Executes every example of the annotated format.
///
/// # Errors
/// Returns a message with one line per failing example.
pub fn execute_all(annotated: &Annotated) -> Result<(), String> {
    let mut errors = Vec::new();
    let chapters = annotated.chapters.iter();
    for clause in chapters.flat_map(|chapter| &chapter.clauses) {
        errors.extend(execute(clause, None, &annotated.files).err());
    }
    match errors.is_empty() {
        true => Ok(()),
        false => Err(errors.join("\n")),
    }
}

/// Executes the examples of a clause. If `ruling` is a choice, executes them under each of its readings.
///
/// # Errors
/// Returns a message that names the clause and describes the difference.
pub fn execute(
    clause: &AnnotatedClause,
    ruling: Option<&str>,
    files: &Files,
) -> Result<Vec<Execution>, String> {
    if clause.examples.is_empty() {
        return Err(format!("clause {}: no example", clause.clause));
    }
    let mut executed = Vec::new();
    for (i, example) in (1..).zip(&clause.examples) {
        let in_example = |error| format!("clause {}, example {i}: {error}", clause.clause);
        executed.push(run(example, ruling, files).map_err(in_example)?);
    }
    Ok(executed)
}

fn run(example: &WorkedExample, ruling: Option<&str>, files: &Files) -> Result<Execution, String> {
    let parts = files.parts(&example.file, &example.replacements)?;
    let is_missing = |name: &&String| parts.iter().all(|(part, _)| part != *name);
    if let Some(name) = example.highlighted.iter().find(is_missing) {
        return Err(format!("{} has no part {name:?}", example.file));
    }
    let file: Vec<u8> = parts.iter().flat_map(|(_, bytes)| bytes).copied().collect();
    let found = example.evaluate(&file)?;
    check_result(example, &found)?;
    let mut choices = CHOICES.iter();
    let choice = choices.find(|choice| Some(choice.ruling) == ruling);
    let mut alternatives = Vec::new();
    for (says, change) in choice.map_or(&[][..], |choice| &choice.readings[1..]) {
        let mut reading = Reading::SPEC;
        change(&mut reading);
        let other = example.evaluate_under(&file, &reading)?;
        if other != found {
            alternatives.push((*says, other));
        }
    }
    Ok(Execution {
        parts,
        view: example.requested_view().to_owned(),
        found,
        alternatives,
    })
}

fn check_result(example: &WorkedExample, found: &Decoding) -> Result<(), String> {
    match (found, &example.value, &example.refused) {
        (Decoding::Refused(clause, _), None, Some(expected)) if clause == expected => Ok(()),
        (Decoding::Refused(clause, why), _, _) => {
            Err(format!("the file is refused (clause {clause}): {why}"))
        }
        (Decoding::Values(..), _, Some(expected)) => Err(format!(
            "the file is decoded instead of refused (clause {expected})"
        )),
        (Decoding::Values(_, rows), Some(value), None) => {
            let found: Vec<f64> = rows.iter().flat_map(|(_, values)| values.clone()).collect();
            let words: Vec<&str> = value.split_whitespace().collect();
            let is_equal = |(word, value): (&&str, &f64)| {
                let decimals = word.split_once('.').map_or("", |(_, decimals)| decimals);
                let tolerance = 0.5e-9 + 0.5 * 0.1_f64.powi(decimals.len() as i32 + 3);
                let stated = word.parse::<f64>();
                stated.is_ok_and(|stated| (stated - value).abs() < tolerance)
            };
            if words.len() == found.len() && words.iter().zip(&found).all(is_equal) {
                return Ok(());
            }
            let found: Vec<String> = found.iter().map(ToString::to_string).collect();
            Err(format!("expected {value}, found {}", found.join(" ")))
        }
        (Decoding::Values(..), None, None) => {
            Err("the example states no expected result".to_owned())
        }
    }
}
