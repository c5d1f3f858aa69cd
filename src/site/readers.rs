//! The results of public readers in this suite: `reports/readers/`, a file for each.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Deserialize;

use crate::kit::{embedded, yaml::from_yaml};
use crate::misreadings::Misreading;
use crate::readers::{ReaderProfile, profiles};
use crate::session::outcome::Outcome;

/// One run of the suite against a public reader.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReaderRun {
    /// Its name, or owner and name for a repository.
    pub reader: String,
    /// Its programming language.
    pub language: String,
    /// The address of its source.
    pub source: String,
    /// The version that was run.
    pub version: String,
    /// The date of that version, if it is known.
    pub version_date: Option<String>,
    /// The date of the run.
    pub run_date: String,
    /// Its command line.
    pub called: String,
    /// Remarks on the run.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// The views that it offers.
    pub views: Vec<String>,
    /// The version of the suite.
    pub suite: String,
    /// The number of its cases.
    pub cases: usize,
    /// Each outcome but `pass`, with the ids of its cases.
    pub outcomes: BTreeMap<String, Vec<String>>,
    /// The outcome of each of these cases.
    #[serde(skip)]
    by_case: BTreeMap<String, String>,
}

impl ReaderRun {
    /// Returns the outcome of a case.
    pub(super) fn outcome(&self, id: &str) -> &str {
        let listed = self.by_case.get(id);
        listed.map_or(Outcome::Pass.name(), String::as_str)
    }

    /// Returns the number of cases with each outcome, in words.
    pub(super) fn counts(&self) -> String {
        let passed = self.cases - self.by_case.len();
        let mut counts = format!("{passed} pass");
        for (outcome, cases) in &self.outcomes {
            let _ = write!(counts, ", {} {outcome}", cases.len());
        }
        counts
    }

    /// Returns the version of the reader, with its date.
    pub(super) fn dated_version(&self) -> String {
        let date = self.version_date.as_ref();
        let date = date.map_or_else(String::new, |date| format!(" of {date}"));
        format!("{}{date}", self.version)
    }
}

const FILES: &[(&str, &str)] = embedded![
    "reports/readers",
    "cceh-rti.yaml",
    "jedmills.yaml",
    "oxrti.yaml",
    "ptmconvert.yaml",
    "relight.yaml",
    "rtiprep.yaml",
    "rtiviewer.yaml",
];

/// Returns all embedded runs.
///
/// # Errors
/// A sentence that names the file and the error.
pub fn reader_runs() -> Result<Vec<ReaderRun>, String> {
    let read = |(name, text): &(&str, &str)| {
        let mut run: ReaderRun = from_yaml(text).map_err(|error| format!("{name}: {error}"))?;
        let known = |outcome: &String| Outcome::ALL.iter().any(|known| known.name() == outcome);
        for (outcome, cases) in &run.outcomes {
            if !known(outcome) {
                return Err(format!("{name}: unknown outcome {outcome:?}"));
            }
            let cases = cases.iter().map(|case| (case.clone(), outcome.clone()));
            run.by_case.extend(cases);
        }
        Ok(run)
    };
    FILES.iter().map(read).collect()
}

/// The results of a reader for the cases of a clause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ReaderTally {
    /// Number of cases passed.
    pub passed: usize,
    /// Number of cases failed.
    pub failed: usize,
    /// Number of cases without evidence: unsupported, inconclusive, not judged, not run.
    pub open: usize,
}

impl ReaderTally {
    pub(super) fn add(&mut self, outcome: &str) {
        if outcome == Outcome::Pass.name() {
            self.passed += 1;
        } else if outcome == Outcome::Fail.name() {
            self.failed += 1;
        } else {
            self.open += 1;
        }
    }

    /// Returns a word and a symbol.
    pub(super) fn state(self) -> (&'static str, &'static str) {
        match self {
            ReaderTally { failed: 1.., .. } => ("fail", "✗"),
            ReaderTally { passed: 1.., .. } => ("pass", "✓"),
            ReaderTally { open: 1.., .. } => ("open", "–"),
            ReaderTally { .. } => ("none", "·"),
        }
    }
}

/// Returns public readers that make a mistake, with the examined version: from their profiles, and from sightings.
pub(super) fn makers(misreading: &Misreading) -> BTreeMap<&str, Option<&str>> {
    let seen = misreading.seen.iter();
    let seen = seen.map(|sighting| (sighting.reader.as_str(), sighting.version.as_deref()));
    let makes = |profile: &&ReaderProfile| {
        let mut known = profile.misreadings.iter();
        known.any(|known| known.slug == misreading.slug)
    };
    let profiled = profiles().iter().filter(makes);
    let profiled = profiled.map(|profile| (profile.reader.as_str(), profile.version.as_deref()));
    seen.chain(profiled).collect()
}
