//! Results of public readers, loaded from `reports/readers/`, which contains one file per reader.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Deserialize;

use ptm_files::readers::{ReaderProfile, profiles};
use ptm_mistakes::Misreading;
use ptm_suite::kit::yaml::from_files;
use ptm_suite::verdicts::outcome::Outcome;

/// Run of the suite against a public reader.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReaderRun {
    /// Name of the reader, or owner and name of its repository.
    pub reader: String,
    /// Programming language of the reader.
    pub language: String,
    /// URL of the source code.
    pub source: String,
    /// Version that was run.
    pub version: String,
    /// Date of the version, if known.
    pub version_date: Option<String>,
    /// Date of the run.
    pub run_date: String,
    /// Command line of the reader.
    #[serde(rename = "called")]
    pub command: String,
    /// Remarks on the run.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// Views that the reader supports.
    pub views: Vec<String>,
    /// Version of the suite.
    pub suite: String,
    /// Number of cases in the suite.
    pub cases: usize,
    /// For each outcome other than `pass`, the ids of the cases with that outcome.
    pub outcomes: BTreeMap<String, Vec<String>>,
    /// Outcomes other than `pass`, by case id.
    #[serde(skip)]
    by_case: BTreeMap<String, Outcome>,
}

impl ReaderRun {
    pub(super) fn outcome(&self, id: &str) -> Outcome {
        self.by_case.get(id).copied().unwrap_or(Outcome::Pass)
    }

    /// Formats the number of cases with each outcome.
    pub(super) fn counts(&self) -> String {
        let passed = self.cases - self.by_case.len();
        let mut counts = format!("{passed} pass");
        for (outcome, cases) in &self.outcomes {
            let _ = write!(counts, ", {} {outcome}", cases.len());
        }
        counts
    }

    /// Formats the version of the reader with its date.
    pub(super) fn dated_version(&self) -> String {
        let date = self.version_date.as_ref();
        let date = date.map_or_else(String::new, |date| format!(" of {date}"));
        format!("{}{date}", self.version)
    }
}

/// Expands to the names and contents of reports.
macro_rules! reports {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../reports/readers/", $name)))),*]
    };
}

const FILES: &[(&str, &str)] = reports![
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
/// Returns a message that names the file and the error.
pub fn reader_runs() -> Result<Vec<ReaderRun>, String> {
    let mut runs: Vec<ReaderRun> = from_files(FILES)?;
    for (run, (name, _)) in runs.iter_mut().zip(FILES) {
        for (outcome, cases) in &run.outcomes {
            let mut all = Outcome::ALL.into_iter();
            let known = all.find(|known| known.name() == outcome);
            let known = known.ok_or_else(|| format!("{name}: unknown outcome {outcome:?}"))?;
            let cases = cases.iter().map(|case| (case.clone(), known));
            run.by_case.extend(cases);
        }
    }
    Ok(runs)
}

/// Returns the public readers that make a mistake according to profiles and sightings, with the examined versions.
pub(super) fn readers_with_mistake(misreading: &Misreading) -> BTreeMap<&str, Option<&str>> {
    let seen = misreading.sightings.iter();
    let seen = seen.map(|sighting| (sighting.reader.as_str(), sighting.version.as_deref()));
    let has_mistake = |profile: &&ReaderProfile| {
        let mut known = profile.misreadings.iter();
        known.any(|known| known.slug == misreading.slug)
    };
    let profiled = profiles().iter().filter(has_mistake);
    let profiled = profiled.map(|profile| (profile.reader.as_str(), profile.version.as_deref()));
    seen.chain(profiled).collect()
}
