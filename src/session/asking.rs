//! Requests for a case in a view, and their results.
//!
//! The decoder is a closure from request to reply, so simulated misreadings and external programs are judged in the same way.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::kit::parallel::run_on_threads;
use crate::protocol::frame::Answer;
use crate::runner::run::{Reply, Request};
use crate::session::observation::{Nondeterminism, Observation, Response};
use crate::session::plan::{Repeat, RunPlan};
use crate::session::tally::Tally;
use crate::suite::cases::{Case, Suite, TableSpelling};
use crate::suite::{dialect::RightDialects, test_case::TestCase};

/// A reply to a request for a case.
pub type ReplyTo<C> = Reply<<C as TestCase>::Output>;

/// A decoder: a function from requests to replies. The number identifies the worker that sends the request.
pub type DecoderFn<'a, C = Case> =
    dyn Fn(&Request<'_, <C as TestCase>::View>, usize) -> ReplyTo<C> + Sync + 'a;

/// A progress callback. It receives the number of finished items and the total.
pub type CountCallback<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// Undoes a common transform: maps a received output, and the reference's output if known, to the output before the transform.
pub type UndoFn<T> = dyn Fn(&T, Option<&T>) -> T + Send + Sync;

/// A common transform of all images in a view. It has been reported, and is undone before images are compared.
#[derive(Clone)]
pub struct UndoneTransform<C: TestCase> {
    /// The affected view.
    pub view: &'static str,
    /// Maps a received output to the output before the transform.
    pub undo: Arc<UndoFn<C::Output>>,
}

/// A run in progress: the decoder, the plan, and a count of the requests.
pub struct Session<'a, C: TestCase> {
    pub(super) suite: &'a Suite<C>,
    pub(super) plan: &'a RunPlan,
    pub(super) tally: Tally,
    ask: &'a DecoderFn<'a, C>,
    /// Common transforms that are undone before images are compared.
    pub undone_transforms: Vec<UndoneTransform<C>>,
}

impl<'a, C: TestCase> Session<'a, C> {
    /// Creates a session that has not sent any request yet.
    #[must_use]
    pub fn new(suite: &'a Suite<C>, plan: &'a RunPlan, ask: &'a DecoderFn<'a, C>) -> Self {
        Session {
            suite,
            plan,
            tally: Tally::default(),
            ask,
            undone_transforms: Vec::new(),
        }
    }

    /// Returns true if no more requests will be sent.
    pub(crate) fn is_over(&self) -> bool {
        self.end_reason().is_some()
    }

    pub(super) fn end_reason(&self) -> Option<&'static str> {
        let (stop, hangs) = (&self.plan.stop, &self.tally.too_many_hangs);
        match (stop.load(Ordering::Relaxed), hangs.load(Ordering::Relaxed)) {
            (true, _) => Some("the run was interrupted"),
            (false, true) => {
                Some("the run ended early: the decoder hung on three legal files in a row")
            }
            (false, false) => None,
        }
    }

    /// Returns the number of requests so far.
    #[must_use]
    pub fn requests_sent(&self) -> usize {
        self.tally.calls.load(Ordering::Relaxed)
    }

    /// Requests `case` in `view` and compares the answer with the expected one. `worker` identifies a concurrent caller.
    pub(super) fn observe(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
        worker: usize,
    ) -> (Observation<C>, ReplyTo<C>) {
        // The decoder may have to warm up in the first call.
        let timeout_factor = match self.tally.calls.fetch_add(1, Ordering::Relaxed) {
            0 => 3,
            _ => 1,
        };
        let (observation, reply) = self.request(case, view, table, worker, Some(timeout_factor));
        if reply.answer.violation().is_some() || reply.serve_mode_answer.is_some() {
            self.tally.violations.fetch_add(1, Ordering::Relaxed);
        }
        (observation, reply)
    }

    /// Sends a request without counting it. If `timeout_factor` is `None`, the request goes to a new process.
    pub(super) fn request(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
        worker: usize,
        timeout_factor: Option<u32>,
    ) -> (Observation<C>, ReplyTo<C>) {
        let built = case.make(table);
        let request = Request {
            name: case.id(),
            view,
            file: C::file(&built),
            max_frame_bytes: case.max_output_bytes(&built),
            timeout_factor: timeout_factor.unwrap_or(1),
            needs_new_process: timeout_factor.is_none(),
        };
        let reply = (self.ask)(&request, worker);
        let response = match &reply.answer {
            Answer::Rejected => Response::Rejected,
            Answer::Unsupported => Response::Unsupported,
            Answer::Decoded(output) => {
                let mut undo = self.undone_transforms.iter();
                let undo = undo.find(|undo| undo.view == C::view_name(view));
                let output = undo.map_or(Cow::Borrowed(output), |undo| {
                    Cow::Owned((undo.undo)(output, case.expected_output(view).as_ref()))
                });
                let result = case.compare(&built, view, &output);
                let differs =
                    result.right != RightDialects::Regardless(true) && result.difference.is_some();
                Response::Image {
                    right: result.right,
                    difference: result.difference,
                    allowance: result.allowance,
                    frame: differs.then(|| output.into_owned()),
                }
            }
            _ => Response::Violation(reply.answer.clone()),
        };
        let observation = Observation {
            view: view.clone(),
            response,
            weak: reply.is_ambiguous_refusal(),
            stderr: reply.stderr.clone(),
            previous_request: reply.previous_request.clone(),
            nondeterminism: serve_mode_failure(&reply),
        };
        (observation, reply)
    }

    /// Calls `work` with each number below `count`, in one thread per job. A worker stops when `work` returns false.
    pub(super) fn run_in_parallel(&self, count: usize, work: impl Fn(usize, usize) -> bool + Sync) {
        let (jobs, next) = (self.plan.jobs, AtomicUsize::new(0));
        // A serving process gets the same files in the same order in every run, so that leaked state is reproducible.
        let fixed = self.plan.repeat == Repeat::FailuresAndSample;
        run_on_threads(jobs, &|worker| {
            let mut mine = (worker..count).step_by(jobs);
            let any = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&place| place < count);
            while let Some(place) = if fixed { mine.next() } else { any() } {
                if !work(place, worker) {
                    return;
                }
            }
        });
    }
}

/// Returns true if a call timed out, even if a new process answered afterward.
pub(super) fn is_hang<T>(reply: &Reply<T>) -> bool {
    let mut answers = reply.serve_mode_answer.iter().chain([&reply.answer]);
    answers.any(|answer| matches!(answer, Answer::Hung(_)))
}

/// Returns the failure of a serving process, if a new process then answered within the limits.
pub(super) fn serve_mode_failure<T>(reply: &Reply<T>) -> Option<Nondeterminism> {
    let served = reply.serve_mode_answer.as_ref()?;
    if served.is_same_kind_as(&reply.answer) {
        return None;
    }
    let after = previous_request_text(reply.previous_request.as_ref());
    let (trouble, alone) = (served.describe(), reply.answer.name());
    let says = format!("in serve mode{after}: {trouble}; in a new process it answers ({alone})");
    Some(Nondeterminism {
        in_serve_mode: true,
        message: says,
    })
}

/// Describes the place of a request in its process: after the previous request, or first.
pub(super) fn previous_request_text(before: Option<&String>) -> String {
    match before {
        Some(case) => format!(", after {case}"),
        None => ", as the first request".to_owned(),
    }
}
