//! A run of the texture suite: questions to a texture stage. `ptm_suite::texture::judge` returns the verdicts on its answers.

use std::collections::BTreeSet;
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
use ptm_suite::dialect::RightDialects;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::test_case::Allowance;
use ptm_suite::texture::cases::{TextureCase, TextureView};
pub use ptm_suite::texture::judge::TextureObservation;
use ptm_suite::texture::judge::{judge, twins};
use ptm_suite::verdicts::observation::{Observation, Response};
use ptm_suite::verdicts::offer::Offer;
use ptm_suite::verdicts::outcome::Outcome;

/// The results of a run of the texture suite.
pub type TextureRun = Run<TextureView, Value, String, String>;

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
            not_asked: Vec::new(),
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
