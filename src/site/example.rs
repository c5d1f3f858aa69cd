//! Execution of worked examples: bytes → value. A wrong value is an error, so that no page can be wrong.

use crate::decode::decode_as;
use crate::formula::Edits;
use crate::protocol::frame::View;
use crate::ptm::{Limits, channel_name};
use crate::reading::Reading;
use crate::site::annotated::{Annotated, AnnotatedClause, Files, WorkedExample};
use crate::suite::choices::CHOICES;

/// An example that was executed successfully.
#[derive(Clone, Debug)]
pub struct Executed {
    /// Descriptions of parts, and their bytes.
    pub parts: Vec<(String, Vec<u8>)>,
    /// The question about the file, in words.
    pub asks: String,
    /// The result.
    pub found: Found,
    /// Different results under the other readings of the clause's choice.
    pub otherwise: Vec<(&'static str, Found)>,
}

/// The result of a decoder for a file.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// The names of the requested channels, and a row for each texel: its name and their values.
    Values(Vec<String>, Vec<(String, Vec<f64>)>),
    /// The file is refused: the clause, and the error in words.
    Refused(&'static str, String),
}

impl WorkedExample {
    /// Returns the result of the example's question for another file.
    ///
    /// # Errors
    /// If the file has no such texel or channel.
    pub fn find_in(&self, file: &[u8]) -> Result<Found, String> {
        self.find(file, &Reading::SPEC)
    }

    fn find(&self, file: &[u8], reading: &Reading) -> Result<Found, String> {
        let ptm = match decode_as(file, reading, &Limits::default()) {
            Ok(ptm) => ptm,
            Err(error) => return Ok(Found::Refused(error.clause(), error.to_string())),
        };
        let view: View = self.asks().parse()?;
        let count = view.kind().channels(ptm.planes.shape.channels());
        let values = view.values(&ptm, reading, Edits(&[]));
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
            place => match numbers(place.unwrap_or("0 0"))?[..] {
                [x, y] if x < width && y < height => y * width + x..y * width + x + 1,
                [_, _] => return Err(format!("the map is {size}")),
                _ => return Err(format!("expected column and row, found {place:?}")),
            },
        };
        let row = |texel: usize| {
            let name = format!("({}, {})", texel % width, texel / width);
            let values = channels.iter().map(|i| values[texel * count + i]);
            (name, values.collect())
        };
        let names = channels.iter().map(|&i| channel_name(count, i));
        Ok(Found::Values(names.collect(), texels.map(row).collect()))
    }

    /// Returns the view that it asks for.
    fn asks(&self) -> &str {
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
/// A line for each example that fails, with its clause.
pub fn execute_all(annotated: &Annotated) -> Result<(), String> {
    let chapters = annotated.chapters.iter();
    let clauses = chapters.flat_map(|chapter| &chapter.clauses);
    let executed = clauses.map(|clause| execute(clause, None, &annotated.files));
    let errors: Vec<String> = executed.filter_map(Result::err).collect();
    match errors.is_empty() {
        true => Ok(()),
        false => Err(errors.join("\n")),
    }
}

/// Executes the examples of a clause, and under every reading of `ruling` if that is a choice.
///
/// # Errors
/// A sentence that names the clause and describes the difference.
pub fn execute(
    clause: &AnnotatedClause,
    ruling: Option<&str>,
    files: &Files,
) -> Result<Vec<Executed>, String> {
    if clause.examples.is_empty() {
        return Err(format!("clause {}: no example", clause.clause));
    }
    let numbered = clause.examples.iter().enumerate();
    let executed = numbered.map(|(i, example)| -> Result<Executed, String> {
        let named = |error| format!("clause {}, example {}: {error}", clause.clause, i + 1);
        one(example, ruling, files).map_err(named)
    });
    executed.collect()
}

fn one(example: &WorkedExample, ruling: Option<&str>, files: &Files) -> Result<Executed, String> {
    let parts = files.parts(&example.file, &example.with)?;
    let is_missing = |name: &&String| parts.iter().all(|(is, _)| is != *name);
    if let Some(name) = example.look.iter().find(is_missing) {
        return Err(format!("{} has no part {name:?}", example.file));
    }
    let file: Vec<u8> = parts.iter().flat_map(|(_, bytes)| bytes).copied().collect();
    let found = example.find_in(&file)?;
    holds(example, &found)?;
    let choices = CHOICES.iter();
    let choices = choices.filter(|choice| Some(choice.ruling) == ruling);
    let readings = choices.flat_map(|choice| &choice.readings[1..]);
    let mut otherwise = Vec::new();
    for (says, change) in readings {
        let other = example.find(&file, &change(Reading::SPEC))?;
        if other != found {
            otherwise.push((*says, other));
        }
    }
    Ok(Executed {
        parts,
        asks: example.asks().to_owned(),
        found,
        otherwise,
    })
}

/// Checks that an example states the result that was found.
fn holds(example: &WorkedExample, found: &Found) -> Result<(), String> {
    match (found, &example.value, &example.refused) {
        (Found::Refused(clause, _), None, Some(expected)) if clause == expected => Ok(()),
        (Found::Refused(clause, why), _, _) => {
            Err(format!("the file is refused (clause {clause}): {why}"))
        }
        (Found::Values(..), _, Some(expected)) => Err(format!(
            "the file is decoded, not refused (clause {expected})"
        )),
        (Found::Values(_, rows), Some(value), None) => {
            let found: Vec<f64> = rows.iter().flat_map(|(_, values)| values.clone()).collect();
            let words: Vec<&str> = value.split_whitespace().collect();
            let is_equal = |(word, value): (&&str, &f64)| {
                let decimals = word.split_once('.').map_or("", |(_, decimals)| decimals);
                let tolerance = 0.5e-9 + 0.5 * 0.1_f64.powi(decimals.len() as i32 + 3);
                let said = word.parse::<f64>();
                said.is_ok_and(|said| (said - value).abs() < tolerance)
            };
            if words.len() == found.len() && words.iter().zip(&found).all(is_equal) {
                return Ok(());
            }
            let found: Vec<String> = found.iter().map(ToString::to_string).collect();
            Err(format!("expected {value}, found {}", found.join(" ")))
        }
        (Found::Values(..), None, None) => Err("it expects nothing".to_owned()),
    }
}
