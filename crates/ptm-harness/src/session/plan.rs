//! The plan of a run: the selected cases and the options.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use ptm_suite::cases::{Expect, Suite, TableSpelling};
use ptm_suite::kit::parallel::run_on_threads;
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::frame::ViewKind;
use ptm_suite::test_case::TestCase;

/// The plan of a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct RunPlan {
    /// One flag per case of the suite: true if the case is judged.
    pub selected: Vec<bool>,
    /// Number of parallel requests, at least 1.
    #[serde(skip)]
    pub jobs: usize,
    /// Requested views; if empty, all views that the decoder offers.
    pub views: Vec<ViewKind>,
    /// The views that the decoder declares; empty if it declares none.
    pub declared_views: Vec<ViewKind>,
    /// The names of the kinds of cases that the decoder declares; empty if it declares none.
    pub declared_kinds: Vec<String>,
    /// The cases to repeat.
    pub repeat: Repeat,
    /// One flag per case of the suite: true if the case is requested before the others. Empty if no case has priority.
    #[serde(skip)]
    pub prioritized: Vec<bool>,
    /// The reasons why cases are not requested, one slot per case; `None` for requested cases. Empty if all are requested.
    pub withheld: Vec<Option<String>>,
    /// True if the answers were produced before the run. If so, there are no first files, and tables have the default spelling.
    pub precomputed: bool,
    /// Number of requests so far that exceeded the higher time limit of [`AttemptKind::Alone`](ptm_suite::protocol::request::AttemptKind::Alone).
    #[serde(skip)]
    pub unanswered: Arc<AtomicUsize>,
    /// Flag that is set when the user ends the run.
    #[serde(skip)]
    pub stop: Arc<AtomicBool>,
    /// Flag that is set at the first failure, if the run ends then.
    #[serde(skip)]
    pub fail_fast: Option<Arc<AtomicBool>>,
}

/// Selection of cases that are repeated in a new process to find nondeterminism.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Repeat {
    /// No cases: the answers come from this process or from files, so no process can be restarted.
    #[default]
    Nothing,
    /// Failures, because the decoder may be nondeterministic.
    Failures,
    /// Failures, and one in [`SAMPLE_INTERVAL`] of the other cases, because a serving process may leak state between files.
    FailuresAndSample,
}

/// Maximum number of requests that may exceed the higher time limit. Then, no more requests are repeated with it.
const MAX_UNANSWERED: usize = 5;

/// Interval at which cases that did not fail are repeated.
pub const SAMPLE_INTERVAL: usize = 100;

impl RunPlan {
    /// Creates a plan that requests every case once, for a decoder that declares no capabilities.
    #[must_use]
    pub fn new<C>(suite: &Suite<C>, jobs: usize) -> RunPlan {
        RunPlan {
            selected: vec![true; suite.cases.len()],
            jobs,
            ..RunPlan::default()
        }
    }

    /// Returns the name that reports use for the mode of the decoder.
    #[must_use]
    pub fn mode(&self) -> &'static str {
        match self.repeat {
            _ if self.precomputed => "outputs",
            Repeat::FailuresAndSample => "serve",
            _ => "one-shot",
        }
    }

    /// Returns true if the user has ended the run, or if it ends because of a failure.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.ends_after_failure()
    }

    /// Returns true if the run ends because of a failure.
    pub(super) fn ends_after_failure(&self) -> bool {
        let failed = self.fail_fast.as_ref();
        failed.is_some_and(|failed| failed.load(Ordering::Relaxed))
    }

    /// Ends the run because of a failure, if it ends after the first one.
    pub(crate) fn note_failure(&self) {
        if let Some(failed) = &self.fail_fast {
            failed.store(true, Ordering::Relaxed);
        }
    }

    /// Returns true if a request that exceeded the time limit may be repeated alone.
    pub(super) fn may_ask_alone(&self) -> bool {
        self.unanswered.load(Ordering::Relaxed) < MAX_UNANSWERED && !self.is_interrupted()
    }

    /// Calls `work` with each number below `count`, in one thread per job. A worker stops when `work` returns false.
    pub(super) fn run_in_parallel(&self, count: usize, work: impl Fn(usize, usize) -> bool + Sync) {
        self.run_in_batches(count, 1, |places, worker| work(places[0], worker));
    }

    /// Calls `work` with all numbers below `count`, up to `size` at a time, in one thread per job. A worker stops when `work`
    /// returns false.
    pub(super) fn run_in_batches(
        &self,
        count: usize,
        size: usize,
        work: impl Fn(&[usize], usize) -> bool + Sync,
    ) {
        let (jobs, next) = (self.jobs, AtomicUsize::new(0));
        // A serving process gets the same files in the same order in every run, so that leaked state is reproducible.
        let fixed = self.repeat == Repeat::FailuresAndSample;
        run_on_threads(jobs, &|worker| {
            let mut mine = (worker..count).step_by(jobs);
            let any = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&place| place < count);
            let place = || if fixed { mine.next() } else { any() };
            let mut places = std::iter::from_fn(place);
            loop {
                let batch: Vec<usize> = places.by_ref().take(size).collect();
                if batch.is_empty() || !work(&batch, worker) {
                    return;
                }
            }
        });
    }

    /// Returns true if neither the user nor the decoder's declaration excludes a view.
    pub(super) fn allows_view(&self, view: &str) -> bool {
        let allows =
            |views: &[ViewKind]| views.is_empty() || views.iter().any(|known| known.name() == view);
        allows(&self.views) && allows(&self.declared_views)
    }

    pub(super) fn is_requested(&self, i: usize) -> bool {
        self.withheld.get(i).is_none_or(Option::is_none)
    }

    /// Returns, for each case of the suite, the reason why it is not requested if tables have this spelling, or `None` if it is
    /// requested.
    pub(super) fn withheld_in<C: TestCase>(
        &self,
        suite: &Suite<C>,
        table: TableSpelling,
    ) -> Vec<Option<String>> {
        let mut withheld = self.withheld.clone();
        withheld.resize(suite.cases.len(), None);
        if self.precomputed && table != TableSpelling::default() {
            for (case, why) in suite.cases.iter().zip(&mut withheld) {
                if case.has_table() && case.expect() != Expect::Spelling {
                    why.get_or_insert_with(|| {
                        "the decoder does not support this file's table spelling".to_owned()
                    });
                }
            }
        }
        withheld
    }

    /// Returns the plan for a decoder with these capabilities.
    #[must_use]
    pub fn with_capabilities(self, capabilities: &Capabilities) -> RunPlan {
        let formats = capabilities.formats.iter().flatten();
        RunPlan {
            declared_views: capabilities.views.clone().unwrap_or_default(),
            declared_kinds: formats.map(|of| of.short_name().to_owned()).collect(),
            ..self
        }
    }
}
