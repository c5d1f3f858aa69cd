//! From failures to causes: what to fix, in a sentence.
//!
//! Before a cause is said it is held against every case: it must give the decoder's own picture or refusal, and no passing
//! case may deny it. First the catalog: the smallest set of misreadings with which a decoder answers the same. What no
//! misreading explains is solved from the pictures: right values in wrong places, values that are a function of the right
//! ones, wrong numbers in a formula. What is then left is put into words: refusals by what the refused files share,
//! acceptances by the damage, pictures by how they differ and where; and what is unknown is said to be.
//!
//! `witness` holds a case against what a decoder with some mistakes would answer, `search` finds the mistakes, `solve`
//! those that no list has: in `values`, in the `layout` of a file, in `planes`, in the `codecs`. `files` tells in
//! which files; `attribution` what each explains; `words` what is left.

mod answers;
mod assume;
mod attribution;
mod coincidences;
pub(crate) mod cover;
mod credit;
mod diagnosis;
mod edits;
mod failure_mode;
mod learned;
mod mistake;
mod pair;
mod properties;
mod scope;
mod search;
mod stream_cache;
pub mod texture;
mod tuning;
mod witness;
mod words;

pub use assume::assume;
pub use diagnosis::{Category, Cause, Causes, Diagnosis};
pub(crate) use stream_cache::stream_once;
pub(crate) use witness::dialect_reading;
pub use witness::{alike, applies, composable};
pub use words::arithmetic_steps;

use crate::misreadings::Misreading;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::Suite;
use search::Search;
use tuning::MIN_FAILURES_OF_A_READING;
use witness::{reference_reading, witnesses};

/// Why the failures of `run` failed; most telling first. `assumed` are mistakes that the user knows of. Where the user
/// ends the search, most failures have no cause.
#[must_use]
pub fn diagnose(
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
) -> Causes {
    diagnose_by(suite, run, assumed, threads, edits::add_candidates)
}

/// As [`diagnose`], with another way to add mistakes that the catalog lacks.
fn diagnose_by(
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
    add_candidates: impl Fn(&mut Search, &search::Set, &[usize]),
) -> Causes {
    let mut diagnoses = words::nondeterminism::describe(suite, run);
    diagnoses.extend(words::promises::describe(suite, run));
    let mut judged = run.judgement.cases.iter().flatten();
    if !judged.any(|judged| judged.outcome == Outcome::Fail) {
        return diagnoses.into();
    }
    let by_dialect = witnesses(suite, run, None, threads);
    if !by_dialect.iter().any(|witness| witness.failed) {
        return diagnoses.into();
    }
    let searched = |witnesses| {
        let mut search = Search::new(witnesses, assumed, threads, &run.stop);
        let found = match words::nondeterminism::prevails(run) {
            true => search::Found::default(),
            false => search.run(&add_candidates),
        };
        (search, found)
    };
    let (mut search, mut found) = searched(&by_dialect);
    // A mistake may look like another reading of an open question: then it tells more beside the reference's own.
    let is_plain = found.members.is_empty() || search.cost(&found) <= MIN_FAILURES_OF_A_READING;
    let by_reference = reference_reading(run)
        .filter(|_| !is_plain)
        .map(|reading| witnesses(suite, run, Some(reading), threads));
    if let Some(by_reference) = &by_reference {
        let (other, beside) = searched(by_reference);
        if other.cost(&beside) < search.cost(&found) + MIN_FAILURES_OF_A_READING {
            (search, found) = (other, beside);
        }
    }
    if search.is_interrupted() {
        return diagnoses.into();
    }
    search.guarded(|| coincidences::remove(&search, &mut found));
    let mut causes = told(&search, &found);
    causes.append(&mut diagnoses);
    // What explains most comes first; what is known for certain counts more than what is put into words.
    causes.sort_by_key(|diagnosis| {
        let explained = diagnosis.explains.len() + diagnosis.partly.len();
        std::cmp::Reverse(explained * if diagnosis.certain { 4 } else { 1 })
    });
    Causes {
        diagnoses: causes,
        faults: search.faults(),
        answered: search.answered(),
    }
}

/// What each mistake that was found explains, and what is left, in words.
fn told(search: &Search, found: &search::Found) -> Vec<Diagnosis> {
    let witnesses = search.witnesses;
    let (mut attributed, mut left) = attribution::attribute(search, found);
    let mut causes = search.guarded(|| words::formats::describe(witnesses, &mut left));
    causes.extend(search.guarded(|| words::acceptances::describe(witnesses, &mut left)));
    let violation = search.guarded(|| words::violation::describe(witnesses, &mut left));
    let refusals = search.guarded(|| words::refusals::describe(witnesses, &mut left));
    search.guarded(|| {
        attribution::attribute_in_part(search, found, &mut attributed, &mut left);
    });
    causes.extend(refusals);
    causes.extend(search.guarded(|| words::refusals::rest(witnesses, &mut left)));
    causes.extend(violation);
    // Where nothing is explained there is no cause above that others could stand beside.
    let is_cause = |(id, _): &(search::Id, Diagnosis)| *id < search.mistakes.len();
    let set = match attributed.iter().any(is_cause) {
        true => search::of(&found.members),
        false => search::Set::new(),
    };
    causes.extend(search.guarded(|| words::place::describe(search, &set, &left)));
    let attributed = attributed.into_iter().map(|(_, diagnosis)| diagnosis);
    attributed.chain(causes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::misreadings;
    use crate::protocol::frame::{Answer, Samples};
    use crate::reading::Reading;
    use crate::runner::run::{Reply, Request};
    use crate::session::plan::RunPlan;
    use crate::session::run::check;

    #[test]
    fn a_fault_in_the_search_is_told_and_costs_only_what_it_was_after() {
        let mut suite = Suite::load().expect("the suite loads");
        suite.cases.retain(|case| case.first);
        let ask = |request: &Request<'_>, _: usize| {
            let mut answer = misreadings::answer(&[], Reading::SPEC, request.file, request.view);
            if let Answer::Decoded(frame) = &mut answer
                && let Samples::U8(samples) = &mut frame.samples
            {
                for sample in samples.iter_mut() {
                    *sample ^= 0x55;
                }
            }
            Reply::from(answer)
        };
        let run = check(&suite, &RunPlan::of(&suite, 1), &ask, &|_, _, _, _| ());
        let causes = diagnose_by(&suite, &run, &[], 1, |_, _, _| panic!("index 3 of 2"));
        assert_eq!(causes.faults, ["index 3 of 2"]);
        let explained = causes.diagnoses.iter().map(|one| one.explains.len());
        assert_eq!(
            explained.sum::<usize>(),
            run.judgement.with(Outcome::Fail).count()
        );
    }
}
