//! From failures to causes: what to fix, in a sentence.
//!
//! Before a cause is said it is held against every case: it must give the decoder's own picture or refusal, and no passing
//! case may deny it. First the catalog: the smallest set of misreadings with which a decoder answers the same. What no
//! misreading explains is solved from the pictures: right values in wrong places, values that are a function of the right
//! ones, wrong numbers in a formula. What is then left is put into words: refusals by what the refused files share,
//! acceptances by the damage, pictures by how they differ and where; and what is unknown is said to be.

mod acceptances;
mod answers;
mod arithmetic;
mod assume;
mod attribution;
mod changes;
mod coincidences;
mod credit;
mod diagnosis;
mod failure_mode;
mod formats;
mod formulas;
mod mistake;
mod nondeterminism;
mod pair;
mod pictures;
mod places;
mod promises;
mod provenance;
mod refusals;
mod relations;
mod scope;
mod search;
mod shared;
mod solve;
mod solve_file;
mod solve_terms;
mod solved;
mod stream_cache;
mod streams;
mod strides;
mod terms;
pub mod texture;
mod trait_list;
mod traits;
mod violation;
mod witness;

pub use assume::assume;
pub use diagnosis::{Category, Cause, Diagnosis};
pub(crate) use stream_cache::stream_once;
pub(crate) use witness::dialect_reading;
pub use witness::{alike, applies, composable};

use crate::misreadings::Misreading;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::Suite;
use search::Search;
use witness::witnesses;

/// Why the failures of `run` failed; most telling first. `assumed` are mistakes that the user knows of. Where the user
/// ends the search, most failures have no cause.
#[must_use]
pub fn diagnose(
    suite: &Suite,
    run: &Run,
    assumed: &[&'static Misreading],
    threads: usize,
) -> Vec<Diagnosis> {
    let mut diagnoses = nondeterminism::describe(suite, run);
    diagnoses.extend(promises::describe(suite, run));
    let mut judged = run.judgement.cases.iter().flatten();
    if !judged.any(|judged| judged.outcome == Outcome::Fail) {
        return diagnoses;
    }
    let witnesses = witnesses(suite, run, dialect_reading(run), threads);
    if !witnesses.iter().any(|witness| witness.failed) {
        return diagnoses;
    }
    let mut search = Search::new(&witnesses, assumed, threads, &run.stop);
    let mut found = match nondeterminism::prevails(run) {
        true => search::Found::default(),
        false => search.run(solve::solve),
    };
    if search.is_interrupted() {
        return diagnoses;
    }
    coincidences::drop(&search, &mut found);
    let (mut attributed, mut left) = attribution::attribute(&search, &found);
    let mut causes = formats::describe(&witnesses, &mut left);
    causes.extend(acceptances::describe(&witnesses, &mut left));
    let violation = violation::describe(&witnesses, &mut left);
    let in_streams = streams::describe(&search, &found, &mut left);
    let refusals = refusals::describe(&witnesses, &mut left);
    attribution::attribute_in_part(&search, &found, &mut attributed, &mut left);
    causes.extend(in_streams);
    causes.extend(refusals);
    causes.extend(refusals::rest(&witnesses, &mut left));
    causes.extend(violation);
    let set = search::of(&found.members);
    causes.extend(pictures::describe(&search, &set, &left));
    causes.append(&mut diagnoses);
    let attributed = attributed.into_iter().map(|(_, diagnosis)| diagnosis);
    let mut causes: Vec<Diagnosis> = attributed.chain(causes).collect();
    // What explains most comes first; what is known for certain counts more than what is put into words.
    causes.sort_by_key(|diagnosis| {
        let explained = diagnosis.explains.len() + diagnosis.partly.len();
        std::cmp::Reverse(explained * if diagnosis.certain { 4 } else { 1 })
    });
    causes
}
