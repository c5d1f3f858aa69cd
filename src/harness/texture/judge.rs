//! From answers to verdicts.
//!
//! The answers of all cases are looked at together: "unsupported" is honest only of a whole feature, and an open question must
//! be read in one way throughout. What is left to the implementation is reported and never failed.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::harness::protocol::Answer;
use crate::harness::texture::cases::{Basis, Case, Suite};
use crate::harness::texture::choices::{self, CHOICES, Dialect};
use crate::harness::texture::compare::{Tolerance, difference};
use crate::texture::Rules;

/// What one question brought.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What was answered.
    pub shown: Shown,
    /// The beginning of standard error.
    pub stderr: String,
}

/// One answer.
#[derive(Clone, Debug)]
pub enum Shown {
    /// A JSON object.
    Said(Value),
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// Anything else.
    Misconduct(Answer),
}

impl Shown {
    /// One or two words for a report.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Shown::Said(_) => "answered",
            Shown::Rejected => "rejected",
            Shown::Unsupported => "unsupported",
            Shown::Misconduct(answer) => answer.name(),
        }
    }
}

/// The verdict on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As it should be.
    Pass,
    /// Not as it should be.
    Fail,
    /// Left to the implementation, and this one differs from the reference.
    ImplementationDefined,
    /// It does not do this, and says so everywhere.
    Unsupported,
    /// No other answer shows that the step is known, so a refusal proves nothing.
    Inconclusive,
    /// The run ended before.
    NotRun,
}

impl Outcome {
    /// All of them, in the order of a summary.
    pub const ALL: [Outcome; 6] = [
        Outcome::Pass,
        Outcome::Fail,
        Outcome::ImplementationDefined,
        Outcome::Unsupported,
        Outcome::Inconclusive,
        Outcome::NotRun,
    ];

    /// As it stands in a report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::ImplementationDefined => "implementation-defined",
            Outcome::Unsupported => "unsupported",
            Outcome::Inconclusive => "inconclusive",
            Outcome::NotRun => "not run",
        }
    }
}

/// What is said of a case.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The verdict.
    pub outcome: Outcome,
    /// Why, in a sentence; empty where there is nothing to say.
    pub says: String,
}

/// What is said of all cases.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// A place for each case; nothing if it was not selected.
    pub cases: Vec<Option<Judged>>,
    /// The readings it follows.
    pub dialect: Dialect,
    /// Of each choice, whether a right answer showed it.
    pub shown: [bool; CHOICES.len()],
    /// Features of which anything was answered.
    pub supported: BTreeSet<String>,
    /// Features that were answered 69 throughout.
    pub unsupported: BTreeSet<String>,
}

/// Judges what was found of the selected cases. Cases without a finding were not run.
#[must_use]
pub fn judge(suite: &Suite, selected: &[bool], findings: &[Option<Finding>]) -> Judgement {
    let (supported, unsupported) = features(suite, findings);
    let facing: Vec<Facing> = suite
        .cases
        .iter()
        .zip(findings)
        .map(|(case, finding)| Facing::of(case, finding.as_ref()))
        .collect();
    let dialect = dialect_of(&facing);
    let mut shown = [false; CHOICES.len()];
    for facing in facing.iter().filter(|facing| facing.is_right(&dialect)) {
        for &axis in &facing.axes {
            shown[axis] = true;
        }
    }
    let judged = suite.cases.iter().zip(findings).zip(&facing).zip(selected);
    let cases = judged
        .map(|(((case, finding), facing), &selected)| {
            selected.then(|| {
                verdict(
                    case,
                    finding.as_ref(),
                    facing,
                    &dialect,
                    &unsupported,
                    &supported,
                )
            })
        })
        .collect();
    Judgement {
        cases,
        dialect,
        shown,
        supported,
        unsupported,
    }
}

/// Features that are answered, and those that are answered 69 wherever they are needed.
fn features(suite: &Suite, findings: &[Option<Finding>]) -> (BTreeSet<String>, BTreeSet<String>) {
    let mut answered: BTreeMap<String, bool> = BTreeMap::new();
    for (case, finding) in suite.cases.iter().zip(findings) {
        let Some(finding) = finding else { continue };
        // A refusal proves no knowledge of the step.
        let said = matches!(finding.shown, Shown::Said(_));
        let refused = matches!(finding.shown, Shown::Unsupported);
        for feature in case.features() {
            if said || refused {
                *answered.entry(feature).or_default() |= said;
            }
        }
    }
    let (yes, no): (Vec<_>, Vec<_>) = answered.into_iter().partition(|(_, answered)| *answered);
    let names = |all: Vec<(String, bool)>| all.into_iter().map(|(name, _)| name).collect();
    (names(yes), names(no))
}

/// An answer beside the open questions that its case shows.
struct Facing {
    /// Choices that change the case's answer.
    axes: Vec<usize>,
    /// The combinations of their readings in which the answer is right.
    right: Vec<Dialect>,
}

impl Facing {
    fn of(case: &Case, finding: Option<&Finding>) -> Facing {
        let axes = concerned(case);
        let said = finding.and_then(|finding| match &finding.shown {
            Shown::Said(value) => Some(value),
            _ => None,
        });
        let right = said.map_or_else(Vec::new, |said| {
            let mut right = choices::combinations(&axes);
            right.retain(|dialect| {
                let expected = expected(case, dialect);
                difference(&expected, said, tolerance(case)).is_none()
            });
            right
        });
        Facing { axes, right }
    }

    fn is_right(&self, dialect: &Dialect) -> bool {
        let agrees = |right: &Dialect| self.axes.iter().all(|&axis| right[axis] == dialect[axis]);
        self.right.iter().any(agrees)
    }
}

/// The choices of which another reading changes what a case expects.
#[must_use]
pub fn concerned(case: &Case) -> Vec<usize> {
    let own = expected(case, &Dialect::default());
    let changes = |&axis: &usize| {
        (1..CHOICES[axis].readings.len()).any(|reading| {
            let mut dialect = Dialect::default();
            dialect[axis] = reading;
            difference(&own, &expected(case, &dialect), tolerance(case)).is_some()
        })
    };
    // What is left to the implementation is right in every dialect.
    let axes = (0..CHOICES.len()).filter(|_| case.basis != Basis::Impl);
    axes.filter(changes).collect()
}

/// What a case expects under a dialect: what it says under the reference's own; else what it lists, which is what the reference
/// makes of it under that reading.
#[must_use]
pub fn expected(case: &Case, dialect: &Dialect) -> Value {
    if *dialect == Dialect::default() {
        return case.expect.clone();
    }
    let rules = choices::under(dialect, Rules::SPEC);
    let answer = case.read().and_then(|question| question.answer(&rules));
    answer.unwrap_or_else(|_| case.expect.clone())
}

/// The readings under which most cases are right; of equals the first, which is nearest to the reference's.
fn dialect_of(facing: &[Facing]) -> Dialect {
    let axes: Vec<usize> = (0..CHOICES.len())
        .filter(|axis| facing.iter().any(|facing| facing.axes.contains(axis)))
        .collect();
    let open: Vec<&Facing> = facing
        .iter()
        .filter(|facing| !facing.axes.is_empty() && !facing.right.is_empty())
        .collect();
    let right = |dialect: &Dialect| open.iter().filter(|one| one.is_right(dialect)).count();
    let mut best = (0, Dialect::default());
    for dialect in choices::combinations(&axes) {
        let count = right(&dialect);
        if count > best.0 {
            best = (count, dialect);
        }
    }
    best.1
}

/// How far numbers of an answer may be off.
#[must_use]
pub fn tolerance(case: &Case) -> Tolerance {
    case.tol.map_or(Tolerance::Ordinary, Tolerance::Absolute)
}

fn verdict(
    case: &Case,
    finding: Option<&Finding>,
    facing: &Facing,
    dialect: &Dialect,
    unsupported: &BTreeSet<String>,
    supported: &BTreeSet<String>,
) -> Judged {
    let say = |outcome, says: String| Judged { outcome, says };
    let Some(finding) = finding else {
        return say(Outcome::NotRun, String::new());
    };
    let must_refuse = case.expect.get("error").is_some();
    match &finding.shown {
        Shown::Unsupported => match case
            .features()
            .iter()
            .find(|one| unsupported.contains(*one))
        {
            Some(_) => say(Outcome::Unsupported, String::new()),
            None => say(
                Outcome::Fail,
                "answers 69 (unsupported) although it answers others of this kind".to_owned(),
            ),
        },
        Shown::Misconduct(answer) => say(
            Outcome::Fail,
            format!(
                "{}: {}",
                answer.name(),
                answer.misconduct().unwrap_or_default()
            ),
        ),
        Shown::Rejected if must_refuse && supported.contains(&case.op) => {
            say(Outcome::Pass, String::new())
        }
        Shown::Rejected if must_refuse => say(
            Outcome::Inconclusive,
            "it refuses every question of this kind".to_owned(),
        ),
        Shown::Rejected if case.basis == Basis::Impl => say(
            Outcome::ImplementationDefined,
            format!("the reference answers {}; received a refusal", case.expect),
        ),
        Shown::Rejected => say(
            Outcome::Fail,
            format!("expected {}, received a refusal", case.expect),
        ),
        Shown::Said(value) if case.basis == Basis::Impl => {
            match difference(&case.expect, value, tolerance(case)) {
                None => say(Outcome::Pass, String::new()),
                Some(what) => say(
                    Outcome::ImplementationDefined,
                    format!("left to the implementation; the reference differs: {what}"),
                ),
            }
        }
        Shown::Said(value) if must_refuse && value.get("error").is_some() => {
            say(Outcome::Pass, String::new())
        }
        Shown::Said(_) if facing.is_right(dialect) => say(Outcome::Pass, String::new()),
        Shown::Said(value) => say(Outcome::Fail, says(case, value, facing, dialect)),
    }
}

/// What is wrong with an answer: with its value, or with the reading it shows.
fn says(case: &Case, value: &Value, facing: &Facing, dialect: &Dialect) -> String {
    let expected = expected(case, dialect);
    let what = difference(&expected, value, tolerance(case));
    let what = what.unwrap_or_else(|| format!("expected {expected}, received {value}"));
    let Some(other) = facing.right.first() else {
        return what;
    };
    let mixed: Vec<String> = facing
        .axes
        .iter()
        .filter(|&&axis| other[axis] != dialect[axis])
        .map(|&axis| {
            let Choice { ruling, readings } = &CHOICES[axis];
            format!(
                "{ruling}: {} here, {} elsewhere",
                readings[other[axis]].0, readings[dialect[axis]].0
            )
        })
        .collect();
    format!("{what}; mixes readings ({})", mixed.join("; "))
}

use crate::harness::texture::choices::Choice;
