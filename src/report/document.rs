//! The report as plain data, from which all output formats are made.
//!
//! It contains no time, path or host, so that two equal runs have equal reports.

use serde::{Deserialize, Serialize};

use crate::diagnose::Category;
use crate::kit::digest::sha256;
use crate::kit::yaml::to_yaml;
use crate::report::baseline::BaselineNews;
use crate::report::leniency::Leniency;
use crate::session::outcome::Outcome;
use crate::session::remark::Remark;
use crate::session::scores::Scores;
use crate::suite::name::SuiteName;

/// The version of the report schema. A reader refuses all others.
pub const SCHEMA: u32 = 2;

/// The report on a decoder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// The version of the schema.
    pub schema: u32,
    /// The suite.
    pub suite: SuiteName,
    /// The program that judged.
    pub tool: Tool,
    /// The decoder under test.
    pub decoder: DecoderInfo,
    /// `pass`, `fail` or `not a decoder`.
    pub verdict: String,
    /// The reason, if it is not a decoder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Three scores instead of one percentage.
    pub scores: Scores,
    /// Remarks on the run as a whole.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<Remark>,
    /// Its reading of open questions: ruling and reading.
    pub dialect: Vec<FollowedReading>,
    /// Its behavior for files outside the specification, ruling by ruling.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lenient: Vec<Leniency>,
    /// The comparison of failures with the baseline, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<BaselineNews>,
    /// Likely causes, the one that explains most first.
    pub diagnoses: Vec<LikelyCause>,
    /// The digest of all results, if the passing cases are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub results: Option<String>,
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
    /// The name that it declares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The version that it declares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// `one-shot`, or `serve` if its processes answer many requests.
    pub mode: String,
    /// The views it offers.
    pub views: Vec<String>,
    /// The features that it decodes.
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
    /// The first few cases that show it.
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
    pub kind: Option<Category>,
    /// The clause that it misreads.
    pub clause: String,
    /// The behavior of the decoder.
    pub effect: String,
    /// The suggested fix.
    pub fix: String,
    /// Misreadings with the same effect on these cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub or: Vec<String>,
    /// Other misreadings that show in the same cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<String>,
    /// The failing cases that it reproduces exactly.
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

/// The result of a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaseResult {
    /// The case.
    pub id: String,
    /// The verdict.
    pub outcome: Outcome,
    /// The view in which it was requested; empty if it was not.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub view: String,
    /// The expected result.
    pub expect: String,
    /// The clauses that it tests.
    pub clauses: Vec<String>,
    /// The reason for the outcome, if it needs words.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub says: String,
    /// True if it was refused by the exit status of `--reject-exit`, which may also mean a crash.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weak: bool,
    /// The beginning of the decoder's standard error, if the case failed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub stderr: String,
}

impl LikelyCause {
    /// Returns true if it means that the clause is misread; a crash or a nondeterministic answer does not.
    #[must_use]
    pub fn blames_its_clause(&self) -> bool {
        !matches!(
            self.kind,
            Some(Category::Violation | Category::Nondeterminism)
        )
    }

    /// Returns its name: the misreading, or else the kind of failure.
    #[must_use]
    pub fn name(&self) -> &str {
        let kind = self.kind.map_or("unknown", Category::name);
        self.misreading.as_deref().unwrap_or(kind)
    }

    /// Returns the misreading, or the effect in words.
    #[must_use]
    pub fn title(&self) -> &str {
        self.misreading.as_deref().unwrap_or(&self.effect)
    }
}

impl Report {
    /// Returns the short form: without the passing cases, but with a digest of all results.
    ///
    /// # Errors
    /// No error that depends on the report.
    pub fn shortened(mut self) -> Result<Report, String> {
        self.results = Some(sha256(to_yaml(&self.cases)?.as_bytes()));
        self.cases.retain(|case| case.outcome != Outcome::Pass);
        Ok(self)
    }

    /// Returns the cases with this outcome.
    pub fn with_outcome(&self, outcome: Outcome) -> impl Iterator<Item = &CaseResult> {
        let cases = self.cases.iter();
        cases.filter(move |case| case.outcome == outcome)
    }

    /// Returns true if this failure was known before (`--baseline`).
    #[must_use]
    pub fn is_known(&self, case: &CaseResult) -> bool {
        let news = self.baseline.as_ref();
        news.is_some_and(|news| news.known.contains(&case.id))
    }

    /// Returns the cause of this failure: one that reproduces it, or else one that explains it in part.
    #[must_use]
    pub fn cause_of(&self, case: &CaseResult) -> Option<&LikelyCause> {
        let with = |of: fn(&LikelyCause) -> &[String]| {
            let mut causes = self.diagnoses.iter();
            causes.find(|cause| of(cause).contains(&case.id))
        };
        with(|cause| &cause.explains).or_else(|| with(|cause| &cause.partly))
    }
}

/// Returns the section of a clause: `2.4` for `2.4/8`, `R-TBL` for `R-TBL-04`.
#[must_use]
pub fn section_of(clause: &str) -> &str {
    let ends = clause.split_once('/').or_else(|| clause.rsplit_once('-'));
    ends.map_or(clause, |(section, _)| section)
}
