//! The report, and every word that the user of `check` reads.
//!
//! A report is a plain value; YAML and text are two ways of writing it. It has no clock, path or host in it, so that two
//! runs of the same thing are equal.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::harness::baseline::News;
use crate::harness::capabilities::Capabilities;
use crate::harness::cases::{Case, Feature, Suite, TableSpelling};
use crate::harness::check::Run;
use crate::harness::corpus;
use crate::harness::diagnose::{self, Diagnosis};
use crate::harness::judge::{Finding, Judged, Outcome, Shown};
use crate::harness::misreadings::{self, Misreading};
use crate::ptm::Format;

mod card;

mod diff;

mod read;

pub use card::Leniency;

pub(in crate::harness) use read::{from_yaml, text_of};

/// All that is said of a decoder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// The program that judged.
    pub tool: Tool,
    /// The decoder under test.
    pub decoder: Subject,
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
    pub dialect: Vec<Reading>,
    /// What it does with files beyond the letter, ruling by ruling.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lenient: Vec<Leniency>,
    /// The failures held against those that were known, where a list of them was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<News>,
    /// Likely causes, most telling first.
    pub diagnoses: Vec<Cause>,
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
pub struct Subject {
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
    /// What it answers 69 to, throughout.
    pub unsupported: Vec<String>,
}

/// Something to say of a run as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// Whether the decoder fails because of it.
    pub failure: bool,
    /// What there is to say.
    pub says: String,
}

/// A numerator and a denominator each.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Scores {
    /// Cases passed of cases judged, among the features it supports.
    pub correctness: String,
    /// Features decoded of features in the suite.
    pub breadth: String,
    /// Calls that ended in a frame or a refusal, of all calls.
    pub robustness: String,
}

/// A reading of an open question.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reading {
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
pub struct Cause {
    /// The misreading, where it is one of the catalogue.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misreading: Option<String>,
    /// What kind of failure it is, where it is none: refusal, acceptance, misconduct, difference or unsteady.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// The clause it misreads.
    pub clause: String,
    /// What the decoder does.
    pub effect: String,
    /// What to do about it.
    pub mend: String,
    /// Other misreadings that explain the same cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub or: Vec<String>,
    /// Other misreadings that are made too, and show in the same cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<String>,
    /// The failing cases it reproduces exactly.
    pub explains: Vec<String>,
    /// The failing cases in which it goes wrong too, but not in just this way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub partly: Vec<String>,
    /// Cases that pass although a decoder with this mistake would fail them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub except: Vec<String>,
    /// All that shows of it, where other causes would show alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shows: Option<String>,
    /// One failure down to the bytes of the file, where the cause is not of the catalogue.
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

impl Cause {
    /// A name for it: the misreading, or else the kind of failure.
    #[must_use]
    pub fn name(&self) -> &str {
        let name = self.misreading.as_deref().or(self.kind.as_deref());
        name.unwrap_or("unknown")
    }
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
                name: None,
                version: None,
                mode: "one-shot".to_owned(),
                views: run
                    .offer
                    .views
                    .iter()
                    .map(|&view| view.to_owned())
                    .collect(),
                decodes: names(&run.judgement.decoded),
                unsupported: unsupported(run),
            },
            verdict: verdict.to_owned(),
            reason: run.not_a_decoder.clone(),
            scores: Scores {
                correctness: of(scores.correctness),
                breadth: of(scores.breadth),
                robustness: of(scores.robustness),
            },
            remarks: run
                .remarks
                .iter()
                .map(|remark| Remark {
                    failure: remark.failure,
                    says: remark.says.clone(),
                })
                .chain(another_transform(run))
                .collect(),
            dialect: card::dialect(suite, run),
            lenient: card::leniency(suite, run),
            baseline: None,
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
                    Some(case_result(case, judged, run.findings[i].as_ref()))
                })
                .collect(),
        }
    }

    /// Adds what the decoder says of itself, and in which mode it was asked.
    #[must_use]
    pub fn about(mut self, capabilities: &Capabilities, mode: &str) -> Report {
        self.decoder.name.clone_from(&capabilities.name);
        self.decoder.version.clone_from(&capabilities.version);
        mode.clone_into(&mut self.decoder.mode);
        self
    }

    /// As YAML.
    ///
    /// # Errors
    /// None that a report can cause.
    pub fn to_yaml(&self) -> Result<String, String> {
        serde_saphyr::to_string(self).map_err(|error| error.to_string())
    }

    /// Whether this failure was known before (`--baseline`).
    #[must_use]
    pub fn is_known(&self, case: &CaseResult) -> bool {
        let news = self.baseline.as_ref();
        news.is_some_and(|news| news.known.contains(&case.id))
    }

    /// The cause under which this failure stands: one that reproduces it, or else one that does in part.
    #[must_use]
    pub fn cause_of(&self, case: &CaseResult) -> Option<&Cause> {
        let with = |of: fn(&Cause) -> &[String]| {
            let mut causes = self.diagnoses.iter();
            causes.find(|cause| of(cause).contains(&case.id))
        };
        with(|cause| &cause.explains).or_else(|| with(|cause| &cause.partly))
    }

    /// As text for a terminal, at most `shown` failures in full.
    #[must_use]
    pub fn to_text(&self, suite: &Suite, shown: usize) -> String {
        let mut text = String::new();
        self.write_text(suite, shown, &mut text)
            .expect("writing to memory does not fail");
        text
    }

    /// All that is said of the cases whose id is `wanted`, as text.
    #[must_use]
    pub fn cases_to_text(&self, suite: &Suite, wanted: impl Fn(&str) -> bool) -> String {
        let mut text = String::new();
        for case in self.cases.iter().filter(|case| wanted(&case.id)) {
            write_case(case, suite, &mut text).expect("writing to memory does not fail");
        }
        text
    }

    /// Why cases were not judged, or came to nothing, and how many.
    fn proving_nothing(&self) -> BTreeMap<&str, usize> {
        let mut reasons = BTreeMap::new();
        for case in &self.cases {
            let says = if case.outcome == Outcome::Inconclusive.name() {
                "files that must be refused, beside a legal one that is not read right either"
            } else if case.outcome == Outcome::NotJudged.name() {
                case.says.as_deref().unwrap_or_default()
            } else {
                continue;
            };
            *reasons.entry(says).or_default() += 1;
        }
        reasons
    }

    fn write_text(&self, suite: &Suite, shown: usize, out: &mut String) -> std::fmt::Result {
        let Subject { command, .. } = &self.decoder;
        if let Some(reason) = &self.reason {
            writeln!(out, "{command} is not a decoder: {reason}")?;
            if command.contains("{in}") {
                return writeln!(
                    out,
                    "A program called by --cmd reads the file {{in}} and writes a picture to {{out}}, or prints it; see docs/check.md."
                );
            }
            writeln!(
                out,
                "A decoder is called as: DECODER VIEW FILE, for example: {command} raw x.ptm"
            )?;
            return writeln!(
                out,
                "For raw it prints \"PTM1 raw WIDTH HEIGHT CHANNELS u8\", a line feed and the samples; see the README.\nWhat keeps it from that, step by step: ptm-conform probe DECODER"
            );
        }
        for remark in &self.remarks {
            let kind = if remark.failure { "FAIL" } else { "note" };
            writeln!(out, "{kind}: {}", remark.says)?;
        }
        if !self.remarks.is_empty() {
            writeln!(out)?;
        }
        let failing: Vec<&CaseResult> = self
            .cases
            .iter()
            .filter(|case| case.outcome == Outcome::Fail.name())
            .collect();
        for cause in &self.diagnoses {
            write_cause(cause, &failing, suite, out)?;
        }
        let explained = |case: &CaseResult| {
            self.diagnoses
                .iter()
                .any(|cause| cause.explains.contains(&case.id) || cause.partly.contains(&case.id))
        };
        let others: Vec<&CaseResult> = failing
            .iter()
            .copied()
            .filter(|case| !explained(case))
            .collect();
        if !others.is_empty() {
            writeln!(
                out,
                "{} of {} failures are like no mistake of the catalogue.",
                others.len(),
                failing.len()
            )?;
            let (alike, single) = by_kind(&others);
            for (kind, cases) in &alike {
                writeln!(out, "  {} times {kind}; for example", cases.len())?;
                for case in cases.iter().take(2) {
                    write_failure(case, suite, out)?;
                }
            }
            for case in single.iter().take(shown) {
                write_failure(case, suite, out)?;
            }
            if single.len() > shown {
                writeln!(
                    out,
                    "  … and {} more; the report has them all",
                    single.len() - shown
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
        let lenient: Vec<String> = self.lenient.iter().map(card::said).collect();
        if !lenient.is_empty() {
            writeln!(out, "beyond the letter: {}", lenient.join("; "))?;
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
        let counts = Outcome::ALL
            .iter()
            .map(count)
            .filter(|&(_, count)| count > 0);
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
        for (says, count) in self.proving_nothing() {
            writeln!(out, "{count} prove nothing: {says}")?;
        }
        let weak = self.cases.iter().filter(|case| case.weak).count();
        if weak > 0 {
            writeln!(
                out,
                "{weak} refusals are weak: their exit status may mean a crash as well, and proves less than 65"
            )?;
        }
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

/// A cause, what to do about it, and two of its cases.
fn write_cause(
    cause: &Cause,
    failing: &[&CaseResult],
    suite: &Suite,
    out: &mut String,
) -> std::fmt::Result {
    let (count, all) = (cause.explains.len(), failing.len());
    let clause = match cause.kind.as_deref() {
        Some("misconduct" | "unsteady") => String::new(),
        _ => format!(" (clause {})", cause.clause),
    };
    writeln!(
        out,
        "{count} of {all} failures: the decoder {}{clause}.",
        cause.effect
    )?;
    for slug in cause.or.iter().take(3) {
        if let Some(other) = misreadings::named(slug) {
            writeln!(
                out,
                "  or, which fails the same cases: it {} (clause {}; {slug})",
                other.effect, other.clause
            )?;
        }
    }
    for slug in &cause.with {
        if let Some(other) = misreadings::named(slug) {
            writeln!(out, "  in some of them also: it {} ({slug})", other.effect)?;
        }
    }
    if !cause.partly.is_empty() {
        writeln!(
            out,
            "  {} more in part: it goes wrong there too, but not in just this way",
            cause.partly.len()
        )?;
    }
    if !cause.except.is_empty() {
        writeln!(
            out,
            "  But not everywhere: {} cases pass that such a decoder would fail, for example {}",
            cause.except.len(),
            cause.except[0]
        )?;
    }
    if let Some(shows) = &cause.shows {
        writeln!(
            out,
            "  All that shows of it: the decoder {shows}. Other causes would show alike"
        )?;
    }
    if let Some(example) = &cause.example {
        writeln!(out, "  {}", capitalised(example))?;
    }
    match &cause.misreading {
        Some(slug) => writeln!(
            out,
            "  To mend it: {}. More: ptm-conform explain {slug}",
            cause.mend
        )?,
        None => writeln!(out, "  To mend it: {}.", cause.mend)?,
    }
    let shown = if cause.misreading.is_some() { 2 } else { 1 };
    for case in failing
        .iter()
        .filter(|case| cause.explains.contains(&case.id))
        .take(shown)
    {
        write_failure(case, suite, out)?;
    }
    writeln!(out)
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn write_case(case: &CaseResult, suite: &Suite, out: &mut String) -> std::fmt::Result {
    let weak = if case.weak { ", weakly" } else { "" };
    let CaseResult { id, outcome, .. } = case;
    writeln!(out, "{id}: {outcome}{weak}  ({})", case.clauses.join(", "))?;
    if let Some(case) = suite.case(id) {
        writeln!(out, "  {}", case.because)?;
    }
    let asked = case
        .view
        .as_deref()
        .map(|view| format!(", asked in {view}"));
    writeln!(
        out,
        "  expected: {}{}",
        case.expect,
        asked.unwrap_or_default()
    )?;
    if let Some(says) = &case.says {
        writeln!(out, "  {says}")?;
    }
    if let Some(stderr) = &case.stderr {
        writeln!(out, "  its standard error:")?;
        for line in stderr.lines() {
            writeln!(out, "    {line}")?;
        }
    }
    Ok(())
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

/// Crashes, hangs and the like that occur more than once, by what is said of them; and all other failures.
fn by_kind<'a>(
    failures: &[&'a CaseResult],
) -> (Vec<(&'a str, Vec<&'a CaseResult>)>, Vec<&'a CaseResult>) {
    let mut kinds: Vec<(&str, Vec<&CaseResult>)> = Vec::new();
    let mut single = Vec::new();
    for &case in failures {
        let says = case.says.as_deref().unwrap_or_default();
        let is_mishap = MISHAPS.iter().any(|name| {
            says.strip_prefix(name)
                .is_some_and(|rest| rest.starts_with(": "))
        });
        match kinds.iter_mut().find(|(kind, _)| *kind == says) {
            _ if !is_mishap => single.push(case),
            Some((_, cases)) => cases.push(case),
            None => kinds.push((says, vec![case])),
        }
    }
    let (alike, rare): (Vec<_>, Vec<_>) = kinds.into_iter().partition(|(_, cases)| cases.len() > 2);
    single.extend(rare.into_iter().flat_map(|(_, cases)| cases));
    (alike, single)
}

/// What is neither a picture nor a refusal, as [`Answer::name`](crate::harness::protocol::Answer::name) calls it.
const MISHAPS: [&str; 7] = [
    "protocol error",
    "crash",
    "hang",
    "flood",
    "out of memory",
    "tampering",
    "not started",
];

/// What it answers 69 to throughout: whole features, and views of single formats.
fn unsupported(run: &Run) -> Vec<String> {
    let features = run.judgement.unsupported.iter();
    let views = run.offer.lacking.iter().filter_map(|&(view, format)| {
        // The colors of LUM are a feature of their own.
        let known = view == "rgb" && format == Format::Lum;
        (!known).then(|| format!("{view} of {}", format.short_name()))
    });
    features.map(ToString::to_string).chain(views).collect()
}

/// Ruling `jpeg-samples`: pictures of lossy JPEG that are right and not the reference's.
fn another_transform(run: &Run) -> Option<Remark> {
    let others = run.findings.iter().flatten().filter(|finding| {
        matches!(
            finding.shown,
            Shown::Picture {
                another_transform: true,
                ..
            }
        )
    });
    let count = others.count();
    (count > 0).then(|| Remark {
        failure: false,
        says: format!(
            "{count} raw pictures of lossy JPEG planes are within the tolerance and not equal to the reference's: the decoder uses another inverse DCT"
        ),
    })
}

fn cause(suite: &Suite, diagnosis: &Diagnosis) -> Cause {
    let ids = |places: &[usize]| -> Vec<String> {
        places.iter().map(|&i| suite.cases[i].id.clone()).collect()
    };
    let slugs = |misreadings: &[&Misreading]| -> Vec<String> {
        let slugs = misreadings
            .iter()
            .map(|misreading| misreading.slug.to_owned());
        slugs.collect()
    };
    let mut cause = match &diagnosis.cause {
        diagnose::Cause::Misreading {
            misreading,
            alike,
            with,
        } => Cause {
            misreading: Some(misreading.slug.to_owned()),
            clause: misreading.clause.to_owned(),
            effect: misreading.effect.to_owned(),
            mend: misreading.mend.to_owned(),
            or: slugs(alike),
            with: slugs(with),
            ..Cause::default()
        },
        diagnose::Cause::Described {
            kind,
            clause,
            effect,
            mend,
            example,
        } => Cause {
            kind: Some(kind.name().to_owned()),
            clause: clause.clone(),
            effect: effect.clone(),
            mend: mend.clone(),
            example: Some(example.clone()),
            ..Cause::default()
        },
    };
    cause.explains = ids(&diagnosis.explains);
    cause.partly = ids(&diagnosis.partly);
    cause.except = ids(&diagnosis.except);
    cause.shows.clone_from(&diagnosis.shows);
    cause
}

fn case_result(case: &Case, judged: &Judged, finding: Option<&Finding>) -> CaseResult {
    let stderr = finding
        .map(|finding| finding.stderr.clone())
        .unwrap_or_default();
    CaseResult {
        id: case.id.clone(),
        outcome: judged.outcome.name().to_owned(),
        view: judged.view.as_ref().map(ToString::to_string),
        expect: case.expect.name().to_owned(),
        clauses: case.clauses.clone(),
        weak: finding.is_some_and(|finding| finding.weak),
        says: Some(judged.says.clone()).filter(|says| !says.is_empty()),
        stderr: Some(stderr).filter(|stderr| judged.outcome == Outcome::Fail && !stderr.is_empty()),
    }
}

/// A digest of the files of the suite, in order.
pub(super) fn digest(suite: &Suite) -> String {
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    let digest = |place: usize| {
        let built = suite.cases[place].build(TableSpelling::default());
        corpus::sha256(&built.file)
    };
    let digests = corpus::in_parallel(suite.cases.len(), jobs, &|_, _| (), &digest);
    corpus::sha256(digests.concat().as_bytes())
}

/// A word of a command without its directories.
fn base_name(word: &str) -> String {
    std::path::Path::new(word).file_name().map_or_else(
        || word.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}
