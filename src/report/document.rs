//! The report as a plain value, which every form of it borrows.
//!
//! It has no clock, path or host in it, so that two runs of the same thing are equal.

use serde::{Deserialize, Serialize};

use crate::report::baseline::BaselineNews;
use crate::report::leniency::Leniency;
use crate::session::outcome::Outcome;
use crate::session::remark::Remark;
use crate::session::scores::Scores;
use crate::suite::name::SuiteName;

/// The version of the form of reports. A reader refuses all others.
pub const SCHEMA: u32 = 2;

/// All that is said of a decoder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// The version of this form of report.
    pub schema: u32,
    /// What was asked.
    pub suite: SuiteName,
    /// The program that judged.
    pub tool: Tool,
    /// The decoder under test.
    pub decoder: DecoderInfo,
    /// `pass`, `fail` or `not a decoder`.
    pub verdict: String,
    /// The reason, where it is no decoder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Three scores; never one percentage.
    pub scores: Scores,
    /// What is to be said of the run as a whole.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<Remark>,
    /// How it reads what the text leaves open: ruling and reading.
    pub dialect: Vec<FollowedReading>,
    /// What it does with files outside the specification, ruling by ruling.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lenient: Vec<Leniency>,
    /// The failures held against those that were known, where a list of them was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<BaselineNews>,
    /// Likely causes, most telling first.
    pub diagnoses: Vec<LikelyCause>,
    /// Every selected case, in the order of the suite.
    pub cases: Vec<CaseResult>,
}

/// The program that judged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tool {
    /// `ptm-conform`
    pub name: String,
    /// Its version.
    pub version: String,
    /// A digest of all files of the suite.
    pub corpus: String,
    /// The limits under which the decoder ran.
    pub limits: Vec<String>,
}

/// The decoder under test.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecoderInfo {
    /// Its command, without directories.
    pub command: String,
    /// What it calls itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The version it gives.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// `one-shot`, or `serve` where its processes answer many requests.
    pub mode: String,
    /// The views it offers.
    pub views: Vec<String>,
    /// What it decodes.
    pub decodes: Vec<String>,
    /// Features for which it always exits with 69.
    pub unsupported: Vec<String>,
}

/// A reading of an open question.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FollowedReading {
    /// The ruling.
    pub ruling: String,
    /// The reading that the decoder follows.
    pub reading: String,
    /// Cases that show it, the first few.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shown_by: Vec<String>,
}

/// A likely cause.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LikelyCause {
    /// The misreading, if the catalog has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misreading: Option<String>,
    /// The kind of failure, if no misreading is named: refusal, acceptance, violation, difference or nondeterminism.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// The clause it misreads.
    pub clause: String,
    /// What the decoder does.
    pub effect: String,
    /// What to do about it.
    pub fix: String,
    /// Misreadings that would look the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub or: Vec<String>,
    /// Other misreadings that show in the same cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<String>,
    /// The failing cases it reproduces exactly.
    pub explains: Vec<String>,
    /// The failing cases that it explains in part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub partly: Vec<String>,
    /// Cases that pass although a decoder with this mistake would fail them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub except: Vec<String>,
    /// One failure in detail, down to the bytes of the file, if no misreading is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub example: Option<String>,
}

/// What is said of a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaseResult {
    /// The case.
    pub id: String,
    /// The verdict on it.
    pub outcome: String,
    /// The view it was asked in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// What was expected.
    pub expect: String,
    /// The clauses it is about.
    pub clauses: Vec<String>,
    /// Why the outcome is what it is, where that needs words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub says: Option<String>,
    /// Whether it was refused by the exit status of `--reject-exit`, which may mean a crash as well.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weak: bool,
    /// The beginning of the decoder's standard error, where the case failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stderr: Option<String>,
}

impl LikelyCause {
    /// Whether it is the clause that is misread: a crash or a nondeterministic answer misreads none.
    #[must_use]
    pub fn blames_its_clause(&self) -> bool {
        !matches!(self.kind.as_deref(), Some("violation" | "nondeterminism"))
    }

    /// A name for it: the misreading, or else the kind of failure.
    #[must_use]
    pub fn name(&self) -> &str {
        let name = self.misreading.as_deref().or(self.kind.as_deref());
        name.unwrap_or("unknown")
    }

    /// Returns the misreading, or the effect in words.
    #[must_use]
    pub fn title(&self) -> &str {
        self.misreading.as_deref().unwrap_or(&self.effect)
    }
}

impl Report {
    /// The cases with this outcome.
    pub fn with(&self, outcome: Outcome) -> impl Iterator<Item = &CaseResult> {
        let cases = self.cases.iter();
        cases.filter(move |case| case.outcome == outcome.name())
    }

    /// Whether this failure was known before (`--baseline`).
    #[must_use]
    pub fn is_known(&self, case: &CaseResult) -> bool {
        let news = self.baseline.as_ref();
        news.is_some_and(|news| news.known.contains(&case.id))
    }

    /// The cause under which this failure stands: one that reproduces it, or else one that does in part.
    #[must_use]
    pub fn cause_of(&self, case: &CaseResult) -> Option<&LikelyCause> {
        let with = |of: fn(&LikelyCause) -> &[String]| {
            let mut causes = self.diagnoses.iter();
            causes.find(|cause| of(cause).contains(&case.id))
        };
        with(|cause| &cause.explains).or_else(|| with(|cause| &cause.partly))
    }
}

/// The section of a clause: `2.4` of `2.4/8`, `R-TBL` of `R-TBL-04`.
#[must_use]
pub fn section_of(clause: &str) -> &str {
    let ends = clause.split_once('/').or_else(|| clause.rsplit_once('-'));
    ends.map_or(clause, |(section, _)| section)
}
