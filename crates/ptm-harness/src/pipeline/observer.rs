//! What an observer learns during a check.

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;

use crate::pipeline::explain::FoundCauses;
use crate::report::document::{LikelyCause, Report};
use crate::report::shards::OtherRemarks;
use crate::session::asking::{ReplyTo, UndoneTransform};
use crate::session::{contact::Contact, run::Run};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::observation::Observation;
use ptm_suite::{cases::Case, test_case::TestCase};

/// A stage of a check, in order. Stages without work may be missing.
#[derive(Clone, Debug)]
pub enum Stage {
    /// First contact.
    FirstContact,
    /// Requests for the prioritized cases.
    PrioritizedCases,
    /// The search for causes among the prioritized cases. The counter is that of [`Stage::Search`].
    FirstSearch(Arc<AtomicUsize>),
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

/// The requests of a long run, which begins with prioritized cases.
#[derive(Clone, Copy, Debug)]
pub struct Agenda {
    /// Number of requests.
    pub total: usize,
    /// Number of requests for prioritized cases.
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

/// Observer of a check. Every method is called when something has happened, and does nothing by default. Methods about requests
/// and cases are called by several threads.
pub trait Observer<C: TestCase = Case>: Sync {
    /// A stage begins.
    fn stage_began(&self, _stage: &Stage) {}

    /// The subject has answered a request.
    fn request_answered(&self, _request: &Request<'_, C::View>, _reply: &ReplyTo<C>) {}

    /// First contact has been made. The transforms are undone in all later images.
    fn contact_made(&self, _contact: &Contact<C>, _undone: &[UndoneTransform<C>]) {}

    /// The number of requests of a long run is known.
    fn agenda_known(&self, _agenda: &Agenda) {}

    /// A case is finished: `done` of `total`.
    fn case_finished(&self, _case: &C, _observation: &Observation<C>, _done: usize, _total: usize) {
    }

    /// The first search has found these causes of failures among the prioritized cases, which other cases may refute.
    fn first_causes_found(&self, _run: &Run<C>, _causes: &[LikelyCause]) {}

    /// A request was repeated: `done` of `total`.
    fn request_repeated(&self, _done: usize, _total: usize) {}

    /// The report with all verdicts, but without causes, is ready. `remarks` are those that are not derived from answers.
    ///
    /// # Errors
    /// An error ends the check.
    fn verdicts_reported(
        &self,
        _run: &Run<C>,
        _report: &Report,
        _remarks: &OtherRemarks,
    ) -> Result<(), String> {
        Ok(())
    }

    /// The search for causes has ended.
    fn causes_found(&self, _found: &FoundCauses) {}
}

/// Observes nothing.
impl<C: TestCase> Observer<C> for () {}
