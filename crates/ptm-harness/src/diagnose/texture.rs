//! Finds the misreadings that explain the failures of a texture stage.
//!
//! A misreading explains a failure if a stage that makes this mistake returns the received answer: an answer of its own, since an
//! undefined one equals any other. A passing case contradicts a misreading if such a stage would fail the case. A misreading is
//! reported only if it explains more cases than contradict it.

use serde_json::{Map, Value};

use super::cover::{CoverCandidate, cover};
use super::diagnosis::Diagnosis;
use crate::session::texture::TextureRun;
use ptm_mistakes::texture::{Change, all};
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::texture::cases::TextureCase;
use ptm_suite::texture::{choices::CHOICES, compare::ExpectedAnswer};
use ptm_suite::verdicts::{observation::Response, outcome::Outcome};
use ptm_texture::Rules;

/// Returns a small set of misreadings that explains the failures of `run`. The one that explains the most failures is first.
#[must_use]
pub fn diagnose(suite: &Suite<TextureCase>, run: &TextureRun) -> Vec<Diagnosis<Change>> {
    let mut failing: Vec<usize> = run.judgment.with_outcome(Outcome::Fail).collect();
    let passing: Vec<usize> = run.judgment.with_outcome(Outcome::Pass).collect();
    let inferred = CHOICES.apply(&run.judgment.dialect, Rules::SPEC);
    let candidates = all().filter_map(|misreading| {
        let rules = misreading.apply_to(inferred);
        let explains = |i: usize| explains(run, i, &suite.cases[i], &rules);
        let would_fail = |i: usize| would_fail(run, &suite.cases[i], &rules);
        CoverCandidate::new(misreading, &failing, explains, &passing, would_fail)
    });
    let candidates = candidates.filter(CoverCandidate::is_supported).collect();
    let causes = cover(candidates, &mut failing).into_iter();
    causes.map(CoverCandidate::diagnosis).collect()
}

/// Returns true if a stage with these rules returns the received answer, which is not a correct one.
fn explains(run: &TextureRun, i: usize, case: &TextureCase, rules: &Rules) -> bool {
    let Some(observation) = &run.observations[i] else {
        return false;
    };
    match (&observation.response, case.expected_under(rules)) {
        // Any answer is as good as an undefined one.
        (Response::Image { .. }, Some(misread)) if is_undefined(&misread.answer) => false,
        (Response::Image { .. }, Some(_)) if case.expectation() == Expect::Reject => true,
        (Response::Image { frame, .. }, Some(misread)) => {
            // Answers that equal the reference's are not stored.
            let received = frame.as_ref().unwrap_or(&case.expect);
            let expected = case.expected(&run.judgment.dialect);
            is_wrong_answer(&expected, &misread.answer)
                && has_same_fields(case, &misread.answer, received)
                && only_checked_fields(case, misread)
                    .difference(received)
                    .is_none()
        }
        (Response::Rejected, None) => case.answer(rules) == Answer::Rejected,
        _ => false,
    }
}

fn is_undefined(answer: &Value) -> bool {
    answer.get("impl_defined").is_some()
}

/// Returns true if at least one checked field of `answer` has another value than expected.
fn is_wrong_answer(expected: &ExpectedAnswer, answer: &Value) -> bool {
    let mut present = expected.clone();
    if let Some(fields) = present.answer.as_object_mut() {
        fields.retain(|name, _| answer.get(name).is_some());
    }
    present.difference(answer).is_some()
}

/// Returns true if each checked field is in both answers or in neither.
fn has_same_fields(case: &TextureCase, a: &Value, b: &Value) -> bool {
    let mut names = case.expect.as_object().into_iter().flat_map(Map::keys);
    names.all(|name| a.get(name).is_some() == b.get(name).is_some())
}

fn only_checked_fields(case: &TextureCase, mut misread: ExpectedAnswer) -> ExpectedAnswer {
    if let Some(fields) = misread.answer.as_object_mut() {
        fields.retain(|name, _| case.expect.get(name).is_some());
    }
    misread
}

fn would_fail(run: &TextureRun, case: &TextureCase, rules: &Rules) -> bool {
    let must_refuse = case.expectation() == Expect::Reject;
    match case.answer(rules) {
        Answer::Decoded(answer) => {
            let expected = case.expected(&run.judgment.dialect);
            must_refuse || expected.difference(&answer).is_some()
        }
        Answer::Rejected => !must_refuse,
        _ => true,
    }
}
