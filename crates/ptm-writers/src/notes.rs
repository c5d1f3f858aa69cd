//! Notes on the files of a writer that do not count as failures: warnings of `lint`, and refusals that are allowed.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use crate::test_case::{FileCase, RequestValues, WrittenFile};
use ptm_files::lint::codes::Severity;
use ptm_files::lint::{diagnostic::Diagnostic, lint};
use ptm_harness::session::remark::Remark;
use ptm_suite::cases::{Expect, TableSpelling};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::test_case::TestCase;

/// Collects notes during a run.
#[derive(Debug, Default)]
pub struct Notes(Mutex<Collected>);

#[derive(Debug, Default)]
struct Collected {
    /// Requests whose files have a warning, by the code and the text of the warning.
    warnings: BTreeMap<(String, String), BTreeSet<String>>,
    /// Optional requests that were refused.
    refusals: BTreeSet<String>,
}

impl Notes {
    /// Adds the notes on an answer.
    ///
    /// # Panics
    /// Panics if another thread panicked in this function.
    pub fn add<V: RequestValues>(&self, case: &FileCase<V>, answer: &Answer<WrittenFile>) {
        let warnings = match answer {
            Answer::Decoded(file) => avoidable_warnings(case, &file.0),
            _ => Vec::new(),
        };
        let is_refusal = matches!(answer, Answer::Rejected | Answer::Unsupported);
        let mut collected = self.0.lock().expect("no thread panics here");
        for warning in warnings {
            let key = (warning.code.to_string(), warning.message.to_string());
            collected
                .warnings
                .entry(key)
                .or_default()
                .insert(case.id.clone());
        }
        if is_refusal && case.expect == Expect::Lenient {
            collected.refusals.insert(case.id.clone());
        }
    }

    /// Returns the notes as remarks.
    ///
    /// # Panics
    /// Panics if a thread panicked in [`Notes::add`].
    #[must_use]
    pub fn remarks(&self) -> Vec<Remark> {
        let Collected { warnings, refusals } = &*self.0.lock().expect("no thread panics here");
        let mut remarks = Vec::new();
        if !refusals.is_empty() {
            let refusals: Vec<&str> = refusals.iter().map(String::as_str).collect();
            remarks.push(Remark::note(format!(
                "the program refuses {}, which is allowed: the lights do not determine all coefficients",
                refusals.join(", ")
            )));
        }
        for ((code, message), ids) in warnings {
            let first = ids.first().map_or("", String::as_str);
            let files = match ids.len() {
                1 => first.to_owned(),
                count => format!("{count} files, for example {first}"),
            };
            remarks.push(Remark::note(format!(
                "lint warns about {files}: {message} ({code})"
            )));
        }
        remarks
    }
}

/// Returns the warnings about a file that the file of the reference does not have.
fn avoidable_warnings<V: RequestValues>(case: &FileCase<V>, file: &[u8]) -> Vec<Diagnostic> {
    let mut warnings = lint(file);
    warnings.retain(|found| found.severity == Severity::Warning);
    if warnings.is_empty() {
        return warnings;
    }
    let built = case.make(TableSpelling::default());
    let reference = V::reference_file(&built.request, case.format).unwrap_or_default();
    let unavoidable = lint(&reference);
    warnings.retain(|found| unavoidable.iter().all(|other| other.code != found.code));
    warnings
}
