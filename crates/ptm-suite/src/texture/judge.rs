//! Verdicts on the answers of a texture stage. [`outcome()`] is the table of verdicts.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::cases::Expect;
use crate::dialect::{Dialect, RightDialects};
use crate::texture::cases::{TextureCase, TextureView};
use crate::texture::choices::CHOICES;
use crate::verdicts::dialect::dialect_in;
use crate::verdicts::judge::{
    FeatureTally, Judgment, fail, mixed_readings_text, undecoded_twin_reason, verdict,
};
use crate::verdicts::observation::{Observation, Response};
use crate::verdicts::offer::Offer;
use crate::verdicts::outcome::{Outcome, Verdict, outcome};

/// The result of a question.
pub type TextureObservation = Observation<TextureView, Value, String>;

/// Returns, for each question that must be refused, the legal questions about its step. If none of them is answered, a refusal
/// proves nothing.
pub fn twins(cases: &[TextureCase]) -> Vec<Vec<usize>> {
    let is_legal = |case: &TextureCase| case.expectation() != Expect::Reject;
    let twins = |case: &TextureCase| -> Vec<usize> {
        let is_twin = |&i: &usize| is_legal(&cases[i]) && cases[i].op == case.op;
        if is_legal(case) {
            Vec::new()
        } else {
            (0..cases.len()).filter(is_twin).collect()
        }
    };
    cases.iter().map(twins).collect()
}

/// Judges the observations of a run. `observations` has a slot for each case of the suite. `selected` marks the cases to judge; the
/// others only serve as twins.
pub fn judge(
    cases: &[TextureCase],
    selected: &[bool],
    observations: &[Option<TextureObservation>],
    offer: &Offer<String>,
) -> Judgment<String> {
    let is_right = |i: usize, dialect: &Dialect| {
        let Some(Response::Image { right, frame, .. }) = response(observations, i) else {
            return false;
        };
        if CHOICES.combination_index(dialect, right.axes()) == 0 {
            return right.is_right_in_reference();
        }
        // An answer that equals the reference's is not kept.
        let answer = frame.as_ref().unwrap_or(&cases[i].expect);
        cases[i].expected(dialect).difference(answer).is_none()
    };
    let mut dependent = Vec::new();
    for (i, observation) in observations.iter().enumerate() {
        if let Some(observation) = observation
            && observation.nondeterminism.is_none()
            && let Response::Image {
                right: RightDialects::Depends { axes, .. },
                ..
            } = &observation.response
        {
            dependent.push((i, &axes[..]));
        }
    }
    let (dialect, certainties) = dialect_in(&CHOICES, &dependent, is_right);
    let (unsupported, decoded) = features(cases, observations, offer);
    let twins = twins(cases);
    let judge_case = |i: usize| {
        let Some(observation) = &observations[i] else {
            return verdict(Outcome::NotJudged, "no view of the case is supported");
        };
        let facts = QuestionFacts {
            case: &cases[i],
            observation,
            is_supported: cases[i].features().is_disjoint(&unsupported),
            is_right: is_right(i, &dialect),
        };
        let is_image =
            |&twin: &usize| matches!(response(observations, twin), Some(Response::Image { .. }));
        let undecoded_twin = undecoded_twin_reason(&twins[i], is_image, |i| &cases[i].id);
        facts.verdict(&dialect, undecoded_twin, |other| is_right(i, other))
    };
    Judgment {
        cases: (0..cases.len())
            .map(|i| selected[i].then(|| judge_case(i)))
            .collect(),
        dialect,
        certainties,
        unsupported,
        decoded,
    }
}

fn response(
    observations: &[Option<TextureObservation>],
    case: usize,
) -> Option<&Response<Value, String>> {
    Some(&observations[case].as_ref()?.response)
}

struct QuestionFacts<'a> {
    case: &'a TextureCase,
    observation: &'a TextureObservation,
    /// True if the stage supports every feature that the question needs.
    is_supported: bool,
    /// True if the response is an answer that is right in the dialect of the stage.
    is_right: bool,
}

impl QuestionFacts<'_> {
    /// Returns the outcome and the reason, according to the table and the exceptions in docs/protocol.md. `undecoded_twin` is the
    /// reason why a refusal proves nothing, if it does not.
    fn verdict(
        &self,
        dialect: &Dialect,
        undecoded_twin: Option<String>,
        is_right_in: impl Fn(&Dialect) -> bool,
    ) -> Verdict {
        let (case, response) = (self.case, &self.observation.response);
        if let Some(how) = &self.observation.nondeterminism {
            return fail(&*how.message);
        }
        let expect = case.expectation();
        let outcome = outcome(expect, self.is_supported, response.kind(self.is_right));
        if outcome == Outcome::Unsupported {
            return verdict(outcome, "");
        }
        if !matches!(response, Response::Violation(_))
            && let Some(reason) = undecoded_twin
        {
            return verdict(Outcome::Inconclusive, reason);
        }
        let expected = &case.expect;
        match response {
            _ if outcome == Outcome::Pass => verdict(outcome, ""),
            Response::Violation(answer) => fail(answer.describe()),
            Response::Rejected if expect == Expect::ImplementationDefined => {
                let message = format!("received a refusal; the reference answers {expected}");
                verdict(outcome, message)
            }
            Response::Rejected => fail(format!("expected {expected}, received a refusal")),
            Response::Unsupported if expect == Expect::Reject => {
                fail("exited with 69 (unsupported) on a malformed file of a kind that it decodes")
            }
            Response::Unsupported => {
                fail("exited with 69 (unsupported), but decodes other files of this kind")
            }
            Response::Image { .. } if expect == Expect::Reject => fail(format!(
                "accepted a file that must be refused: {}",
                expected["error"]
            )),
            Response::Image {
                right,
                difference,
                frame,
                ..
            } => {
                let answer = frame.as_ref().unwrap_or(expected);
                let own = case.expected(dialect).difference(answer);
                let difference = own.or_else(|| difference.clone()).unwrap_or_default();
                if expect == Expect::ImplementationDefined {
                    return verdict(
                        outcome,
                        format!("left to the implementation; the reference differs: {difference}"),
                    );
                }
                let mut dialects = CHOICES.combinations(right.axes()).into_iter();
                match dialects.find(|other| is_right_in(other)) {
                    Some(other) => {
                        let axes = right.axes();
                        fail(mixed_readings_text(&CHOICES, axes, dialect, &other) + &difference)
                    }
                    None => fail(difference),
                }
            }
        }
    }
}

/// Returns the unsupported and the decoded features. A feature is unsupported if none of its questions was answered and most were
/// answered with 69.
fn features(
    cases: &[TextureCase],
    observations: &[Option<TextureObservation>],
    offer: &Offer<String>,
) -> (BTreeSet<String>, BTreeSet<String>) {
    let mut tally = FeatureTally::default();
    for (case, observation) in cases.iter().zip(observations) {
        let Some(observation) = observation else {
            continue;
        };
        // The first questions about an unsupported step were answered with 69, even if they are not selected.
        if offer.unsupported.contains(&case.op) {
            tally.count_first_files(&case.op);
        }
        if case.expectation() != Expect::Reject {
            for feature in case.features() {
                tally.count(feature, &observation.response);
            }
        }
    }
    tally.unsupported_and_decoded()
}
