//! Known failures: a list of cases that are expected to fail, so that only new failures are errors.
//!
//! ```yaml
//! - id: table-of-257-entries-ptm-lut
//!   reason: two-byte indices come with version 2
//! - id: lum-translated-0-0
//! ```
//!
//! A listed case that fails is *known*. A failing case that is not listed is *new*. A listed case that passes is *stale*: its
//! line should be removed. A listed case with any other outcome, or that was not selected, is ignored.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::kit::yaml::{read_text, records, to_yaml};
use crate::session::outcome::{Judged, Outcome};
use crate::session::run::Run;
use crate::suite::cases::Suite;
use crate::suite::test_case::TestCase;

/// A list of known failures, by id.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline(BTreeMap<String, Option<String>>);

/// An entry of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    id: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// The comparison of a run with a baseline: ids, in the order of the suite.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BaselineNews {
    /// Listed, and failing.
    pub known: Vec<String>,
    /// Failing, and not listed.
    pub new: Vec<String>,
    /// Listed, and passing.
    pub stale: Vec<String>,
}

impl BaselineNews {
    /// Returns the exit status of `check` if some failures are known: 0, 1, 3 or 4.
    #[must_use]
    pub fn exit_status<C: TestCase>(&self, run: &Run<C>) -> u8 {
        match run.status(!self.new.is_empty()) {
            0 if !self.stale.is_empty() => 4,
            status => status,
        }
    }
}

impl Baseline {
    /// Reads a baseline.
    ///
    /// # Errors
    /// A sentence that names the file and the line at fault; also for an unknown or duplicate id.
    pub fn read<C: TestCase>(path: &Path, suite: &Suite<C>) -> Result<Baseline, String> {
        let named = |error: String| format!("{}: {error}", path.display());
        let mut listed = BTreeMap::new();
        for (number, Known { id, reason }) in records(&read_text(path)?).map_err(named)? {
            let fault = |what: String| Err(named(format!("line {number}: {what}")));
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

    /// Compares verdicts, one slot per case of `suite`, with the baseline.
    #[must_use]
    pub fn news<C: TestCase>(&self, suite: &Suite<C>, judged: &[Option<Judged>]) -> BaselineNews {
        let mut news = BaselineNews::default();
        for (case, judged) in suite.cases.iter().zip(judged) {
            let Some(judged) = judged else { continue };
            let list = match (judged.outcome, self.0.contains_key(case.id())) {
                (Outcome::Fail, true) => &mut news.known,
                (Outcome::Fail, false) => &mut news.new,
                (Outcome::Pass, true) => &mut news.stale,
                _ => continue,
            };
            list.push(case.id().to_owned());
        }
        news
    }

    /// Returns the baseline in which this run's failures are known, with the reasons of the old one. Old entries that neither
    /// passed nor failed are kept. In the order of the suite.
    #[must_use]
    pub fn renewed<C: TestCase>(&self, suite: &Suite<C>, judged: &[Option<Judged>]) -> String {
        let mut known = Vec::new();
        for (case, judged) in suite.cases.iter().zip(judged) {
            let listed = self.0.get(case.id());
            let stays = match judged.as_ref().map(|judged| judged.outcome) {
                Some(Outcome::Fail) => true,
                Some(Outcome::Pass) => false,
                _ => listed.is_some(),
            };
            if stays {
                known.push(Known {
                    id: case.id().to_owned(),
                    reason: listed.cloned().flatten(),
                });
            }
        }
        let list = match known.is_empty() {
            true => "[]\n".to_owned(),
            false => to_yaml(&known).expect("strings can be written"),
        };
        format!(
            "# Known failures, for ptm-conform check --baseline. A reason: may stand below each id.\n{list}"
        )
    }
}
