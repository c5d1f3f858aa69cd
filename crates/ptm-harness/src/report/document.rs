//! Reports as plain data. All output formats are generated from these types.
//!
//! A report contains no time, path or host name, so equal runs have equal reports.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::diagnose::Category;
use crate::report::leniency::Leniency;
use crate::report::words::{CALLER_COMMAND, for_functions};
use crate::session::remark::Remark;
use ptm_suite::kit::{digest::sha256, yaml::to_yaml};
use ptm_suite::name::SuiteName;
use ptm_suite::verdicts::{outcome::Outcome, scores::Scores};

/// Version of the report schema. Reports with any other version are rejected.
pub const SCHEMA: u32 = 2;

/// Report on a decoder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// Version of the schema.
    pub schema: u32,
    /// Suite that was run.
    pub suite: SuiteName,
    /// Program that produced the verdicts.
    pub tool: Tool,
    /// Decoder under test.
    pub decoder: DecoderInfo,
    /// Overall verdict.
    pub verdict: Verdict,
    /// Reason why the program is not a decoder, if it is not one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Scores for correctness, breadth and robustness.
    pub scores: Scores,
    /// Remarks on the run as a whole.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<Remark>,
    /// Features that the decoder lacks, each with the number of cases that were not requested for that reason. It exited with 69 for
    /// the first files that need the feature. These cases are not in `cases`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub not_asked: BTreeMap<String, usize>,
    /// The decoder's readings of open questions.
    pub dialect: Vec<FollowedReading>,
    /// Behavior of the decoder on files outside the specification, one entry per ruling.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lenient: Vec<Leniency>,
    /// Comparison of the failures with the baseline, if a baseline was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<BaselineComparison>,
    /// Likely causes, sorted by the number of cases that each explains.
    pub diagnoses: Vec<LikelyCause>,
    /// Digest of all results, if the passing cases are omitted.
    #[serde(default, rename = "results", skip_serializing_if = "Option::is_none")]
    pub results_digest: Option<String>,
    /// Results of the selected cases, in suite order.
    pub cases: Vec<CaseResult>,
}

/// Overall verdict on a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Nothing fails.
    #[serde(rename = "pass")]
    Pass,
    /// A case or the run as a whole fails.
    #[serde(rename = "fail")]
    Fail,
    /// The program is not a decoder.
    #[serde(rename = "not a decoder")]
    NotADecoder,
    /// The program is not a writer.
    #[serde(rename = "not a writer")]
    NotAWriter,
}

impl Verdict {
    /// Returns the name used in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Pass => "pass",
            Verdict::Fail => "fail",
            Verdict::NotADecoder => "not a decoder",
            Verdict::NotAWriter => "not a writer",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Program that produced the verdicts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tool {
    /// Name of the program: `ptm-conform`.
    pub name: String,
    /// Version of the program.
    pub version: String,
    /// Digest of all files in the suite.
    pub corpus: String,
    /// Limits under which the decoder ran.
    pub limits: Vec<String>,
}

/// Decoder under test.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DecoderInfo {
    /// Command line of the decoder, without directories.
    pub command: String,
    /// Name that the decoder declares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Version that the decoder declares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// `one-shot`, or `serve` if one process answers many requests.
    pub mode: String,
    /// Views that the decoder supports.
    pub views: Vec<String>,
    /// Features with at least one file that the decoder decodes.
    pub decodes: Vec<String>,
    /// Features for which the decoder always exits with status 69.
    pub unsupported: Vec<String>,
}

/// A decoder's reading of an open question.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FollowedReading {
    /// Id of the ruling.
    pub ruling: String,
    /// Name of the reading.
    pub reading: String,
    /// The first few cases that demonstrate the reading.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shown_by: Vec<String>,
}

/// Result of comparing a report with a baseline: case ids in suite order.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BaselineComparison {
    /// Cases that are listed and fail.
    pub known: Vec<String>,
    /// Cases that fail and are not listed.
    pub new: Vec<String>,
    /// Cases that are listed but pass.
    pub stale: Vec<String>,
}

/// Likely cause of failures.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LikelyCause {
    /// Slug of the misreading, if the cause is in the catalog.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misreading: Option<String>,
    /// Kind of failure if no misreading is named: refusal, acceptance, violation, difference or nondeterminism.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<Category>,
    /// Clause that the decoder misreads, or that all of the cases test.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clause: Option<String>,
    /// Behavior of the decoder.
    pub effect: String,
    /// Suggested fix.
    pub fix: String,
    /// Slugs of misreadings with the same effect on these cases.
    #[serde(rename = "or", default, skip_serializing_if = "Vec::is_empty")]
    pub equivalents: Vec<String>,
    /// Slugs of other misreadings that affect the same cases.
    #[serde(rename = "with", default, skip_serializing_if = "Vec::is_empty")]
    pub accompanying: Vec<String>,
    /// Effects of other mistakes, outside the catalog, that affect the same cases.
    #[serde(rename = "with_edits", default, skip_serializing_if = "Vec::is_empty")]
    pub accompanying_edits: Vec<String>,
    /// Failing cases that this cause reproduces or describes. The example is the first one.
    pub explains: Vec<String>,
    /// Detailed description of one failure, down to the bytes of the file, if no misreading is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub example: Option<String>,
}

/// Result of a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaseResult {
    /// Id of the case.
    pub id: String,
    /// Outcome of the case.
    pub outcome: Outcome,
    /// Requested view; empty if the case was not requested.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub view: String,
    /// Expected result.
    pub expect: String,
    /// Clauses that the case tests.
    pub clauses: Vec<String>,
    /// Explanation of the outcome; empty if none is needed.
    #[serde(rename = "says", default, skip_serializing_if = "String::is_empty")]
    pub message: String,
    /// True if the file was refused with the exit status given with `--reject-exit`. That status may also mean a crash.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub weak: bool,
    /// Beginning of the decoder's standard error, if the case failed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub stderr: String,
}

impl LikelyCause {
    /// Returns the misread clause, if there is one. A crash or a nondeterministic answer misreads no clause.
    #[must_use]
    pub fn misread_clause(&self) -> Option<&str> {
        let is_misreading = !matches!(
            self.kind,
            Some(Category::Violation | Category::Nondeterminism)
        );
        self.clause.as_deref().filter(|_| is_misreading)
    }

    /// Returns text such as " (clause 2.4/8)", or an empty string if no clause is misread.
    #[must_use]
    pub fn clause_text(&self) -> String {
        let clause = self.misread_clause();
        clause.map_or_else(String::new, |clause| format!(" (clause {clause})"))
    }

    /// Returns the slug of the misreading, or the kind of failure if no misreading is named.
    #[must_use]
    pub fn name(&self) -> &str {
        let kind = self.kind.map_or("unknown", Category::name);
        self.misreading.as_deref().unwrap_or(kind)
    }

    /// Returns the slug of the misreading, or a description of the effect if no misreading is named.
    #[must_use]
    pub fn title(&self) -> &str {
        self.misreading.as_deref().unwrap_or(&self.effect)
    }
}

impl Report {
    /// Removes the passing cases and adds a digest of all results.
    ///
    /// # Errors
    /// Returns an error if serialization fails, which should never happen.
    pub fn without_passing_cases(mut self) -> Result<Report, String> {
        self.results_digest = Some(sha256(to_yaml(&self.cases)?.as_bytes()));
        self.cases.retain(|case| case.outcome != Outcome::Pass);
        Ok(self)
    }

    /// Returns the number of cases with each outcome, as a comma-separated list.
    #[must_use]
    pub fn counts(&self) -> String {
        let mut counts = Vec::new();
        for outcome in Outcome::ALL {
            match self.with_outcome(outcome).count() {
                0 => {}
                count => counts.push(format!("{count} {outcome}")),
            }
        }
        counts.join(", ")
    }

    /// Returns the cases with the given outcome.
    pub fn with_outcome(&self, outcome: Outcome) -> impl Iterator<Item = &CaseResult> {
        let cases = self.cases.iter();
        cases.filter(move |case| case.outcome == outcome)
    }

    /// Returns a text about the decoder; if the decoder is a function, with the words for functions instead of programs.
    #[must_use]
    pub fn in_words_for_decoder(&self, text: &str) -> String {
        match self.decoder.command == CALLER_COMMAND {
            true => for_functions(text),
            false => text.to_owned(),
        }
    }

    /// If the decoder is a function, replaces words about programs in all texts.
    pub fn speak_of_functions(&mut self) {
        if self.decoder.command != CALLER_COMMAND {
            return;
        }
        let causes = self.diagnoses.iter_mut();
        let of_causes = causes.flat_map(|cause| {
            [
                Some(&mut cause.effect),
                Some(&mut cause.fix),
                cause.example.as_mut(),
            ]
        });
        let texts = of_causes
            .flatten()
            .chain(&mut self.reason)
            .chain(self.remarks.iter_mut().map(|remark| &mut remark.message))
            .chain(self.cases.iter_mut().map(|case| &mut case.message));
        for text in texts {
            *text = for_functions(text);
        }
    }

    /// Returns true if the baseline given with `--baseline` lists this failure.
    #[must_use]
    pub fn is_known(&self, case: &CaseResult) -> bool {
        let baseline = self.baseline.as_ref();
        baseline.is_some_and(|baseline| baseline.known.contains(&case.id))
    }

    /// Returns the first cause that explains this failure.
    #[must_use]
    pub fn cause_of(&self, case: &CaseResult) -> Option<&LikelyCause> {
        let mut causes = self.diagnoses.iter();
        causes.find(|cause| cause.explains.contains(&case.id))
    }
}
