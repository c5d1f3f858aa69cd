//! Execution of worked examples: bytes → value. A wrong value is an error, so that no page can be wrong.

use crate::decode::decode_as;
use crate::evaluate;
use crate::protocol::frame::View;
use crate::ptm::{Limits, Ptm, channel_name};
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
        Asked::of(self)?.find(file, &Reading::SPEC)
    }
}

/// A question about a file.
struct Asked {
    view: View,
    /// Column and row; None for all texels.
    texel: Option<(usize, usize)>,
    /// All channels if empty.
    channels: Vec<usize>,
}

/// Executes every example of the annotated format.
///
/// # Errors
/// A line for each example that fails, with its clause.
pub fn execute_all(annotated: &Annotated) -> Result<(), String> {
    let clauses = annotated
        .chapters
        .iter()
        .flat_map(|chapter| &chapter.clauses);
    let errors: Vec<String> = clauses
        .filter_map(|clause| execute(clause, None, &annotated.files).err())
        .collect();
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
    if let Some(name) = example
        .look
        .iter()
        .find(|&name| parts.iter().all(|(is, _)| is != name))
    {
        return Err(format!("{} has no part {name:?}", example.file));
    }
    let file: Vec<u8> = parts.iter().flat_map(|(_, bytes)| bytes).copied().collect();
    let asked = Asked::of(example)?;
    let found = asked.find(&file, &Reading::SPEC)?;
    holds(example, &found)?;
    let readings = CHOICES
        .iter()
        .filter(|choice| Some(choice.ruling) == ruling);
    let readings = readings.flat_map(|choice| &choice.readings[1..]);
    let mut otherwise = Vec::new();
    for (says, change) in readings {
        let other = asked.find(&file, &change(Reading::SPEC))?;
        if other != found {
            otherwise.push((*says, other));
        }
    }
    Ok(Executed {
        parts,
        asks: example.view.clone().unwrap_or_else(|| "raw".to_owned()),
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
            "the file is decoded, and not refused (clause {expected})"
        )),
        (Found::Values(_, rows), Some(value), None) => {
            let found: Vec<f64> = rows
                .iter()
                .flat_map(|(_, values)| values)
                .copied()
                .collect();
            let words: Vec<&str> = value.split_whitespace().collect();
            let is_equal = |(word, value): (&&str, &f64)| {
                let decimals = word
                    .split_once('.')
                    .map_or(0, |(_, decimals)| decimals.len());
                word.parse().is_ok_and(|said: f64| {
                    (said - value).abs() < 0.5e-9 + 0.5 * 0.1_f64.powi(decimals as i32 + 3)
                })
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

impl Asked {
    fn of(example: &WorkedExample) -> Result<Asked, String> {
        let numbers = |text: &str| -> Result<Vec<usize>, String> {
            let numbers = text.split_whitespace().map(str::parse);
            numbers
                .collect::<Result<_, _>>()
                .map_err(|_| format!("expected numbers, found {text:?}"))
        };
        let texel = match example.texel.as_deref() {
            None => Some((0, 0)),
            Some("all") => None,
            Some(text) => match numbers(text)?[..] {
                [x, y] => Some((x, y)),
                _ => return Err(format!("expected column and row, found {text:?}")),
            },
        };
        Ok(Asked {
            view: example.view.as_deref().unwrap_or("raw").parse()?,
            texel,
            channels: numbers(example.channels.as_deref().unwrap_or_default())?,
        })
    }

    fn find(&self, file: &[u8], reading: &Reading) -> Result<Found, String> {
        match decode_as(file, reading, &Limits::default()) {
            Err(error) => Ok(Found::Refused(error.clause(), error.to_string())),
            Ok(ptm) => self.values(&ptm, reading),
        }
    }

    fn values(&self, ptm: &Ptm, reading: &Reading) -> Result<Found, String> {
        let size = ptm.header.size;
        let (count, values) = self.all_values(ptm, reading);
        let all: Vec<usize> = (0..count).collect();
        let channels = if self.channels.is_empty() {
            &all
        } else {
            &self.channels
        };
        if channels.iter().any(|&channel| channel >= count) {
            return Err(format!("a texel has {count} channels"));
        }
        let (width, height) = (size.width as usize, size.height as usize);
        let texels = match self.texel {
            Some((x, y)) if x < width && y < height => vec![(x, y)],
            Some(_) => return Err(format!("the map is {size}")),
            None => (0..width * height)
                .map(|texel| (texel % width, texel / width))
                .collect(),
        };
        let row = |(x, y): (usize, usize)| {
            let at = (y * width + x) * count;
            (
                format!("({x}, {y})"),
                channels
                    .iter()
                    .map(|channel| values[at + channel])
                    .collect(),
            )
        };
        let names = channels.iter().map(|&channel| channel_name(count, channel));
        Ok(Found::Values(
            names.collect(),
            texels.into_iter().map(row).collect(),
        ))
    }

    /// Returns the number of channels of a texel in the view, and the values of all texels.
    fn all_values(&self, ptm: &Ptm, reading: &Reading) -> (usize, Vec<f64>) {
        let channels = ptm.planes.shape.channels();
        let finals = evaluate::apply(&ptm.header.scale_bias, &ptm.planes, reading);
        match &self.view {
            View::Raw => {
                let samples = ptm.planes.samples.iter();
                (channels, samples.map(|&byte| f64::from(byte)).collect())
            }
            View::Coef => (channels, finals.values),
            View::Rgb(light) => {
                let picture = evaluate::evaluate(&finals, light.lu, light.lv, reading);
                (3, picture.values)
            }
        }
    }
}
