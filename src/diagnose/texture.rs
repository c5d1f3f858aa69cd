//! From failures of a texture stage to causes: which misreading would have failed in the same way.
//!
//! A misreading explains a failure if one who makes it answers the same. It is contradicted by every case that passed and
//! that it would have failed. The one that explains most goes first, and then the next for what is left.

use std::cmp::Reverse;

use serde_json::Value;

use super::diagnosis::{Cause, Diagnosis};
use crate::misreadings::Misreading;
use crate::misreadings::texture::{Change, all};
use crate::protocol::frame::Answer;
use crate::session::observation::Response;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::{Expect, Suite};
use crate::suite::test_case::TestCase;
use crate::suite::texture::cases::TextureCase;
use crate::suite::texture::choices::CHOICES;
use crate::suite::texture::compare::difference;
use crate::texture::Rules;

/// A misreading that might be made.
struct Candidate {
    diagnosis: Diagnosis<Change>,
    /// Passing cases that it would have failed.
    contradicted: usize,
}

/// The fewest mistakes that explain the failures of `run`, as far as single mistakes do; most telling first.
#[must_use]
pub fn diagnose(suite: &Suite<TextureCase>, run: &Run<TextureCase>) -> Vec<Diagnosis<Change>> {
    let mut failing: Vec<usize> = run.judgement.with(Outcome::Fail).collect();
    let mut candidates = candidates(suite, run, &failing);
    let mut diagnoses = Vec::new();
    loop {
        for candidate in &mut candidates {
            let explains = &mut candidate.diagnosis.explains;
            explains.retain(|i| failing.contains(i));
        }
        candidates.retain(|candidate| !candidate.diagnosis.explains.is_empty());
        // The one that explains most; of equals the least contradicted, then the first of the catalog.
        let best = (0..candidates.len()).min_by_key(|&at| {
            let candidate = &candidates[at];
            let explained = candidate.diagnosis.explains.len();
            (Reverse(explained), candidate.contradicted)
        });
        let Some(best) = best else {
            return diagnoses;
        };
        let Candidate { diagnosis, .. } = candidates.remove(best);
        failing.retain(|i| !diagnosis.explains.contains(i));
        diagnoses.push(diagnosis);
    }
}

/// The misreadings that explain more failures than passing cases contradict.
fn candidates(
    suite: &Suite<TextureCase>,
    run: &Run<TextureCase>,
    failing: &[usize],
) -> Vec<Candidate> {
    let own = CHOICES.under(&run.judgement.dialect, Rules::SPEC);
    let candidate = |misreading: &'static Misreading<Change>| {
        let rules = misreading.change(own);
        let explained = |&i: &usize| explains(run, i, &suite.cases[i], &rules);
        let explains: Vec<usize> = failing.iter().copied().filter(explained).collect();
        if explains.is_empty() {
            return None;
        }
        let passing = run.judgement.with(Outcome::Pass);
        let contradicted = passing
            .filter(|&i| is_wrong(run, &suite.cases[i], &rules))
            .count();
        (explains.len() > contradicted).then(|| Candidate {
            diagnosis: Diagnosis {
                cause: Cause::Misreading {
                    misreading,
                    alike: Vec::new(),
                    with: Vec::new(),
                },
                explains,
                partly: Vec::new(),
                except: Vec::new(),
                shows: None,
                certain: true,
            },
            contradicted,
        })
    };
    all().filter_map(candidate).collect()
}

/// Whether one who reads so answers as the decoder did.
fn explains(run: &Run<TextureCase>, i: usize, case: &TextureCase, rules: &Rules) -> bool {
    let Some(observation) = &run.observations[i] else {
        return false;
    };
    match (&observation.response, case.answer(rules)) {
        (Response::Picture { frame, .. }, Answer::Decoded(made)) => {
            // Both ways: a field that only one of them has is a difference.
            case.expect() == Expect::Reject || {
                // What equals the reference's answer is not kept.
                let shown = frame.as_ref().unwrap_or(&case.expect);
                difference(&only_expected(case, &made), shown, case.tolerance()).is_none()
            }
        }
        (Response::Rejected, Answer::Rejected) => true,
        _ => false,
    }
}

/// Of an answer the fields that the case looks at.
fn only_expected(case: &TextureCase, answer: &Value) -> Value {
    let fields = case.expect.as_object().into_iter().flatten();
    let kept = fields.filter_map(|(name, _)| Some((name.clone(), answer.get(name)?.clone())));
    Value::Object(kept.collect())
}

/// Whether one who reads so fails the case.
fn is_wrong(run: &Run<TextureCase>, case: &TextureCase, rules: &Rules) -> bool {
    let must_refuse = case.expect() == Expect::Reject;
    match case.answer(rules) {
        Answer::Decoded(made) => {
            let expected = case.expected(&run.judgement.dialect);
            must_refuse || difference(&expected, &made, case.tolerance()).is_some()
        }
        Answer::Rejected => !must_refuse,
        _ => true,
    }
}
