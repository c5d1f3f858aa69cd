//! Writing a report as YAML, and reading it back.
//!
//! The file is untrusted: its size is limited, anchors and aliases are refused, and an error names the line.

use std::path::Path;

use serde::Deserialize;

use crate::kit::yaml::{from_yaml, read_text, to_yaml};
use crate::report::document::{Report, SCHEMA};

/// The fields that identify a version of the schema.
#[derive(Deserialize)]
struct Form {
    schema: Option<u32>,
}

impl Report {
    /// Returns the report as YAML.
    ///
    /// # Errors
    /// No error that depends on the report.
    pub fn to_yaml(&self) -> Result<String, String> {
        to_yaml(self)
    }

    /// Reads a report that `check` has written to `path`.
    ///
    /// # Errors
    /// A sentence that names the file, and the line at fault if there is one; also for a report of another version.
    pub fn read(path: &Path) -> Result<Report, String> {
        let text = read_text(path)?;
        let named = |error: String| format!("{}: {error}", path.display());
        let hint = match text.starts_with("- ") {
            true => {
                "\nit is a list, like FILE.partial; a report is a mapping that begins with schema:"
            }
            false => "",
        };
        let form = from_yaml::<Form>(&text).map_err(|error| named(error + hint))?;
        match form.schema {
            Some(SCHEMA) => match from_yaml::<Report>(&text).map_err(named)? {
                Report {
                    results: Some(_), ..
                } => Err(named(
                    "a short report does not list the passing cases; run check without --short"
                        .to_owned(),
                )),
                report => Ok(report),
            },
            Some(other) => Err(named(format!(
                "line 1: a report of schema {other}, but this program reads schema {SCHEMA}"
            ))),
            None => Err(named(format!(
                "line 1: no report of schema {SCHEMA}; run check again if an older version wrote it"
            ))),
        }
    }
}
