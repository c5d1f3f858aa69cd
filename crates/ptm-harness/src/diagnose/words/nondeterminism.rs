//! Describes requests with inconsistent responses. Such responses indicate shared or uninitialized state, not a misreading.

use crate::diagnose::diagnosis::{Category, Cause, Diagnosis};
use crate::diagnose::tuning::{MIN_SUPPORT, is_substantial};
use crate::session::run::Run;
use ptm_suite::cases::Suite;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::verdicts::observation::{Nondeterminism, Response};
use ptm_suite::verdicts::outcome::Outcome;

/// Describes the cases whose responses differ between serve mode and one-shot mode, or between calls.
pub(in crate::diagnose) fn describe(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let cases: Vec<(usize, &Nondeterminism)> = run
        .observations
        .iter()
        .enumerate()
        .filter(|&(index, _)| run.judgment.cases[index].is_some())
        .filter_map(|(index, observation)| {
            Some((index, observation.as_ref()?.nondeterminism.as_ref()?))
        })
        .collect();
    let (served, random): (Vec<_>, Vec<_>) =
        cases.into_iter().partition(|(_, diff)| diff.in_serve_mode);
    let is_garbled = |index: usize| {
        let observation = run.observations[index].as_ref();
        observation.is_some_and(|seen| {
            matches!(seen.response, Response::Violation(Answer::ProtocolError(_)))
        })
    };
    let (garbled, served): (Vec<_>, Vec<_>) = served
        .into_iter()
        .partition(|&(index, _)| is_garbled(index));
    let diagnosis = |indices: Vec<(usize, &Nondeterminism)>, effect: &str, fix: &str| {
        let &(index, diff) = indices.first()?;
        let case = &suite.cases[index];
        let view = |index: usize| Some(run.observations[index].as_ref()?.view.name());
        let share_view = indices.iter().all(|&(other, _)| view(other) == view(index));
        let only = match view(index).filter(|_| share_view && indices.len() >= MIN_SUPPORT) {
            Some(view) => format!(", all in view {view}"),
            None => String::new(),
        };
        Some(Diagnosis::new(
            Cause::Described {
                category: Category::Nondeterminism,
                clause: None,
                effect: format!("{effect}{only}"),
                fix: fix.to_owned(),
                example: format!("for example {}: {}", case.id, diff.message),
                equivalents: Vec::new(),
            },
            indices.iter().map(|&(index, _)| index).collect(),
        ))
    };
    let garbled_cause = diagnosis(
        garbled,
        "violates the protocol in serve mode",
        "answer each request with one line, followed by NBYTES bytes if the line is SEQ ok NBYTES; ptm-conform probe tests this step by step, and docs/check.md lists the responses",
    );
    let serve_cause = diagnosis(
        served,
        "gives different responses in serve mode and one-shot mode",
        "reset all state before each request, and answer each request once; check --one-shot starts one process per request",
    );
    let random_cause = diagnosis(
        random,
        "gives different responses to the same request",
        "look for uninitialized memory, data races, clocks and random numbers",
    );
    let all = [garbled_cause, serve_cause, random_cause].into_iter();
    all.flatten().collect()
}

/// Returns true if at least a quarter of the failing responses differ between calls. Common properties are then coincidences.
pub(in crate::diagnose) fn is_prevalent(run: &Run) -> bool {
    let differs = |index: &usize| {
        let observation = run.observations[*index].as_ref();
        let difference = observation.and_then(|observation| observation.nondeterminism.as_ref());
        difference.is_some_and(|difference| !difference.in_serve_mode)
    };
    let failed: Vec<usize> = run.judgment.with_outcome(Outcome::Fail).collect();
    let differing = failed.iter().filter(|index| differs(index)).count();
    is_substantial(differing, failed.len())
}
