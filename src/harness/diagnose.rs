//! From failures to causes: which misreading would have failed in the same way.
//!
//! A misreading explains a failure if a decoder with it gives the same answer: the same picture, or the same refusal. It
//! is contradicted by every case that passed and that it would have failed. The one that explains most goes first, and
//! then the next for what is left.

use crate::harness::cases::{Expect, Suite};
use crate::harness::check::Run;
use crate::harness::choices::{CHOICES, Dialect};
use crate::harness::compare::Expected;
use crate::harness::judge::{Finding, Outcome, Shown};
use crate::harness::misreadings::{self, Misreading};
use crate::harness::protocol::{Answer, Frame, Samples};
use crate::reading::Reading;

/// A cause and what it explains.
pub struct Diagnosis {
    /// The mistake.
    pub misreading: &'static Misreading,
    /// Failing cases it reproduces, by their place in the suite.
    pub explains: Vec<usize>,
}

/// The fewest mistakes that explain the failures of `run`, as far as single mistakes do; most telling first.
#[must_use]
pub fn diagnose(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let with = |wanted: Outcome| -> Vec<usize> {
        let judged = run.judgement.cases.iter().enumerate();
        judged
            .filter(|(_, judged)| {
                judged
                    .as_ref()
                    .is_some_and(|judged| judged.outcome == wanted)
            })
            .map(|(i, _)| i)
            .collect()
    };
    let (mut failing, passing) = (with(Outcome::Fail), with(Outcome::Pass));
    if failing.is_empty() {
        return Vec::new();
    }
    let reading = spoken(run);
    let mut candidates: Vec<Diagnosis> = misreadings::all()
        .map(|misreading| {
            let explains = failing
                .iter()
                .copied()
                .filter(|&i| explains(suite, run, i, misreading, reading))
                .collect();
            Diagnosis {
                misreading,
                explains,
            }
        })
        .filter(|candidate| {
            let contradicted = || {
                passing
                    .iter()
                    .filter(|&&i| contradicts(suite, run, i, candidate.misreading, reading))
                    .count()
            };
            !candidate.explains.is_empty() && candidate.explains.len() > contradicted()
        })
        .collect();
    let mut diagnoses = Vec::new();
    loop {
        for candidate in &mut candidates {
            candidate.explains.retain(|i| failing.contains(i));
        }
        // The first of those that explain most: the catalogue runs from the general to the particular.
        let most = candidates
            .iter()
            .map(|candidate| candidate.explains.len())
            .max()
            .unwrap_or_default();
        let Some(best) = candidates
            .iter()
            .position(|candidate| most > 0 && candidate.explains.len() == most)
        else {
            break;
        };
        let best = candidates.remove(best);
        failing.retain(|i| !best.explains.contains(i));
        diagnoses.push(best);
    }
    diagnoses
}

/// How the decoder reads the open questions.
fn spoken(run: &Run) -> Reading {
    let taken = |(choice, (_, said)): (&crate::harness::choices::Choice, &(&str, Option<&str>))| {
        choice
            .readings
            .iter()
            .position(|&(name, _)| Some(name) == *said)
            .unwrap_or_default()
    };
    Dialect(
        CHOICES
            .iter()
            .zip(&run.judgement.dialect)
            .map(taken)
            .collect(),
    )
    .reading()
}

fn explains(suite: &Suite, run: &Run, i: usize, misreading: &Misreading, reading: Reading) -> bool {
    let Some(Finding { view, shown, .. }) = &run.findings[i] else {
        return false;
    };
    let built = suite.cases[i].build(run.table);
    match (
        shown,
        misreadings::answer(&[misreading], reading, &built.file, view),
    ) {
        (
            Shown::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(made),
        ) => alike(shown, &made),
        // Of a file that must be refused no picture is kept: to accept it is the mistake.
        (Shown::Picture { frame: None, .. }, Answer::Decoded(_))
        | (Shown::Rejected, Answer::Rejected) => true,
        _ => false,
    }
}

fn contradicts(
    suite: &Suite,
    run: &Run,
    i: usize,
    misreading: &Misreading,
    reading: Reading,
) -> bool {
    let Some(Finding { view, .. }) = &run.findings[i] else {
        return false;
    };
    let case = &suite.cases[i];
    let built = case.build(run.table);
    match (
        case.expect,
        misreadings::answer(&[misreading], reading, &built.file, view),
    ) {
        (Expect::Decode, Answer::Decoded(made)) => {
            let expected = Expected::under(&built.file, view, &reading);
            expected.is_some_and(|expected| expected.compare(&made).is_some())
        }
        (Expect::Decode, _) => true,
        (Expect::Reject | Expect::Refuse, answer) => matches!(answer, Answer::Decoded(_)),
        (Expect::Lenient | Expect::Spelling, _) => false,
    }
}

/// Whether two pictures are one, but for rounding.
fn alike(a: &Frame, b: &Frame) -> bool {
    if (a.view, a.width, a.height, a.channels) != (b.view, b.width, b.height, b.channels) {
        return false;
    }
    match (&a.samples, &b.samples) {
        (Samples::U8(x), Samples::U8(y)) if a.view == "rgb" => {
            x.iter().zip(y).all(|(x, y)| x.abs_diff(*y) <= 1)
        }
        (Samples::U8(x), Samples::U8(y)) => x == y,
        (Samples::F32(x), Samples::F32(y)) => x
            .iter()
            .zip(y)
            .all(|(x, y)| (x - y).abs() <= 1e-5 * x.abs().max(y.abs()) + 1e-6),
        _ => false,
    }
}
