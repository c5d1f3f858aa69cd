//! A run of the texture suite: questions to a texture stage, and the verdicts on its answers.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use serde_json::Value;

use crate::session::asking::CountCallback;
use crate::session::contact::{Contact, FirstFile, non_decoder_reason};
use crate::session::plan::{Repeat, RunPlan};
use crate::session::run::{Run, all_unsupported_reason};
use crate::session::schedule::{Finished, Requests};
use crate::session::tally::{MAX_CONSECUTIVE, Tally};
use ptm_suite::cases::{Expect, Suite, TableSpelling};
use ptm_suite::dialect::{Dialect, RightDialects};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::test_case::Allowance;
use ptm_suite::texture::cases::{TextureCase, TextureView};
use ptm_suite::texture::choices::CHOICES;
use ptm_suite::verdicts::dialect::dialect_in;
use ptm_suite::verdicts::judge::{
    Judgment, fail, mixed_readings_text, undecoded_twin_reason, verdict,
};
use ptm_suite::verdicts::observation::{Observation, Response};
use ptm_suite::verdicts::offer::Offer;
use ptm_suite::verdicts::outcome::{Outcome, ResponseKind, Verdict, outcome};

/// The results of a run of the texture suite.
pub type TextureRun = Run<TextureView, Value, String, String>;

/// The result of a question.
pub type TextureObservation = Observation<TextureView, Value, String>;

/// The result of first contact with a texture stage.
pub type TextureContact = Contact<TextureView, Value, String>;

/// A texture stage: a function from questions to replies. The number identifies the worker that sends the question.
pub type StageFn<'a> = dyn Fn(&Request<'_, TextureView>, usize) -> Reply<Value> + Sync + 'a;

/// Maximum size of an answer in bytes. Answers are small JSON objects.
const MAX_ANSWER_BYTES: usize = 1 << 20;

/// A run in progress: the stage, the plan, and a count of the requests.
pub struct TextureSession<'a> {
    suite: &'a Suite<TextureCase>,
    plan: &'a RunPlan,
    ask: &'a StageFn<'a>,
    tally: Tally,
}

impl<'a> TextureSession<'a> {
    /// Creates a session that has not sent any request yet.
    #[must_use]
    pub fn new(
        suite: &'a Suite<TextureCase>,
        plan: &'a RunPlan,
        ask: &'a StageFn<'a>,
    ) -> TextureSession<'a> {
        TextureSession {
            suite,
            plan,
            ask,
            tally: Tally::default(),
        }
    }

    /// Asks the first questions, one after the other, to find out whether the program is a texture stage and which steps it
    /// supports. Until it has answered once, it may have to warm up, so questions have the higher time limit.
    #[must_use]
    pub fn first_contact(&self) -> TextureContact {
        let mut first: Vec<FirstFile<TextureView, Value>> = Vec::new();
        let mut consecutive = 0;
        for (case, question) in self.suite.cases.iter().enumerate() {
            if !question.first || !self.plan.is_requested(case) {
                continue;
            }
            let is_warm = first.iter().any(|first| !first.reply.is_timeout());
            let mut attempt = if is_warm {
                AttemptKind::Usual
            } else {
                AttemptKind::Alone
            };
            let (_, mut reply) = self.request(case, 0, attempt);
            self.tally.count(&reply, attempt);
            if is_warm && reply.is_timeout() && self.plan.may_ask_alone() {
                attempt = AttemptKind::Alone;
                (_, reply) = self.request(case, 0, attempt);
                self.tally.count_alone(&reply, &question.id);
            }
            consecutive = if reply.is_timeout() {
                consecutive + 1
            } else {
                0
            };
            if let (MAX_CONSECUTIVE, Answer::TimedOut(limit)) = (consecutive, &reply.answer) {
                let _ = self.tally.exceeded_limit.set(*limit);
            }
            let is_hopeless = matches!(reply.answer, Answer::NotStarted(_));
            first.push(FirstFile {
                case,
                view: TextureView,
                reply,
                attempt,
            });
            if is_hopeless || self.tally.end_reason(self.plan).is_some() {
                break;
            }
        }
        let mut offer = Offer::default();
        let is_decoded = |first: &FirstFile<_, _>| matches!(first.reply.answer, Answer::Decoded(_));
        let is_unsupported =
            |first: &FirstFile<_, _>| matches!(first.reply.answer, Answer::Unsupported);
        if first.iter().any(is_decoded) || !first.iter().all(is_unsupported) {
            offer.views = vec!["texture"];
        }
        let steps: BTreeSet<&str> = first.iter().map(|first| self.step(first.case)).collect();
        for step in steps {
            let mut of_step = first.iter().filter(|first| self.step(first.case) == step);
            if of_step.all(is_unsupported) {
                offer.unsupported.push(step.to_owned());
            }
        }
        Contact {
            not_a_decoder: non_decoder_reason(&first),
            offer,
            first,
            table: TableSpelling::default(),
            remarks: Vec::new(),
            end_reason: None,
        }
    }

    fn step(&self, case: usize) -> &str {
        &self.suite.cases[case].op
    }

    /// Asks all selected questions once, and the first legal question of each step that must be refused. `finished` is called
    /// after each of them.
    pub(crate) fn ask_questions(
        &self,
        contact: &TextureContact,
        finished: &Finished<TextureView, Value, String>,
    ) -> Vec<Option<TextureObservation>> {
        let mut wanted = self.plan.selected.clone();
        for (i, twins) in twins(&self.suite.cases).into_iter().enumerate() {
            if let (true, Some(&twin)) = (self.plan.selected[i], twins.first()) {
                wanted[twin] = true;
            }
        }
        let is_asked = |&i: &usize| wanted[i] && self.plan.is_requested(i);
        let cases: Vec<usize> = if contact.not_a_decoder.is_none() && is_offered(&contact.offer) {
            (0..wanted.len()).filter(is_asked).collect()
        } else {
            Vec::new()
        };
        let mut observations = vec![None; self.suite.cases.len()];
        self.request_all(&cases, &mut observations, finished);
        observations
    }

    /// Repeats the questions that exceeded the time limit, judges the answers, repeats failures, and judges again if an answer
    /// differed. `progress` is called after each repetition.
    #[must_use]
    pub(crate) fn verdicts(
        self,
        contact: TextureContact,
        mut observations: Vec<Option<TextureObservation>>,
        progress: &CountCallback,
    ) -> TextureRun {
        let (cases, offer) = (&self.suite.cases, contact.offer);
        let end_reason = || self.tally.end_reason(self.plan);
        self.repeat_open(&mut observations, progress);
        let mut ended_early = end_reason();
        let nothing = vec![false; cases.len()];
        let selected = match contact.not_a_decoder {
            Some(_) => &nothing,
            None => &self.plan.selected,
        };
        let mut judgment = judge(cases, selected, &observations, &offer);
        if ended_early.is_none() && self.plan.repeat != Repeat::Nothing {
            let is_settled = |&i: &usize| {
                let observation = observations[i].as_ref();
                observation.is_none_or(Observation::is_settled)
            };
            let failures = judgment.with_outcome(Outcome::Fail);
            let wanted = failures.filter(|i| !is_settled(i)).collect();
            if self.repeat(wanted, |i| self.step(i), &mut observations, progress) {
                judgment = judge(cases, selected, &observations, &offer);
            }
            // The run may be interrupted while questions are repeated.
            ended_early = end_reason();
        }
        let legal = cases.iter().zip(&observations);
        let legal = legal.filter(|(case, _)| case.expectation() == Expect::Decode);
        let legal = legal.filter_map(|(_, observation)| observation.as_ref());
        let not_a_decoder = contact
            .not_a_decoder
            .or_else(|| all_unsupported_reason(legal));
        let observed = observations.iter().flatten();
        let open = observed.filter(|observation| observation.is_open()).count();
        let mut run = Run {
            observations,
            judgment,
            first: contact.first,
            offer,
            table: contact.table,
            remarks: self.tally.remarks(open),
            request_count: self.tally.calls.load(Ordering::Relaxed),
            violations: self.tally.violations.load(Ordering::Relaxed),
            ended_early,
            not_a_decoder,
            stop: Arc::clone(&self.plan.stop),
            work: Arc::default(),
        };
        let is_offered = is_offered(&run.offer);
        run.explain_skipped_cases(&self.plan.withheld, |_| is_offered);
        run.report_early_end();
        run
    }

    /// Sends a question without counting it.
    fn request(
        &self,
        case: usize,
        worker: usize,
        attempt: AttemptKind,
    ) -> (TextureObservation, Reply<Value>) {
        let case = &self.suite.cases[case];
        let request = Request {
            name: &case.id,
            view: &TextureView,
            file: &case.to_file(),
            max_frame_bytes: MAX_ANSWER_BYTES,
            attempt,
        };
        let reply = (self.ask)(&request, worker);
        if attempt == AttemptKind::Alone && reply.is_timeout() {
            self.plan.unanswered.fetch_add(1, Ordering::Relaxed);
        }
        let response = match &reply.answer {
            Answer::Rejected => Response::Rejected,
            Answer::Unsupported => Response::Unsupported,
            Answer::Decoded(answer) => {
                let (right, difference) = case.compare(answer);
                let differs = right != RightDialects::Regardless(true) && difference.is_some();
                Response::Image {
                    right,
                    difference,
                    allowance: Allowance::None,
                    frame: differs.then(|| answer.clone()),
                }
            }
            _ => Response::Violation(reply.answer.clone()),
        };
        let observation = Observation {
            view: TextureView,
            response,
            weak: reply.is_ambiguous_refusal(),
            stderr: reply.stderr.clone(),
            attempt,
            previous_request: None,
            nondeterminism: None,
        };
        (observation, reply)
    }
}

impl Requests<TextureView, Value, String> for TextureSession<'_> {
    fn plan(&self) -> &RunPlan {
        self.plan
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }

    fn is_legal(&self, case: usize) -> bool {
        self.suite.cases[case].expectation() == Expect::Decode
    }

    fn observe(&self, case: usize, worker: usize) -> TextureObservation {
        let (observation, reply) = self.request(case, worker, AttemptKind::Usual);
        self.tally.count(&reply, AttemptKind::Usual);
        observation
    }

    fn observe_alone(&self, case: usize, _: &TextureView) -> Option<TextureObservation> {
        if !self.plan.may_ask_alone() {
            return None;
        }
        let (observation, reply) = self.request(case, 0, AttemptKind::Alone);
        if self.plan.is_interrupted() {
            return None;
        }
        self.tally.count_alone(&reply, &self.suite.cases[case].id);
        Some(observation)
    }

    fn observe_again(&self, case: usize, _: &TextureView, worker: usize) -> TextureObservation {
        self.request(case, worker, AttemptKind::Repetition).0
    }
}

fn is_offered(offer: &Offer<String>) -> bool {
    !offer.views.is_empty()
}

/// Returns, for each question that must be refused, the legal questions about its step. If none of them is answered, a refusal
/// proves nothing.
fn twins(cases: &[TextureCase]) -> Vec<Vec<usize>> {
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

/// Judges the observations of a run. `selected` marks the cases to judge; the others only serve as twins.
fn judge(
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
        let kind = match response {
            Response::Image { .. } if self.is_right => ResponseKind::Expected,
            Response::Image { .. } => ResponseKind::Different,
            Response::Rejected => ResponseKind::Rejected,
            Response::Unsupported => ResponseKind::Unsupported,
            Response::Violation(_) => ResponseKind::Violation,
        };
        let outcome = outcome(expect, self.is_supported, kind);
        if outcome == Outcome::Unsupported {
            return verdict(outcome, "");
        }
        if let Some(reason) = undecoded_twin {
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
    // For each feature, the number of questions and the number answered with 69.
    let mut asked: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    let mut decoded = BTreeSet::new();
    for (case, observation) in cases.iter().zip(observations) {
        let Some(observation) = observation else {
            continue;
        };
        // The first questions about an unsupported step were answered with 69, even if they are not selected.
        if offer.unsupported.contains(&case.op) {
            asked.entry(case.op.clone()).or_insert((1, 1));
        }
        if case.expectation() == Expect::Reject {
            continue;
        }
        for feature in case.features() {
            let (all, unsupported) = asked.entry(feature.clone()).or_default();
            *all += 1;
            match observation.response {
                Response::Unsupported => *unsupported += 1,
                Response::Image { .. } => {
                    decoded.insert(feature);
                }
                _ => {}
            }
        }
    }
    asked.retain(|feature, (all, unsupported)| {
        *unsupported * 2 > *all && !decoded.contains(feature)
    });
    (asked.into_keys().collect(), decoded)
}
