//! What an observer learns during a check.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use crate::pipeline::checkable::FoundCauses;
use crate::pipeline::times::Times;
use crate::report::document::Report;

/// A stage of a check, in order. Stages without work may be missing.
#[derive(Clone, Debug)]
pub enum Stage {
    /// First contact.
    FirstContact,
    /// Requests for a few files of each feature.
    Sample,
    /// Requests for the prioritized cases and for each clause.
    PrioritizedCases,
    /// Requests for all other cases.
    Cases,
    /// Repeated requests.
    Repeats,
    /// The report with all verdicts is made and written.
    Report,
    /// The search for causes. The counter contains the units of work done so far, at most
    /// [`MAX_WORK`](crate::diagnose::MAX_WORK).
    Search(Arc<AtomicUsize>),
}

/// The requests of a long run that are still to be sent, beginning with prioritized cases and each clause.
#[derive(Clone, Copy, Debug)]
pub struct Agenda {
    /// Number of requests.
    pub total: usize,
    /// Number of requests for prioritized cases and each clause.
    pub prioritized: usize,
    /// Time per request during first contact.
    pub pace: Duration,
}

impl Agenda {
    /// Returns the estimated time for some requests.
    #[must_use]
    pub fn time(&self, requests: usize) -> Duration {
        self.pace.mul_f64(requests as f64)
    }
}

/// A finished case.
pub struct FinishedCase<'a> {
    /// Id of the case.
    pub id: &'a str,
    /// The requested view.
    pub view: &'a dyn Display,
    /// Name of the answer.
    pub answer: &'static str,
    /// True if the answer is wrong whatever the answers to other cases are.
    pub is_wrong: bool,
}

/// The verdicts on the first cases of a run, which are chosen from all clauses. Other cases may change them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FirstVerdicts {
    /// Number of cases that were judged.
    pub judged: usize,
    /// Number of cases that failed.
    pub failed: usize,
    /// For each clause that a failing case tests, the numbers of failing and of judged cases that test it.
    pub failing_clauses: BTreeMap<String, (usize, usize)>,
}

/// Observer of a check. Every method is called when something has happened, and does nothing by default.
/// [`Observer::case_finished`] and [`Observer::request_repeated`] are called by several threads.
pub trait Observer: Sync {
    /// A stage begins.
    fn stage_began(&self, _stage: &Stage) {}

    /// First contact has been made. The decoder offers `views`. In the views in `undone`, a transform that all images have in
    /// common is undone.
    fn contact_made(&self, _views: &[&'static str], _undone: &[&'static str]) {}

    /// The number of requests of a long run is known.
    fn agenda_known(&self, _agenda: &Agenda) {}

    /// A case is finished: `done` of `total`.
    fn case_finished(&self, _case: &FinishedCase, _done: usize, _total: usize) {}

    /// The first cases have been judged.
    fn first_verdicts(&self, _first: &FirstVerdicts) {}

    /// All requests have been sent, and took these times.
    fn times_measured(&self, _times: &Times) {}

    /// A request was repeated: `done` of `total`.
    fn request_repeated(&self, _done: usize, _total: usize) {}

    /// The report with all verdicts, but without causes, is ready.
    ///
    /// # Errors
    /// An error ends the check.
    fn verdicts_reported(&self, _report: &Report) -> Result<(), String> {
        Ok(())
    }

    /// The search for causes has ended.
    fn causes_found(&self, _found: &FoundCauses) {}
}

/// Observes nothing.
impl Observer for () {}
