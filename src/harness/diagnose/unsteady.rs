//! Requests that were answered in two ways: they tell of no mistake in reading, only of what is carried over or left to
//! chance.

use super::{Cause, Diagnosis, Kind};
use crate::harness::cases::Suite;
use crate::harness::check::Run;
use crate::harness::judge::Unsteady;

/// The cases whose answers differ, those of serve mode apart from those that differ each time.
pub(super) fn describe(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let differing: Vec<(usize, &Unsteady)> = run
        .findings
        .iter()
        .enumerate()
        .filter(|&(place, _)| run.judgement.cases[place].is_some())
        .filter_map(|(place, finding)| Some((place, finding.as_ref()?.unsteady.as_ref()?)))
        .collect();
    let (served, chance): (Vec<_>, Vec<_>) = differing.into_iter().partition(|(_, how)| how.served);
    let diagnosis = |of: Vec<(usize, &Unsteady)>, effect: &str, mend: &str| {
        let &(place, how) = of.first()?;
        let case = &suite.cases[place];
        Some(Diagnosis::of(
            Cause::Described {
                kind: Kind::Unsteady,
                clause: case.clauses.first().cloned().unwrap_or_default(),
                effect: effect.to_owned(),
                mend: mend.to_owned(),
                example: format!("for example {}: {}", case.id, how.says),
            },
            of.iter().map(|&(place, _)| place).collect(),
        ))
    };
    let serving = diagnosis(
        served,
        "answers otherwise in serve mode than asked alone",
        "begin every request as if it were the first, and answer each once; check --one-shot asks every file of a process of its own",
    );
    let by_chance = diagnosis(
        chance,
        "answers the same request differently each time",
        "look for memory that is read before it is written, for threads, for clocks and for random numbers",
    );
    serving.into_iter().chain(by_chance).collect()
}
