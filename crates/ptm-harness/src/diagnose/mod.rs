//! Finds the causes of failures, in three steps.
//!
//! 1. **Cover.** `search` finds a small set of mistakes that reproduces the decoder's responses: misreadings of the catalog, edits
//!    of one formula (`edits`), and tables that are learned from the images (`learned`). `attribution` lists each failure under the
//!    mistake that reproduces it.
//! 2. **Place.** What the mistakes do not reproduce is compared with a decoder that makes them: `place` finds the step at which an
//!    image first differs, and `groups` what the files of a group share (`scope`, `properties`).
//! 3. **Words.** `words` has a description for each kind of cause.
//!
//! `rules` keeps the sentences true. `witness` and `answers` compute what a decoder with certain mistakes would answer.

mod answers;
mod assume;
mod attribution;
pub mod cover;
mod diagnosis;
mod edits;
mod failure_mode;
mod groups;
mod image_pair;
mod imitated;
mod learned;
mod mistake;
mod place;
mod properties;
mod rules;
mod scope;
mod search;
mod stream_cache;
pub mod texture;
mod tuning;
mod witness;
mod words;

pub use assume::assume;
pub use diagnosis::{Accompanying, Category, Cause, Causes, Diagnosis};
pub(crate) use stream_cache::decode_stream_cached;
pub use tuning::MAX_WORK;
pub(crate) use witness::dialect_reading;
pub use witness::{can_affect_file, can_combine, equal_up_to_rounding};
pub use words::arithmetic_steps;

use std::time::Duration;

use crate::session::run::Run;
use ptm_mistakes::Misreading;
use ptm_suite::cases::Suite;
use ptm_suite::verdicts::outcome::Outcome;
use search::{MistakeSet, Search};
use witness::witnesses;

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
    let witnesses = witnesses(suite, run, threads);
    if !witnesses.iter().any(|witness| witness.failed) {
        return diagnoses.into();
    }
    let mut search = Search::new(&witnesses, catalog, assumed, threads, run);
    let found = if search.is_arbitrary {
        Vec::new()
    } else {
        search.run(edits::add_candidates)
    };
    let attribution = attribution::attribute_failures(&search, found);
    let mut causes = describe_rest(
        &search,
        [&attribution.set, &attribution.named],
        attribution.left,
    );
    causes.extend(attribution.diagnoses);
    if search.is_interrupted() {
        return diagnoses.into();
    }
    let imitated = imitated::imitated_readings(&search, run, &attribution.set);
    causes.append(&mut diagnoses);
    // A mechanism tells more than a description, so it counts as much as a description of four times as many failures.
    causes.sort_by_key(|diagnosis| {
        let weight = if diagnosis.is_mechanism { 4 } else { 1 };
        std::cmp::Reverse(diagnosis.explains.len() * weight)
    });
    Causes {
        diagnoses: causes,
        imitated,
        answer_count: search.answer_count(),
        cpu_time: None,
    }
}

/// Describes the failures that the mistakes in `set`, of which some are `named`, do not reproduce.
fn describe_rest(
    search: &Search,
    [set, named]: [&MistakeSet; 2],
    mut left: Vec<usize>,
) -> Vec<Diagnosis> {
    let witnesses = search.witnesses;
    let mut causes = words::uniform::describe(witnesses, &mut left);
    causes.extend(words::acceptances::describe(witnesses, &mut left));
    for group in groups::group_stops(search, &mut left) {
        causes.push(words::refusals::describe(witnesses, &group));
    }
    causes.extend(words::violation::describe(witnesses, &mut left));
    let steps = place::steps(search, set, &left);
    for (step, group) in groups::group_images(search, set, &steps) {
        causes.push(words::differences::describe(
            search,
            [set, named],
            step,
            &group,
        ));
    }
    causes
}
