//! From failures to causes: what to fix, in a sentence.
//!
//! Before a cause is said it is held against every case: it must give the decoder's own picture or refusal, and no passing
//! case may deny it. First the catalog: the smallest set of misreadings with which a decoder answers the same. What no
//! misreading explains is solved from the pictures: right values in wrong places, values that are a function of the right
//! ones, wrong numbers in a formula. What is then left is put into words: refusals by what the refused files share,
//! acceptances by the damage, pictures by how they differ and where; and what is unknown is said to be.
//!
//! [`witness`] holds a case against what a decoder with some mistakes would answer, [`search`] finds the mistakes, [`solve`]
//! those that no list has: in [`values`], in the [`layout`] of a file, in [`planes`], in the [`codecs`]. [`files`] tells in
//! which files; [`attribution`] what each explains; [`words`] what is left.

mod answers;
mod assume;
mod attribution;
mod codecs;
mod coincidences;
mod credit;
mod diagnosis;
mod failure_mode;
mod files;
mod layout;
mod mistake;
mod pair;
mod planes;
mod search;
mod solve;
mod solve_file;
mod solved;
pub mod texture;
mod values;
mod witness;
mod words;

pub use assume::assume;
pub(crate) use codecs::cache::stream_once;
pub use diagnosis::{Category, Cause, Causes, Diagnosis};
pub use values::arithmetic;
pub(crate) use witness::dialect_reading;
pub use witness::{alike, applies, composable};

use crate::misreadings::Misreading;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::Suite;
use search::Search;
use witness::{Witness, reference_reading, witnesses};

/// Why the failures of `run` failed; most telling first. `assumed` are mistakes that the user knows of. Where the user
/// ends the search, most failures have no cause.
#[must_use]
pub fn diagnose(
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
) -> Causes {
    diagnose_by(suite, run, assumed, threads, solve::solve)
}

/// What was asked and answered. One mistake may look like another reading of an open question: where one of the catalog explains
/// all beside the reference's reading, and none does beside what the decoder seems to read, it is made in that.
fn told<'a>(
    suite: &'a Suite,
    run: &'a Run,
    assumed: &'a [&'static Misreading],
    threads: usize,
) -> Vec<Witness<'a>> {
    let by_dialect = witnesses(suite, run, None, threads);
    let Some(reading) = reference_reading(run) else {
        return by_dialect;
    };
    let by_reference = witnesses(suite, run, Some(reading), threads);
    let left = |of: &[Witness]| Search::new(of, assumed, threads, &run.stop).left_by_one();
    let (left, known) = (left(&by_reference), left(&by_dialect));
    match left.is_some_and(|left| known.is_none_or(|known| left < known)) {
        true => by_reference,
        false => by_dialect,
    }
}

/// The same as [`diagnose`], where `solve` is asked for mistakes that the catalog lacks.
fn diagnose_by(
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
    solve: impl Fn(&mut Search, &search::Set, &[usize]) -> Vec<search::Set>,
) -> Causes {
    let mut diagnoses = words::nondeterminism::describe(suite, run);
    diagnoses.extend(words::promises::describe(suite, run));
    let mut judged = run.judgement.cases.iter().flatten();
    if !judged.any(|judged| judged.outcome == Outcome::Fail) {
        return diagnoses.into();
    }
    let witnesses = told(suite, run, assumed, threads);
    if !witnesses.iter().any(|witness| witness.failed) {
        return diagnoses.into();
    }
    let mut search = Search::new(&witnesses, assumed, threads, &run.stop);
    let mut found = match words::nondeterminism::prevails(run) {
        true => search::Found::default(),
        false => search.run(solve),
    };
    if search.is_interrupted() {
        return diagnoses.into();
    }
    search.guarded(|| coincidences::drop(&search, &mut found));
    search.guarded(|| codecs::streams::drop(&search, &mut found));
    let (mut attributed, mut left) = attribution::attribute(&search, &found);
    search.guarded(|| codecs::streams::attribute_to_slips(&search, &mut attributed, &mut left));
    let mut causes = search.guarded(|| words::formats::describe(&witnesses, &mut left));
    causes.extend(search.guarded(|| words::acceptances::describe(&witnesses, &mut left)));
    let violation = search.guarded(|| words::violation::describe(&witnesses, &mut left));
    let in_streams = search.guarded(|| codecs::streams::describe(&search, &found, &mut left));
    let refusals = search.guarded(|| words::refusals::describe(&witnesses, &mut left));
    search.guarded(|| {
        attribution::attribute_in_part(&search, &found, &mut attributed, &mut left);
    });
    causes.extend(in_streams);
    causes.extend(refusals);
    causes.extend(search.guarded(|| words::refusals::rest(&witnesses, &mut left)));
    causes.extend(violation);
    let set = search::of(&found.members);
    causes.extend(search.guarded(|| planes::rest::describe(&search, &set, &mut left)));
    causes.extend(search.guarded(|| words::pictures::describe(&search, &set, &left)));
    causes.append(&mut diagnoses);
    let attributed = attributed.into_iter().map(|(_, diagnosis)| diagnosis);
    let mut causes: Vec<Diagnosis> = attributed.chain(causes).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::misreadings;
    use crate::protocol::frame::{Answer, Samples};
    use crate::reading::Reading;
    use crate::runner::run::{Reply, Request};
    use crate::session::plan::RunPlan;
    use crate::session::run::check;
    use crate::suite::cases::Case;

    /// What is said first of a decoder that reads so, of the cases that are kept.
    pub fn first_cause(reading: Reading, keep: fn(&Case) -> bool) -> String {
        let mut suite = Suite::load().expect("the suite loads").prepared();
        suite.cases.retain(keep);
        let ask = |request: &Request<'_>, _: usize| {
            Reply::from(misreadings::answer(
                &[],
                reading,
                request.file,
                request.view,
            ))
        };
        let run = check(&suite, &RunPlan::of(&suite, 2), &ask, &|_, _, _, _| ());
        let causes = diagnose(&suite, &run, &[], 2).diagnoses;
        match causes.first().map(|first| &first.cause) {
            Some(Cause::Misreading { misreading, .. }) => misreading.effect.to_owned(),
            Some(Cause::Described { effect, .. }) => effect.clone(),
            None => String::new(),
        }
    }

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
