//! Asking: a request for a case in a view, and what came of it.
//!
//! The decoder is a closure from request to reply, so that a misreading inside this program and a program outside it are
//! asked, compared and judged in the same way.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::kit::parallel::on_threads;
use crate::protocol::frame::Answer;
use crate::runner::run::{Reply, Request};
use crate::session::observation::{Nondeterminism, Observation, Response};
use crate::session::plan::{Repeat, RunPlan};
use crate::session::tally::Tally;
use crate::suite::cases::{Case, TableSpelling};
use crate::suite::dialect::Right;
use crate::suite::test_case::{Comparison, TestCase};

/// A reply to a request for a case.
pub type ReplyTo<C> = Reply<<C as TestCase>::Output>;

/// A decoder: what it replies to a request; the number says which of the workers asks.
pub type Ask<'a, C = Case> =
    dyn Fn(&Request<'_, <C as TestCase>::View>, usize) -> ReplyTo<C> + Sync + 'a;

/// Is told how many of how many are done.
pub type Counting<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// What came, and what the reference shows if it shows something: what came before a change of all pictures.
pub type Undoing<T> = dyn Fn(&T, Option<&T>) -> T + Send + Sync;

/// A change of all pictures of a view that has been said, and is undone before they are compared.
#[derive(Clone)]
pub struct Undo<C: TestCase> {
    /// The view.
    pub view: &'static str,
    /// How it is undone.
    pub undo: Arc<Undoing<C::Output>>,
}

/// The decoder, and a count of what it was asked.
pub(super) struct Asking<'a, C: TestCase> {
    pub ask: &'a Ask<'a, C>,
    pub tally: Tally<'a>,
    pub undo: Vec<Undo<C>>,
}

impl<C: TestCase> Asking<'_, C> {
    /// Whether the run should not go on.
    pub fn is_over(&self) -> bool {
        self.tally.why_over().is_some()
    }

    /// Asks for `case` in `view` and compares the answer with what is expected. `worker` numbers those who ask at once.
    pub fn observe(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
        worker: usize,
    ) -> (Observation<C>, ReplyTo<C>) {
        let timeout_factor = self.tally.call();
        let (observation, reply) = self.request(case, view, table, worker, timeout_factor, false);
        if is_violation(&reply) {
            self.tally.count_violation();
        }
        (observation, reply)
    }

    /// Asks a process of its own, without counting.
    pub fn observe_alone(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
        worker: usize,
    ) -> Observation<C> {
        self.request(case, view, table, worker, 1, true).0
    }

    /// The change that is undone in a view, if there is one.
    fn undo_of(&self, view: &C::View) -> Option<&Undo<C>> {
        let mut undo = self.undo.iter();
        undo.find(|undo| undo.view == C::view_name(view))
    }

    fn request(
        &self,
        case: &C,
        view: &C::View,
        table: TableSpelling,
        worker: usize,
        timeout_factor: u32,
        alone: bool,
    ) -> (Observation<C>, ReplyTo<C>) {
        let built = case.made(table);
        let request = Request {
            name: case.id(),
            view,
            file: C::file(&built),
            largest_frame: case.largest_answer(&built),
            timeout_factor,
            alone,
        };
        let reply = (self.ask)(&request, worker);
        let response = match &reply.answer {
            Answer::Rejected => Response::Rejected,
            Answer::Unsupported => Response::Unsupported,
            Answer::Decoded(output) => match self.undo_of(view) {
                None => picture(case.compare(&built, view, output), output),
                Some(undo) => {
                    let right = case.expected_output(view);
                    let output = (undo.undo)(output, right.as_ref());
                    picture(case.compare(&built, view, &output), &output)
                }
            },
            _ => Response::Violation(reply.answer.clone()),
        };
        let observation = Observation {
            view: view.clone(),
            response,
            weak: reply.is_weak(),
            stderr: reply.stderr.clone(),
            after: reply.after.clone(),
            nondeterminism: trouble_of_serving(&reply),
        };
        (observation, reply)
    }
}

fn picture<C: TestCase>(comparison: Comparison<C>, output: &C::Output) -> Response<C> {
    let Comparison {
        right,
        difference,
        allowance,
    } = comparison;
    let differs = right != Right::Anyway(true) && difference.is_some();
    Response::Picture {
        right,
        difference,
        allowance,
        frame: differs.then(|| output.clone()),
    }
}

/// Returns true if a call ended in neither a frame nor a refusal.
pub(super) fn is_violation<T>(reply: &Reply<T>) -> bool {
    reply.answer.violation().is_some() || reply.served.is_some()
}

/// Returns true if a call did not end within its time, whether or not a process of its own answered then.
pub(super) fn is_hang<T>(reply: &Reply<T>) -> bool {
    let mut answers = reply.served.iter().chain([&reply.answer]);
    answers.any(|answer| matches!(answer, Answer::Hung(_)))
}

/// What a serving process did instead of answering, where another answered otherwise than by reaching a limit, too.
pub(super) fn trouble_of_serving<T>(reply: &Reply<T>) -> Option<Nondeterminism> {
    let served = reply.served.as_ref()?;
    if served.is_of_kind(&reply.answer) {
        return None;
    }
    let says = format!(
        "in serve mode{}: {}: {}; asked alone it answers ({})",
        after(reply.after.as_ref()),
        served.name(),
        served.violation().unwrap_or_default(),
        reply.answer.name()
    );
    Some(Nondeterminism { served: true, says })
}

/// Which request the process answered before, in words.
pub(super) fn after(before: Option<&String>) -> String {
    match before {
        Some(case) => format!(", after {case}"),
        None => ", as the first request".to_owned(),
    }
}

/// Does `count` things, as many at a time as there are jobs; a worker stops where one says that it should not go on.
pub(super) fn side_by_side<C: TestCase>(
    plan: &RunPlan<C>,
    count: usize,
    one: impl Fn(usize, usize) -> bool + Sync,
) {
    let next = AtomicUsize::new(0);
    // A serving process gets the same files in the same order in every run, so that what it carries over is found again.
    let fixed = plan.repeat == Repeat::FailuresAndSample;
    on_threads(plan.jobs, &|worker| {
        let mut mine = (worker..count).step_by(plan.jobs);
        let any = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&place| place < count);
        while let Some(place) = if fixed { mine.next() } else { any() } {
            if !one(place, worker) {
                break;
            }
        }
    });
}
