//! Finds the causes of failures.
//!
//! 1. `search` finds a small set of mistakes that reproduces the decoder's responses. Its candidates are the misreadings in the
//!    catalog. If these explain too few failures, `edits` and `learned` add candidates: edits of one formula, and tables that are
//!    inferred from the images.
//! 2. `coincidences` removes mistakes that match a few responses by chance.
//! 3. `attribution` lists each failing case under the mistake that explains it.
//! 4. `words` describes the remaining failures: refusals by a property that the refused files share, acceptances by
//!    the fault in the file, and images by the step at which their values first differ.
//!
//! `witness` compares a response with the answer of a decoder that makes certain mistakes. `scope` and `properties`
//! restrict a mistake to some files.

mod answers;
mod assume;
mod attribution;
mod coincidences;
pub mod cover;
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
pub(crate) use stream_cache::decode_stream_cached;
pub use tuning::MAX_WORK;
pub(crate) use witness::dialect_reading;
pub use witness::{can_affect_file, can_combine, equal_up_to_rounding};
pub use words::arithmetic_steps;

use std::time::Duration;

use crate::session::run::Run;
use answers::has_simple_explanation;
use ptm_mistakes::Misreading;
use ptm_suite::cases::Suite;
use ptm_suite::verdicts::outcome::Outcome;
use search::Search;
use tuning::MIN_SUPPORT;
use witness::{reference_reading, witnesses};

/// Returns the causes of the failures in `run`. Certain causes, and causes with many failures, come first. `assumed` lists
/// mistakes that the user knows about. If the user interrupts the search, most failures are left without a cause.
#[must_use]
pub fn diagnose(suite: &Suite, run: &Run, assumed: &[&'static Misreading], jobs: usize) -> Causes {
    let catalog: Vec<&Misreading> = ptm_mistakes::all().collect();
    let start = cpu_time();
    let mut causes = diagnose_among(&catalog, suite, run, assumed, jobs);
    causes.cpu_time = cpu_time()
        .zip(start)
        .map(|(now, start)| now.saturating_sub(start));
    causes
}

/// Returns the CPU time of this process, if the system reports it.
fn cpu_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::try_from(time).ok()
}

/// Like [`diagnose`], but with another catalog of misreadings.
#[must_use]
pub fn diagnose_among(
    catalog: &[&'static Misreading],
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
) -> Causes {
    let mut diagnoses = words::nondeterminism::describe(suite, run);
    diagnoses.extend(words::promises::describe(suite, run));
    if run.judgment.with_outcome(Outcome::Fail).next().is_none() {
        return diagnoses.into();
    }
    let by_dialect = witnesses(suite, run, None, threads);
    if !by_dialect.iter().any(|witness| witness.failed) {
        return diagnoses.into();
    }
    let run_search = |witnesses, with_edits: bool| {
        let mut search = Search::new(witnesses, catalog, assumed, threads, run);
        let found = match search.is_arbitrary {
            true => Vec::new(),
            false => search.run(|search, set, left| {
                if with_edits {
                    edits::add_candidates(search, set, left);
                }
            }),
        };
        (search, found)
    };
    let (mut search, mut found) = run_search(&by_dialect, true);
    // A mistake may look like a different choice. Unless the result is simple, search again with the reference's choices.
    let is_edit =
        |member: &search::Member| search.mistakes[member.id].catalog_misreading().is_none();
    let has_edits = found.iter().any(is_edit);
    let is_simple = search.cost(&found) <= MIN_SUPPORT && !has_edits;
    let by_reference = reference_reading(run)
        .filter(|_| !is_simple)
        .map(|reading| witnesses(suite, run, Some(reading), threads))
        .filter(|witnesses| has_simple_explanation(witnesses, catalog, threads));
    if let Some(by_reference) = &by_reference {
        // Try edits again only if they explained a failure.
        let (other, other_found) = run_search(by_reference, has_edits);
        if other.cost(&other_found) < search.cost(&found) + MIN_SUPPORT {
            (search, found) = (other, other_found);
        }
    }
    if search.is_interrupted() {
        return diagnoses.into();
    }
    search.run_or_default(|| coincidences::remove_coincidences(&search, &mut found));
    let mut causes = describe(&search, found);
    causes.append(&mut diagnoses);
    // Sort causes by the number of failures that they explain. A certain cause has more weight than a description.
    causes.sort_by_key(|diagnosis| {
        let explained = diagnosis.explains.len() + diagnosis.partial.len();
        std::cmp::Reverse(explained * if diagnosis.is_certain { 4 } else { 1 })
    });
    Causes {
        diagnoses: causes,
        faults: search.faults(),
        answer_count: search.answer_count(),
        cpu_time: None,
    }
}

/// Attributes failures to the mistakes that were found, and describes the remaining failures.
fn describe(search: &Search, mut found: Vec<search::Member>) -> Vec<Diagnosis> {
    let witnesses = search.witnesses;
    let (mut attributed, mut left) = attribution::attribute_failures(search, &mut found);
    let mut causes = search.run_or_default(|| words::uniform::describe(witnesses, &mut left));
    causes.extend(search.run_or_default(|| words::acceptances::describe(witnesses, &mut left)));
    let violation = search.run_or_default(|| words::violation::describe(witnesses, &mut left));
    let refusals = search.run_or_default(|| words::refusals::describe(witnesses, &mut left));
    search.run_or_default(|| {
        attribution::attribute_partially(search, &found, &mut attributed, &mut left);
    });
    causes.extend(refusals);
    causes.extend(
        search.run_or_default(|| words::refusals::describe_unexplained(witnesses, &mut left)),
    );
    causes.extend(violation);
    // Without a named mistake, compare images with the reference only.
    let is_cause = |(id, _): &(search::MistakeId, Diagnosis)| *id < search.mistakes.len();
    let set = match attributed.iter().any(is_cause) {
        true => search::ids_of(&found),
        false => search::MistakeSet::new(),
    };
    causes.extend(search.run_or_default(|| words::differences::describe(search, &set, &left)));
    let attributed = attributed.into_iter().map(|(_, diagnosis)| diagnosis);
    attributed.chain(causes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::judge_answers;
    use crate::session::plan::RunPlan;
    use ptm::reading::Reading;
    use ptm_suite::protocol::frame::{Answer, Samples};
    use ptm_suite::protocol::request::{Reply, Request};

    #[test]
    fn panic_in_the_source_of_candidates_loses_no_failure() {
        let mut suite = Suite::load().expect("the suite loads");
        suite.cases.retain(|case| case.first);
        let ask = |request: &Request<'_>, _: usize| {
            let mut answer = ptm_mistakes::answer(&[], Reading::SPEC, request.file, request.view);
            if let Answer::Decoded(frame) = &mut answer
                && let Samples::U8(samples) = &mut frame.samples
            {
                for sample in samples {
                    *sample ^= 0x55;
                }
            }
            Reply::from(answer)
        };
        let run = judge_answers(&suite, &RunPlan::new(&suite, 1), &ask);
        let witnesses = witnesses(&suite, &run, None, 1);
        let catalog: Vec<&Misreading> = ptm_mistakes::all().collect();
        let mut search = Search::new(&witnesses, &catalog, &[], 1, &run);
        let found = search.run(|_, _, _| panic!("index 3 of 2"));
        let causes = describe(&search, found);
        assert_eq!(search.faults(), ["index 3 of 2"]);
        let explained: usize = causes.iter().map(|cause| cause.explains.len()).sum();
        assert_eq!(explained, run.judgment.with_outcome(Outcome::Fail).count());
    }
}
