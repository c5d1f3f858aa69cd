//! The source of the annotated format: `spec-cases/annotated/`, a file for each chapter.

use std::collections::BTreeMap;

use data_encoding::HEXLOWER;
use serde::Deserialize;

use crate::kit::{embedded, yaml::from_yaml};

/// A chapter of the format's text: one page.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chapter {
    /// `2.4`; sections below it without a separate chapter belong to it.
    pub section: String,
    /// The title.
    pub title: String,
    /// An introduction for readers.
    pub intro: String,
    /// A table after the introduction.
    pub table: Option<ChapterTable>,
    /// Steps to take, in order.
    #[serde(default)]
    pub steps: Vec<String>,
    /// The clauses of its sections, in their order.
    pub clauses: Vec<AnnotatedClause>,
}

/// A table of a chapter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChapterTable {
    /// The names of its columns.
    pub head: Vec<String>,
    /// Its cells.
    pub rows: Vec<Vec<String>>,
}

/// A detailed explanation of a clause.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnnotatedClause {
    /// Its id in `clauses.yaml`.
    pub clause: String,
    /// The rule, and pitfalls.
    pub text: String,
    /// Formulas, a line each.
    #[serde(default)]
    pub formula: Vec<String>,
    /// Bytes and their meaning; at least one example.
    pub examples: Vec<WorkedExample>,
}

/// A file and the values that a decoder finds in it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkedExample {
    /// A description.
    pub says: Option<String>,
    /// The file of `files.yaml` that it is based on.
    pub file: String,
    /// Parts that replace those with the same name.
    #[serde(default)]
    pub with: Vec<Part>,
    /// The relevant parts.
    #[serde(default)]
    pub look: Vec<String>,
    /// `raw`, `coef` or `rgb:LU,LV`; raw if left out.
    pub view: Option<String>,
    /// Column and row, counted from the top left, or `all`; `0 0` if left out.
    pub texel: Option<String>,
    /// The numbers of the channels; all if left out.
    pub channels: Option<String>,
    /// The values at that place, texel after texel.
    pub value: Option<String>,
    /// The clause that the file breaks, if it is refused.
    pub refused: Option<String>,
    /// The arithmetic.
    pub because: Option<String>,
}

/// Some bytes and their description.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The description.
    pub is: String,
    text: Option<String>,
    hex: Option<String>,
    stream: Option<String>,
    /// The number of repetitions.
    times: Option<usize>,
}

/// The files and streams that examples are based on.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Files {
    files: BTreeMap<String, Vec<Part>>,
    streams: BTreeMap<String, String>,
}

/// The annotated format.
#[derive(Clone, Debug)]
pub struct Annotated {
    /// The chapters, in the order of the text.
    pub chapters: Vec<Chapter>,
    /// The files that examples are based on.
    pub files: Files,
}

/// The chapters in the order of the text.
pub const CHAPTERS: &[(&str, &str)] = embedded![
    "spec-cases/annotated",
    "1.0-background.yaml",
    "2.0-file-format.yaml",
    "2.1-header-string.yaml",
    "2.2-format-string.yaml",
    "2.3-image-size.yaml",
    "2.4-scale-and-bias.yaml",
    "2.5-lookup-table.yaml",
    "2.6-color-matrix.yaml",
    "2.7-texel-data.yaml",
    "2.8-indices.yaml",
    "2.9-compressed.yaml",
    "2.9.8-planes.yaml",
];

/// The files that examples are based on.
pub const FILES: &str = include_str!("../../spec-cases/annotated/files.yaml");

impl Annotated {
    /// Reads chapters, each with the name of its file, and the files that their examples are based on.
    ///
    /// # Errors
    /// A sentence that names the file and the line at fault.
    pub fn read(chapters: &[(&str, &str)], files: &str) -> Result<Annotated, String> {
        let read = |(name, text): &(&str, &str)| {
            from_yaml(text).map_err(|error| format!("{name}: {error}"))
        };
        Ok(Annotated {
            chapters: chapters.iter().map(read).collect::<Result<_, _>>()?,
            files: from_yaml(files).map_err(|error| format!("files.yaml: {error}"))?,
        })
    }
}

impl Files {
    /// Returns the parts of a file with some of them replaced: a description and the bytes of each.
    ///
    /// # Errors
    /// A sentence that names the missing part or file.
    pub fn parts(&self, file: &str, with: &[Part]) -> Result<Vec<(String, Vec<u8>)>, String> {
        let parts = self.files.get(file);
        let parts = parts.ok_or_else(|| format!("unknown file {file}"))?;
        for part in with {
            if parts.iter().all(|old| old.is != part.is) {
                return Err(format!("{file} has no part {:?}", part.is));
            }
        }
        let made = parts.iter().map(|old| {
            let part = with.iter().find(|part| part.is == old.is).unwrap_or(old);
            Ok((part.is.clone(), self.bytes(part)?))
        });
        made.collect()
    }

    fn bytes(&self, part: &Part) -> Result<Vec<u8>, String> {
        let bytes = match (&part.text, &part.hex, &part.stream) {
            (Some(text), None, None) => Ok(text.as_bytes().to_vec()),
            (None, Some(hex), None) => parse_hex(hex),
            (None, None, Some(stream)) => {
                let stream = self.streams.get(stream);
                parse_hex(stream.ok_or_else(|| format!("part {:?} names no stream", part.is))?)
            }
            _ => Err("it needs one of text, hex and stream".to_owned()),
        };
        let bytes = bytes.map_err(|error| format!("part {:?}: {error}", part.is))?;
        Ok(bytes.repeat(part.times.unwrap_or(1)))
    }
}

fn parse_hex(text: &str) -> Result<Vec<u8>, String> {
    let digits: String = text.split_whitespace().collect();
    HEXLOWER
        .decode(digits.as_bytes())
        .map_err(|_| format!("expected pairs of hex digits, found {text:?}"))
}
