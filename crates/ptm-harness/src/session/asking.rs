//! Requests for a case in a view, and their results.
//!
//! The decoder is a closure from request to reply, so simulated misreadings and external programs are judged in the same way.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::session::plan::RunPlan;
use crate::session::tally::Tally;
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::test_case::TestCase;
use ptm_suite::verdicts::observation::{Nondeterminism, Observation, ObservationOf, Response};

/// A reply to a request for a case.
pub type ReplyTo<C> = Reply<<C as TestCase>::Output>;

/// A decoder: a function from requests to replies. The number identifies the worker that sends the request.
pub type DecoderFn<'a, C = Case> =
    dyn Fn(&Request<'_, <C as TestCase>::View>, usize) -> ReplyTo<C> + Sync + 'a;

/// A decoder that is sent several requests at once. Returns the replies to the first of them. The caller must send the others
/// again, one by one.
pub type PipelinedFn<'a, C = Case> =
    dyn Fn(&[Request<'_, <C as TestCase>::View>], usize) -> Vec<ReplyTo<C>> + Sync + 'a;

/// Maximum number of requests that are sent at once.
const MAX_PIPELINED_REQUESTS: usize = 8;

/// Maximum total size in bytes of the files and frames of the requests that are sent at once.
const MAX_PIPELINED_BYTES: usize = 1 << 20;

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
    /// Sends several requests at once, if the decoder can be sent more than one.
    pub ask_pipelined: Option<&'a PipelinedFn<'a, C>>,
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
            ask_pipelined: None,
            undone_transforms: Vec::new(),
        }
    }

    /// Returns the maximum number of requests that are sent at once.
    pub(super) fn pipeline_depth(&self) -> usize {
        self.ask_pipelined.map_or(1, |_| MAX_PIPELINED_REQUESTS)
    }

    /// Returns true if no more requests will be sent.
    pub(crate) fn is_over(&self) -> bool {
        self.end_reason().is_some()
    }

    pub(super) fn end_reason(&self) -> Option<String> {
        self.tally.end_reason(self.plan)
    }

    /// Returns true if the user has ended the run.
    pub(super) fn is_interrupted(&self) -> bool {
        self.plan.is_interrupted()
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
        attempt: AttemptKind,
    ) -> (ObservationOf<C>, ReplyTo<C>) {
        let (observation, reply) = self.request(case, view, table, worker, attempt);
        self.tally.count(&reply, attempt);
        (observation, reply)
    }

    /// Requests several cases at once, if that is possible. Returns the observations of the first of them. The others must be
    /// requested again, one by one.
    pub(super) fn observe_pipelined(
        &self,
        cases: &[(&C, &C::View)],
        table: TableSpelling,
        worker: usize,
    ) -> Vec<ObservationOf<C>> {
        let Some(ask_pipelined) = self.ask_pipelined else {
            return Vec::new();
        };
        let (mut files, mut size, usual) = (Vec::new(), 0, AttemptKind::Usual);
        for (case, _) in cases {
            let built = case.make(table);
            size += C::file(&built).len() + case.max_output_bytes(&built);
            if size > MAX_PIPELINED_BYTES {
                break;
            }
            files.push(built);
        }
        let requests: Vec<_> = cases
            .iter()
            .zip(&files)
            .map(|((case, view), built)| to_request(*case, view, built, usual))
            .collect();
        if requests.len() < 2 {
            return Vec::new();
        }
        let mut observations = Vec::new();
        for (i, reply) in ask_pipelined(&requests, worker).iter().enumerate() {
            self.tally.count(reply, usual);
            let (case, view) = cases[i];
            observations.push(self.observation(case, view, &files[i], usual, reply));
        }
        observations
    }

    /// Requests a file that has exceeded the time limit once more, alone and with a higher limit. Returns `None` if the run was
    /// interrupted, or if too many requests have exceeded the higher limit. The caller must not send other requests in parallel.
    pub(super) fn observe_alone(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
    ) -> Option<(ObservationOf<C>, ReplyTo<C>)> {
        if !self.plan.may_ask_alone() {
            return None;
        }
        let (observation, reply) = self.request(case, view, table, 0, AttemptKind::Alone);
        if self.is_interrupted() {
            return None;
        }
        self.tally.count_alone(&reply, case.id());
        Some((observation, reply))
    }

    /// Requests `case` while no other request is in progress. If it exceeds the time limit, requests it once more.
    pub(super) fn observe_patiently(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
    ) -> ObservationOf<C> {
        let (observation, _) = self.observe(case, view, table, 0, AttemptKind::Usual);
        match observation
            .is_open()
            .then(|| self.observe_alone(case, view, table))
        {
            Some(Some((patient, _))) => patient,
            _ => observation,
        }
    }

    /// Sends a request without counting it.
    pub(super) fn request(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
        worker: usize,
        attempt: AttemptKind,
    ) -> (ObservationOf<C>, ReplyTo<C>) {
        let built = case.make(table);
        let reply = (self.ask)(&to_request(case, view, &built, attempt), worker);
        if attempt == AttemptKind::Alone && reply.is_timeout() {
            self.plan.unanswered.fetch_add(1, Ordering::Relaxed);
        }
        let observation = self.observation(case, view, &built, attempt, &reply);
        (observation, reply)
    }

    /// Compares a reply with the expected one.
    fn observation(
        &self,
        case: &C,
        view: &C::View,
        built: &C::Built,
        attempt: AttemptKind,
        reply: &ReplyTo<C>,
    ) -> ObservationOf<C> {
        let mut undone = self.undone_transforms.iter();
        let answer = match (
            &reply.answer,
            undone.find(|undone| undone.view == C::view_name(view)),
        ) {
            (Answer::Decoded(output), Some(transform)) => {
                let expected = case.expected_output(view);
                &Answer::Decoded((transform.undo)(output, expected.as_ref()))
            }
            (answer, _) => answer,
        };
        let response = Response::new(case, built, view, answer);
        Observation {
            view: view.clone(),
            response,
            weak: reply.is_ambiguous_refusal(),
            stderr: reply.stderr.clone(),
            attempt,
            previous_request: reply.previous_request.clone(),
            nondeterminism: serve_mode_failure(reply),
        }
    }
}

/// Returns the request for a file of a case.
fn to_request<'a, C: TestCase>(
    case: &'a C,
    view: &'a C::View,
    built: &'a C::Built,
    attempt: AttemptKind,
) -> Request<'a, C::View> {
    Request {
        name: case.id(),
        view,
        file: C::file(built),
        max_frame_bytes: case.max_output_bytes(built),
        attempt,
    }
}

/// Returns the failure of a serving process, if a new process then answered within the limits. An exceeded time limit is not a
/// failure of serve mode.
pub(super) fn serve_mode_failure<T>(reply: &Reply<T>) -> Option<Nondeterminism> {
    let served = reply.serve_mode_answer.as_ref()?;
    if served.is_same_kind_as(&reply.answer) || matches!(served, Answer::TimedOut(_)) {
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
        Some(case) => format!(" (the previous request was {case})"),
        None => " (it was the first request)".to_owned(),
    }
}
