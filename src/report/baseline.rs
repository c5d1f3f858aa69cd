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

use crate::kit::yaml::{read_text, records, to_yaml};
use crate::session::{outcome::Outcome, run::Run};
use crate::suite::{cases::Suite, test_case::TestCase};

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

/// Result of comparing a run with a baseline: case ids in suite order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BaselineComparison {
    /// Cases that are listed and fail.
    pub known: Vec<String>,
    /// Cases that fail and are not listed.
    pub new: Vec<String>,
    /// Cases that are listed but pass.
    pub stale: Vec<String>,
}

impl BaselineComparison {
    /// Returns the exit status of `check --baseline`: 0, 1, 3 or 4.
    #[must_use]
    pub fn exit_status<C: TestCase>(&self, run: &Run<C>) -> u8 {
        match run.status(!self.new.is_empty()) {
            0 if !self.stale.is_empty() => 4,
            status => status,
        }
    }
}

impl Baseline {
    /// Reads a baseline file.
    ///
    /// # Errors
    /// Returns a message that names the file and the line if the file is malformed or contains an unknown or duplicate id.
    pub fn read<C: TestCase>(path: &Path, suite: &Suite<C>) -> Result<Baseline, String> {
        let in_file = |error: String| format!("{}: {error}", path.display());
        let mut listed = BTreeMap::new();
        for (number, KnownFailure { id, reason }) in records(&read_text(path)?).map_err(in_file)? {
            let fault = |error: String| Err(in_file(format!("line {number}: {error}")));
            if suite.case(&id).is_none() {
                return fault(format!("unknown case {id:?}"));
            }
            if listed.contains_key(&id) {
                return fault(format!("duplicate case {id}"));
            }
            listed.insert(id, reason);
        }
        Ok(Baseline(listed))
    }

    /// Compares a run with the baseline.
    #[must_use]
    pub fn compare<C: TestCase>(&self, suite: &Suite<C>, run: &Run<C>) -> BaselineComparison {
        let mut comparison = BaselineComparison::default();
        for (case, judged) in suite.cases.iter().zip(&run.judgment.cases) {
            let Some(judged) = judged else { continue };
            let list = match (judged.outcome, self.0.contains_key(case.id())) {
                (Outcome::Fail, true) => &mut comparison.known,
                (Outcome::Fail, false) => &mut comparison.new,
                (Outcome::Pass, true) => &mut comparison.stale,
                _ => continue,
            };
            list.push(case.id().to_owned());
        }
        comparison
    }

    /// Returns the YAML of an updated baseline that lists the failures of this run in suite order. Reasons are preserved,
    /// and so are entries of cases that neither passed nor failed.
    #[must_use]
    pub fn to_updated_yaml<C: TestCase>(&self, suite: &Suite<C>, run: &Run<C>) -> String {
        let mut known = Vec::new();
        for (case, judged) in suite.cases.iter().zip(&run.judgment.cases) {
            let listed = self.0.get(case.id());
            let stays = match judged.as_ref().map(|judged| judged.outcome) {
                Some(Outcome::Fail) => true,
                Some(Outcome::Pass) => false,
                _ => listed.is_some(),
            };
            if stays {
                let (id, reason) = (case.id().to_owned(), listed.cloned().flatten());
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
