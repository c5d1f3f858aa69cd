//! Baselines: lists of cases that are known to fail, so that only new failures are errors.
//!
//! ```yaml
//! - id: table-of-257-entries-ptm-lut
//!   reason: two-byte indices come with version 2
//! - id: lum-translated-0-0
//! ```
//!
//! A listed case that fails is *known*. A failing case that is not listed is *new*. A listed case that passes is *stale*: its
//! entry should be removed. A listed case that was not selected or has any other outcome is ignored.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::report::document::{BaselineComparison, Report};
use crate::report::suite_texts::SuiteTexts;
use ptm_suite::kit::yaml::{read_text, records, to_yaml};
use ptm_suite::verdicts::outcome::Outcome;

/// Known failures: case ids with optional reasons.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline(BTreeMap<String, Option<String>>);

/// Entry of a baseline file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownFailure {
    id: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl Baseline {
    /// Reads a baseline file.
    ///
    /// # Errors
    /// Returns a message that names the file and the line if the file is malformed or contains an unknown or duplicate id.
    pub fn read(path: &Path, texts: &SuiteTexts) -> Result<Baseline, String> {
        let in_file = |error: ptm_suite::Error| error.in_place(path.display());
        let mut listed = BTreeMap::new();
        for (number, KnownFailure { id, reason }) in records(&read_text(path)?).map_err(in_file)? {
            let fault =
                |error: String| Err(in_file(format!("line {number}: {error}").into()).into());
            if texts.purpose(&id).is_none() {
                return fault(format!("unknown case {id:?}"));
            }
            if listed.contains_key(&id) {
                return fault(format!("duplicate case {id}"));
            }
            listed.insert(id, reason);
        }
        Ok(Baseline(listed))
    }

    /// Compares a report with the baseline.
    #[must_use]
    pub fn compare(&self, report: &Report) -> BaselineComparison {
        let mut comparison = BaselineComparison::default();
        for case in &report.cases {
            let list = match (case.outcome, self.0.contains_key(&case.id)) {
                (Outcome::Fail, true) => &mut comparison.known,
                (Outcome::Fail, false) => &mut comparison.new,
                (Outcome::Pass, true) => &mut comparison.stale,
                _ => continue,
            };
            list.push(case.id.clone());
        }
        comparison
    }

    /// Returns the YAML of an updated baseline that lists the failures of a report in suite order. Reasons are preserved,
    /// and so are entries of cases that neither passed nor failed.
    #[must_use]
    pub fn to_updated_yaml(&self, texts: &SuiteTexts, report: &Report) -> String {
        // The cases of the report are also in suite order.
        let mut results = report.cases.iter().peekable();
        let mut known = Vec::new();
        for (id, _) in &texts.cases {
            let listed = self.0.get(id);
            let result = results.next_if(|case| case.id == *id);
            let stays = match result.map(|case| case.outcome) {
                Some(Outcome::Fail) => true,
                Some(Outcome::Pass) => false,
                _ => listed.is_some(),
            };
            if stays {
                let (id, reason) = (id.clone(), listed.cloned().flatten());
                known.push(KnownFailure { id, reason });
            }
        }
        let list = match known.is_empty() {
            true => "[]\n".to_owned(),
            false => to_yaml(&known).expect("strings can be written"),
        };
        format!(
            "# Known failures, for ptm-conform check --baseline. An entry may also have a reason field.\n{list}"
        )
    }
}
