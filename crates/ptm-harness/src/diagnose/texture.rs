//! Finds the misreadings that explain the failures of a texture stage.
//!
//! A misreading explains a failure if a stage that makes this mistake returns the received answer: an answer of its own, since an
//! undefined one equals any other. A passing case contradicts a misreading if such a stage would fail the case. No contradicted
//! misreading is reported, and none that predicts other answers than the received ones in as many failures as it explains.

use serde_json::{Map, Value, json};

use super::cover::{CoverCandidate, cover};
use super::diagnosis::Diagnosis;
use crate::session::texture::TextureRun;
use ptm_mistakes::Misreading;
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
        // A mistake may look like a different answer to an open question.
        let in_reference = misreading.apply_to(Rules::SPEC);
        let would_fail = |i: usize| {
            [&rules, &in_reference]
                .iter()
                .all(|rules| would_fail(run, &suite.cases[i], rules))
        };
        CoverCandidate::new(misreading, &failing, explains, &passing, would_fail)
    });
    let candidates: Vec<_> = candidates.collect();
    let mut unexplained = failing.clone();
    unexplained.retain(|i| is_answered(run, *i));
    unexplained.retain(|i| !candidates.iter().any(|one| one.explains.contains(i)));
    let is_supported = |candidate: &CoverCandidate<&'static Misreading<Change>>| {
        let rules = candidate.cause.apply_to(inferred);
        let predicts_another = |&&i: &&usize| predicts_failure(run, &suite.cases[i], &rules);
        candidate.explains.len() > unexplained.iter().filter(predicts_another).count()
    };
    let candidates = candidates.into_iter().filter(is_supported).collect();
    let causes = cover(candidates, &mut failing).into_iter();
    causes.map(CoverCandidate::diagnosis).collect()
}

fn is_answered(run: &TextureRun, i: usize) -> bool {
    let response = run.observations[i].as_ref().map(|one| &one.response);
    matches!(response, Some(Response::Image { .. }))
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

/// Returns true if a stage with these rules fails the case, even if its filters are as inexact as they may be.
fn would_fail(run: &TextureRun, case: &TextureCase, rules: &Rules) -> bool {
    let must_refuse = case.expectation() == Expect::Reject;
    match case.answer(rules) {
        Answer::Decoded(answer) => {
            let mut expected = case.expected(&run.judgment.dialect);
            double(&mut expected.filter_tolerance);
            must_refuse || expected.difference(&answer).is_some()
        }
        Answer::Rejected => !must_refuse,
        _ => true,
    }
}

/// Returns true if a stage with these rules fails the case, and does not do so with an undefined answer.
fn predicts_failure(run: &TextureRun, case: &TextureCase, rules: &Rules) -> bool {
    let is_undefined = |answer| matches!(answer, Answer::Decoded(answer) if is_undefined(&answer));
    would_fail(run, case, rules) && !is_undefined(case.answer(rules))
}

fn double(tolerance: &mut Value) {
    match tolerance {
        Value::Number(number) => *tolerance = json!(number.as_f64().map(|number| 2.0 * number)),
        Value::Array(values) => values.iter_mut().for_each(double),
        Value::Object(fields) => fields.values_mut().for_each(double),
        _ => {}
    }
}
