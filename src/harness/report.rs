//! The report, and every word that the user of `check` reads.
//!
//! A report is a plain value; YAML and text are two ways of writing it. It has no clock, path or host in it, so that two
//! runs of the same thing are equal.

use std::fmt::Write;

use serde::Serialize;

use crate::harness::cases::{Case, Expect, Feature, Suite};
use crate::harness::check::Run;
use crate::harness::corpus;
use crate::harness::diagnose::Diagnosis;
use crate::harness::judge::{Judged, Outcome};

/// All that is said of a decoder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Report {
    /// The program that judged.
    pub tool: Tool,
    /// The decoder under test.
    pub decoder: Subject,
    /// `pass`, `fail` or `not a decoder`.
    pub verdict: String,
    /// The reason, where it is no decoder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Three scores; never one percentage.
    pub scores: Scores,
    /// How it reads what the text leaves open: ruling and reading.
    pub dialect: Vec<Reading>,
    /// Likely causes, most telling first.
    pub diagnoses: Vec<Cause>,
    /// Every selected case, in the order of the suite.
    pub cases: Vec<CaseResult>,
}

/// The program that judged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Subject {
    /// Its command, without directories.
    pub command: String,
    /// The views it offers.
    pub views: Vec<String>,
    /// What it decodes.
    pub decodes: Vec<String>,
    /// What it answers 69 to, throughout.
    pub unsupported: Vec<String>,
}

/// A numerator and a denominator each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Scores {
    /// Cases passed of cases judged, among the features it supports.
    pub correctness: String,
    /// Features decoded of features in the suite.
    pub breadth: String,
    /// Calls that ended in a frame or a refusal, of all calls.
    pub robustness: String,
}

/// A reading of an open question.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Reading {
    /// The ruling.
    pub ruling: String,
    /// The reading that the decoder follows.
    pub reading: String,
}

/// A likely cause.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Cause {
    /// The misreading.
    pub misreading: String,
    /// The clause it misreads.
    pub clause: String,
    /// What the decoder does.
    pub effect: String,
    /// What to do about it.
    pub mend: String,
    /// The failing cases it reproduces exactly.
    pub explains: Vec<String>,
}

/// What is said of a case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CaseResult {
    /// The case.
    pub id: String,
    /// The verdict on it.
    pub outcome: String,
    /// The view it was asked in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<String>,
    /// What was expected.
    pub expect: String,
    /// The clauses it is about.
    pub clauses: Vec<String>,
    /// Why the outcome is what it is, where that needs words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub says: Option<String>,
    /// The beginning of the decoder's standard error, where the case failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stderr: Option<String>,
}

impl Report {
    /// The report of `run`. `command` is shown without directories.
    #[must_use]
    pub fn new(
        suite: &Suite,
        run: &Run,
        diagnoses: &[Diagnosis],
        command: &[String],
        limits: Vec<String>,
    ) -> Report {
        let scores = run.scores(suite);
        let of = |(part, whole): (usize, usize)| format!("{part}/{whole}");
        let names = |features: &std::collections::BTreeSet<Feature>| {
            features.iter().map(ToString::to_string).collect()
        };
        let verdict = match run.exit_status() {
            0 => "pass",
            1 => "fail",
            _ => "not a decoder",
        };
        Report {
            tool: Tool {
                name: env!("CARGO_PKG_NAME").to_owned(),
                version: env!("CARGO_PKG_VERSION").to_owned(),
                corpus: digest(suite),
                limits,
            },
            decoder: Subject {
                command: command
                    .iter()
                    .map(|word| base_name(word))
                    .collect::<Vec<_>>()
                    .join(" "),
                views: run.views.iter().map(|&view| view.to_owned()).collect(),
                decodes: names(&run.judgement.decoded),
                unsupported: names(&run.judgement.unsupported),
            },
            verdict: verdict.to_owned(),
            reason: run.not_a_decoder.clone(),
            scores: Scores {
                correctness: of(scores.correctness),
                breadth: of(scores.breadth),
                robustness: of(scores.robustness),
            },
            dialect: dialect(run),
            diagnoses: diagnoses
                .iter()
                .map(|diagnosis| cause(suite, diagnosis))
                .collect(),
            cases: suite
                .cases
                .iter()
                .zip(&run.judgement.cases)
                .enumerate()
                .filter_map(|(i, (case, judged))| {
                    let judged = judged.as_ref()?;
                    let stderr = run.findings[i]
                        .as_ref()
                        .map(|finding| finding.stderr.clone());
                    Some(case_result(case, judged, stderr.unwrap_or_default()))
                })
                .collect(),
        }
    }

    /// As YAML.
    ///
    /// # Errors
    /// None that a report can cause.
    pub fn to_yaml(&self) -> Result<String, String> {
        serde_saphyr::to_string(self).map_err(|error| error.to_string())
    }

    /// As text for a terminal, at most `shown` failures in full.
    #[must_use]
    pub fn to_text(&self, suite: &Suite, shown: usize) -> String {
        let mut text = String::new();
        self.write_text(suite, shown, &mut text)
            .expect("writing to memory does not fail");
        text
    }

    fn write_text(&self, suite: &Suite, shown: usize, out: &mut String) -> std::fmt::Result {
        let Subject { command, .. } = &self.decoder;
        if let Some(reason) = &self.reason {
            writeln!(out, "{command} is not a decoder: {reason}")?;
            writeln!(
                out,
                "A decoder is called as: DECODER VIEW FILE, for example: {command} raw x.ptm"
            )?;
            return writeln!(
                out,
                "For raw it prints \"PTM1 raw WIDTH HEIGHT CHANNELS u8\", a line feed and the samples; see the README."
            );
        }
        let failing: Vec<&CaseResult> = self
            .cases
            .iter()
            .filter(|case| case.outcome == Outcome::Fail.name())
            .collect();
        for cause in &self.diagnoses {
            let (count, all) = (cause.explains.len(), failing.len());
            writeln!(
                out,
                "{count} of {all} failures: the decoder {} (clause {}).",
                cause.effect, cause.clause
            )?;
            writeln!(
                out,
                "  To mend it: {}. More: ptm-conform explain {}",
                cause.mend, cause.misreading
            )?;
            for case in failing
                .iter()
                .filter(|case| cause.explains.contains(&case.id))
                .take(2)
            {
                write_failure(case, suite, out)?;
            }
            writeln!(out)?;
        }
        let explained = |case: &CaseResult| {
            self.diagnoses
                .iter()
                .any(|cause| cause.explains.contains(&case.id))
        };
        let others: Vec<&&CaseResult> = failing.iter().filter(|case| !explained(case)).collect();
        if !others.is_empty() {
            writeln!(
                out,
                "{} of {} failures are like no mistake of the catalogue.",
                others.len(),
                failing.len()
            )?;
            if let Some(advice) = advice(&others) {
                writeln!(out, "  {advice}")?;
            }
            for case in others.iter().take(shown) {
                write_failure(case, suite, out)?;
            }
            if others.len() > shown {
                writeln!(
                    out,
                    "  … and {} more; the report has them all",
                    others.len() - shown
                )?;
            }
            writeln!(out)?;
        }
        let readings: Vec<String> = self
            .dialect
            .iter()
            .map(|known| format!("{}: {}", known.ruling, known.reading))
            .collect();
        if !readings.is_empty() {
            writeln!(out, "dialect: {}", readings.join("; "))?;
        }
        if !self.decoder.unsupported.is_empty() {
            writeln!(
                out,
                "unsupported, by its own word: {}",
                self.decoder.unsupported.join(", ")
            )?;
        }
        let count = |outcome: &Outcome| {
            (
                *outcome,
                self.cases
                    .iter()
                    .filter(|case| case.outcome == outcome.name())
                    .count(),
            )
        };
        let counts = OUTCOMES.iter().map(count).filter(|&(_, count)| count > 0);
        let counts: Vec<String> = counts
            .map(|(outcome, count)| format!("{count} {}", outcome.name()))
            .collect();
        let selection = if self.cases.len() < suite.cases.len() {
            format!(
                " ({} of {} cases selected)",
                self.cases.len(),
                suite.cases.len()
            )
        } else {
            String::new()
        };
        writeln!(out, "{}: {}{selection}", self.verdict, counts.join(", "))?;
        let Scores {
            correctness,
            breadth,
            robustness,
        } = &self.scores;
        writeln!(
            out,
            "correctness {correctness}, breadth {breadth}, robustness {robustness}"
        )
    }
}

fn write_failure(case: &CaseResult, suite: &Suite, out: &mut String) -> std::fmt::Result {
    writeln!(out, "  FAIL {}  ({})", case.id, case.clauses.join(", "))?;
    writeln!(
        out,
        "    {}: {}",
        case.view.as_deref().unwrap_or_default(),
        case.says.as_deref().unwrap_or_default()
    )?;
    if let Some(case) = suite.case(&case.id) {
        writeln!(out, "    {}", case.because)?;
    }
    match case
        .stderr
        .as_ref()
        .and_then(|stderr| stderr.lines().last())
    {
        Some(line) => writeln!(out, "    its standard error ends: {line}"),
        None => Ok(()),
    }
}

/// What helps where a decoder refuses files with another status than 65.
fn advice(failures: &[&&CaseResult]) -> Option<String> {
    let status = failures
        .iter()
        .find_map(|case| case.says.as_ref()?.strip_prefix("crash: exit status "))?;
    let refusals = failures
        .iter()
        .filter(|case| case.expect != Expect::Decode.name());
    let alike = refusals
        .filter(|case| {
            case.says
                .as_ref()
                .is_some_and(|says| says.strip_prefix("crash: exit status ") == Some(status))
        })
        .count();
    (alike > 1).then(|| {
        format!("{alike} files that must or may be refused ended in exit status {status}. A refusal is exit status 65; if {status} is this decoder's, say --reject-exit {status}.")
    })
}

const OUTCOMES: [Outcome; 7] = [
    Outcome::Pass,
    Outcome::Fail,
    Outcome::Unsupported,
    Outcome::Inconclusive,
    Outcome::OtherDialect,
    Outcome::NotJudged,
    Outcome::NotRun,
];

fn dialect(run: &Run) -> Vec<Reading> {
    let reading = |ruling: &str, reading: String| Reading {
        ruling: ruling.to_owned(),
        reading,
    };
    let newline = if run.table.newline {
        "one line feed"
    } else {
        "nothing"
    };
    let has_tables = run
        .judgement
        .decoded
        .iter()
        .any(|feature| matches!(feature, Feature::Format(format) if format.has_table()));
    let tables = [
        reading("lut-count", run.table.count.name().to_owned()),
        reading("lut-newline", newline.to_owned()),
    ];
    let choices = run
        .judgement
        .dialect
        .iter()
        .filter_map(|&(ruling, said)| Some(reading(ruling, said?.to_owned())));
    tables
        .into_iter()
        .filter(|_| has_tables)
        .chain(choices)
        .collect()
}

fn cause(suite: &Suite, diagnosis: &Diagnosis) -> Cause {
    Cause {
        misreading: diagnosis.misreading.slug.to_owned(),
        clause: diagnosis.misreading.clause.to_owned(),
        effect: diagnosis.misreading.effect.to_owned(),
        mend: diagnosis.misreading.mend.to_owned(),
        explains: diagnosis
            .explains
            .iter()
            .map(|&i| suite.cases[i].id.clone())
            .collect(),
    }
}

fn case_result(case: &Case, judged: &Judged, stderr: String) -> CaseResult {
    CaseResult {
        id: case.id.clone(),
        outcome: judged.outcome.name().to_owned(),
        view: judged.view.as_ref().map(ToString::to_string),
        expect: case.expect.name().to_owned(),
        clauses: case.clauses.clone(),
        says: Some(judged.says.clone()).filter(|says| !says.is_empty()),
        stderr: Some(stderr).filter(|stderr| judged.outcome == Outcome::Fail && !stderr.is_empty()),
    }
}

/// A digest of the files of the suite, in order.
fn digest(suite: &Suite) -> String {
    let digests: String = suite
        .cases
        .iter()
        .map(|case| corpus::entry(case).0.sha256)
        .collect();
    corpus::sha256(digests.as_bytes())
}

/// A word of a command without its directories.
fn base_name(word: &str) -> String {
    std::path::Path::new(word).file_name().map_or_else(
        || word.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}
