//! Known failures: a list of cases that are expected to fail, so that only news is an error.
//!
//! ```yaml
//! - id: table-of-257-entries-ptm-lut
//!   reason: two-byte indices come with version 2
//! - id: lum-translated-0-0
//! ```
//!
//! A listed case that fails is *known*. A failing case that is not listed is *new*. A listed case that passes is *stale*:
//! its line should go. A listed case with any other outcome, or that was not selected, is left alone.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::harness::cases::Suite;
use crate::harness::judge::{Judged, Outcome};
use crate::harness::report::{from_yaml, text_of};

/// A list of known failures, by id.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline(BTreeMap<String, Option<String>>);

/// A line of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    id: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// A run held against a baseline: ids, in the order of the suite.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct News {
    /// Listed, and failing.
    pub known: Vec<String>,
    /// Failing, and not listed.
    pub new: Vec<String>,
    /// Listed, and passing.
    pub stale: Vec<String>,
}

impl Baseline {
    /// Reads a list.
    ///
    /// # Errors
    /// A sentence that names the file and the line at fault; also for an id that the suite does not have, or twice.
    pub fn read(path: &Path, suite: &Suite) -> Result<Baseline, String> {
        Baseline::parse(&text_of(path)?, suite)
            .map_err(|error| format!("{}: {error}", path.display()))
    }

    fn parse(text: &str, suite: &Suite) -> Result<Baseline, String> {
        let mut listed = BTreeMap::new();
        let lines: Vec<serde_saphyr::Spanned<Known>> = if text.trim().is_empty() {
            Vec::new()
        } else {
            from_yaml(text)?
        };
        for line in lines {
            let number = line.referenced.line();
            let Known { id, reason } = line.value;
            if suite.case(&id).is_none() {
                return Err(format!("line {number}: no case is called {id:?}"));
            }
            if listed.contains_key(&id) {
                return Err(format!("line {number}: {id} is there twice"));
            }
            listed.insert(id, reason);
        }
        Ok(Baseline(listed))
    }

    /// Holds verdicts, a place for each case of `suite`, against the list.
    #[must_use]
    pub fn news(&self, suite: &Suite, judged: &[Option<Judged>]) -> News {
        let mut news = News::default();
        for (case, judged) in suite.cases.iter().zip(judged) {
            let Some(judged) = judged else { continue };
            let list = match (judged.outcome, self.0.contains_key(&case.id)) {
                (Outcome::Fail, true) => &mut news.known,
                (Outcome::Fail, false) => &mut news.new,
                (Outcome::Pass, true) => &mut news.stale,
                _ => continue,
            };
            list.push(case.id.clone());
        }
        news
    }

    /// The list that makes this run's failures known: what failed, with the reasons of this list, and what of this list
    /// was neither seen to pass nor to fail. In the order of the suite.
    #[must_use]
    pub fn renewed(&self, suite: &Suite, judged: &[Option<Judged>]) -> String {
        let stays = |id: &str, judged: &Option<Judged>| match judged
            .as_ref()
            .map(|judged| judged.outcome)
        {
            Some(Outcome::Fail) => true,
            Some(Outcome::Pass) => false,
            _ => self.0.contains_key(id),
        };
        let known: Vec<Known> = suite
            .cases
            .iter()
            .zip(judged)
            .filter(|(case, judged)| stays(&case.id, judged))
            .map(|(case, _)| Known {
                id: case.id.clone(),
                reason: self.0.get(&case.id).cloned().flatten(),
            })
            .collect();
        let list = if known.is_empty() {
            "[]\n".to_owned()
        } else {
            serde_saphyr::to_string(&known).expect("strings can be written")
        };
        format!(
            "# Known failures, for ptm-conform check --baseline. A reason: may stand below each id.\n{list}"
        )
    }
}
