//! Source of the annotated format: `spec-cases/annotated/`, with one file per chapter.

use std::collections::BTreeMap;

use serde::Deserialize;

use ptm_suite::kit::yaml::{from_files, from_yaml};
use ptm_suite::values::parse_hex;

/// Chapter of the annotated format, rendered as one page.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chapter {
    /// Section number, such as `2.4`. The chapter includes subsections that are not separate chapters.
    pub section: String,
    /// Title of the chapter.
    pub title: String,
    /// Introductory text.
    pub intro: String,
    /// Table after the introductory text.
    pub table: Option<ChapterTable>,
    /// Decoding steps, in order.
    #[serde(default)]
    pub steps: Vec<String>,
    /// Clauses of the chapter, in order.
    pub clauses: Vec<AnnotatedClause>,
}

/// Table of a chapter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChapterTable {
    /// Column names.
    pub head: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

/// Detailed explanation of a clause.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnnotatedClause {
    /// Id of the clause in `clauses.yaml`.
    pub clause: String,
    /// Description of the rule and its pitfalls.
    pub text: String,
    /// Formulas, one per line.
    #[serde(default)]
    pub formula: Vec<String>,
    /// Worked examples. Every clause has at least one.
    pub examples: Vec<WorkedExample>,
}

/// Example file and the values that a decoder reads from it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkedExample {
    /// Description of the example.
    #[serde(rename = "says")]
    pub description: Option<String>,
    /// Name of the base file in `files.yaml`.
    pub file: String,
    /// Parts that replace the parts with the same names in the base file.
    #[serde(rename = "with", default)]
    pub replacements: Vec<Part>,
    /// Names of the parts to highlight.
    #[serde(rename = "look", default)]
    pub highlighted: Vec<String>,
    /// View: `raw` (the default), `coef` or `rgb:LU,LV`.
    pub view: Option<String>,
    /// Texel whose values are read: its column and row, counted from the top left, or `all` for all texels. The default is `0 0`.
    pub texel: Option<String>,
    /// Channel numbers. The default is all channels.
    pub channels: Option<String>,
    /// Expected values, texel by texel.
    pub value: Option<String>,
    /// Clause that the file violates, if it is refused.
    pub refused: Option<String>,
    /// Explanation of the arithmetic.
    pub because: Option<String>,
}

/// Part of an example file, with a description.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Descriptive name of the part.
    #[serde(rename = "is")]
    pub name: String,
    text: Option<String>,
    hex: Option<String>,
    stream: Option<String>,
    /// Number of copies of the bytes, 1 by default.
    times: Option<usize>,
}

/// Base files and streams for the examples.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Files {
    files: BTreeMap<String, Vec<Part>>,
    streams: BTreeMap<String, String>,
}

/// Annotated format: all chapters, and the files of their examples.
#[derive(Clone, Debug)]
pub struct Annotated {
    /// Chapters in the order of the specification.
    pub chapters: Vec<Chapter>,
    /// Base files for the examples.
    pub files: Files,
}

/// Embedded chapters in the order of the specification.
pub const CHAPTERS: &[(&str, &str)] = ptm_spec_cases::CHAPTERS;

/// Base files for the examples.
pub const FILES: &str = ptm_spec_cases::CHAPTER_FILES;

impl Annotated {
    /// Parses the base files for the examples, and the chapters, each of which is a pair of a file name and a text.
    ///
    /// # Errors
    /// Returns a message that names the file and the line.
    pub fn read(chapters: &[(&str, &str)], files: &str) -> Result<Annotated, String> {
        Ok(Annotated {
            chapters: from_files(chapters)?,
            files: from_yaml(files).map_err(|error| format!("files.yaml: {error}"))?,
        })
    }
}

impl Files {
    /// Returns the description and the bytes of each part of a base file, with some parts replaced.
    ///
    /// # Errors
    /// Returns a message that names the missing part or file.
    pub fn parts(
        &self,
        file: &str,
        replacements: &[Part],
    ) -> Result<Vec<(String, Vec<u8>)>, String> {
        let parts = self.files.get(file);
        let parts = parts.ok_or_else(|| format!("unknown file {file}"))?;
        for part in replacements {
            if parts.iter().all(|old| old.name != part.name) {
                return Err(format!("{file} has no part {:?}", part.name));
            }
        }
        let replaced = parts.iter().map(|old| {
            let part = replacements.iter().find(|part| part.name == old.name);
            let part = part.unwrap_or(old);
            Ok((part.name.clone(), self.bytes(part)?))
        });
        replaced.collect()
    }

    fn bytes(&self, part: &Part) -> Result<Vec<u8>, String> {
        let bytes = match (&part.text, &part.hex, &part.stream) {
            (Some(text), None, None) => Ok(text.as_bytes().to_vec()),
            (None, Some(hex), None) => parse_hex(hex),
            (None, None, Some(stream)) => {
                let stream = self.streams.get(stream);
                parse_hex(stream.ok_or_else(|| format!("part {:?}: unknown stream", part.name))?)
            }
            _ => Err("expected one of text, hex and stream".into()),
        };
        let bytes = bytes.map_err(|error| format!("part {:?}: {error}", part.name))?;
        Ok(bytes.repeat(part.times.unwrap_or(1)))
    }
}
