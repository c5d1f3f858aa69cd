//! Serializes reports to YAML, and parses YAML reports.
//!
//! A report file is untrusted: its size is limited, anchors and aliases are rejected, and error messages name the line.

use std::path::Path;

use serde::Deserialize;

use crate::report::document::{Report, SCHEMA};
use ptm_suite::kit::escape_controls;
use ptm_suite::kit::yaml::{from_yaml, read_text, to_yaml};

/// Field that identifies the version of the schema.
#[derive(Deserialize)]
struct SchemaVersion {
    schema: Option<u32>,
}

impl Report {
    /// Serializes the report as YAML.
    ///
    /// # Errors
    /// Returns an error if serialization fails, which should never happen.
    pub fn to_yaml(&self) -> Result<String, String> {
        Ok(to_yaml(self)?)
    }

    /// Reads a report that `check` wrote to `path`.
    ///
    /// # Errors
    /// Returns a message with the file and, if known, the line. Rejects short reports (`--short`) and other schema versions.
    pub fn read(path: &Path) -> Result<Report, String> {
        let text = read_text(path)?;
        let in_file = |error: ptm_suite::Error| {
            format!(
                "{}: {}",
                path.display(),
                escape_controls(&error.to_string())
            )
        };
        let list = "\nthe file is a list, like FILE.partial; a report is a mapping that begins with schema:";
        let hint = if text.starts_with("- ") { list } else { "" };
        let form = from_yaml::<SchemaVersion>(&text).map_err(|error| in_file(error) + hint)?;
        let error = match form.schema {
            Some(SCHEMA) => match from_yaml::<Report>(&text).map_err(in_file)? {
                report if report.results_digest.is_none() => return Ok(report),
                _ => "a short report does not list the passing cases; run check without --short"
                    .to_owned(),
            },
            Some(other) => format!(
                "line 1: the report has schema {other}, but this program reads schema {SCHEMA}"
            ),
            None => format!(
                "line 1: not a report with schema {SCHEMA}; if an older version wrote the file, run check again"
            ),
        };
        Err(in_file(error.into()))
    }
}
