//! Describes requests with inconsistent responses. They indicate shared or uninitialized state, not a misreading.

use crate::diagnose::diagnosis::{Category, Cause, Diagnosis};
use crate::diagnose::tuning::is_substantial;
use crate::protocol::frame::Answer;
use crate::session::observation::{Nondeterminism, Response};
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::Suite;

/// Describes the cases whose responses differ between serve mode and one-shot mode, or between calls.
pub(in crate::diagnose) fn describe(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let differing: Vec<(usize, &Nondeterminism)> = run
        .observations
        .iter()
        .enumerate()
        .filter(|&(place, _)| run.judgement.cases[place].is_some())
        .filter_map(|(place, observation)| {
            Some((place, observation.as_ref()?.nondeterminism.as_ref()?))
        })
        .collect();
    let (served, chance): (Vec<_>, Vec<_>) = differing.into_iter().partition(|(_, how)| how.served);
    let is_garbled = |place: usize| {
        let observation = run.observations[place].as_ref();
        observation.is_some_and(|seen| {
            matches!(seen.response, Response::Violation(Answer::ProtocolError(_)))
        })
    };
    let (garbled, served): (Vec<_>, Vec<_>) = served
        .into_iter()
        .partition(|&(place, _)| is_garbled(place));
    let diagnosis = |indices: Vec<(usize, &Nondeterminism)>, effect: &str, fix: &str| {
        let &(place, how) = indices.first()?;
        let case = &suite.cases[place];
        Some(Diagnosis::new(
            Cause::Described {
                category: Category::Nondeterminism,
                clause: case.clauses.first().cloned().unwrap_or_default(),
                effect: effect.to_owned(),
                fix: fix.to_owned(),
                example: format!("for example {}: {}", case.id, how.says),
                alike: Vec::new(),
            },
            indices.iter().map(|&(place, _)| place).collect(),
        ))
    };
    let garbling = diagnosis(
        garbled,
        "violates the protocol in serve mode",
        "answer each request with one line and, after SEQ ok NBYTES, that many bytes; probe tests this step by step, and docs/check.md lists the responses",
    );
    let serving = diagnosis(
        served,
        "gives different responses in serve mode and one-shot mode",
        "reset all state before each request, and answer each request once; check --one-shot starts one process per request",
    );
    let by_chance = diagnosis(
        chance,
        "gives different responses to the same request",
        "look for uninitialized memory, data races, clocks and random numbers",
    );
    let all = [garbling, serving, by_chance].into_iter();
    all.flatten().collect()
}

/// Returns true if at least a quarter of the failures differ between calls, so that common properties of their images
/// are a coincidence.
pub(in crate::diagnose) fn is_prevalent(run: &Run) -> bool {
    let differs = |place: &usize| {
        let observation = run.observations[*place].as_ref();
        let how = observation.and_then(|observation| observation.nondeterminism.as_ref());
        how.is_some_and(|how| !how.served)
    };
    let failed: Vec<usize> = run.judgement.with_outcome(Outcome::Fail).collect();
    let differing = failed.iter().filter(|place| differs(place)).count();
    is_substantial(differing, failed.len())
}
