//! Reading a report back.
//!
//! The file may be anything: only so much of it is read, anchors and aliases have no business in it, and an error names
//! the line.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::Report;

/// The largest file that is read: some two hundred thousand cases.
const LARGEST: u64 = 64 << 20;

impl Report {
    /// Reads the report that `check` has written to `path`.
    ///
    /// # Errors
    /// A sentence that names the file, and the line at fault where there is one.
    pub fn read(path: &Path) -> Result<Report, String> {
        let text = text_of(path)?;
        from_yaml(&text).map_err(|error| {
            let hint = if text.starts_with("- ") {
                "\nit is a list, as FILE.partial is; a report is a mapping that begins with tool:"
            } else {
                ""
            };
            format!("{}: {error}{hint}", path.display())
        })
    }
}

/// The text of a file that a user names.
///
/// # Errors
/// A sentence that names the file.
pub(in crate::harness) fn text_of(path: &Path) -> Result<String, String> {
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| named(&error))?;
    file.take(LARGEST + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| named(&error))?;
    if bytes.len() as u64 > LARGEST {
        return Err(named(&format!(
            "larger than {} MiB, which is no report",
            LARGEST >> 20
        )));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count();
        named(&format!("line {line}: not UTF-8"))
    })
}

/// Reads YAML that nobody vouches for.
///
/// # Errors
/// A sentence that names the line at fault.
pub(in crate::harness) fn from_yaml<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let options = serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            max_aliases: 0,
            max_anchors: 0,
            max_documents: 1,
            max_depth: 16,
            max_events: 16_000_000,
            max_nodes: 8_000_000,
        },
        with_snippet: false,
    };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let said = error.to_string();
        match error.location() {
            Some(location) if !said.contains("line ") => {
                format!("line {}: {said}", location.line())
            }
            _ => said,
        }
    })
}
