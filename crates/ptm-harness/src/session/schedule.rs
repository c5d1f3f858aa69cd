//! The order of requests: in parallel with the usual time limit, alone with a higher one, and again in new processes.
//!
//! Cases are numbers here, so that this order does not depend on what is requested.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;
use std::sync::Mutex;

use crate::session::asking::{CountCallback, previous_request_text};
use crate::session::plan::{Repeat, RunPlan};
use crate::session::tally::{Tally, TimeoutWatch};
use ptm_suite::test_case::Output;
use ptm_suite::verdicts::observation::{Nondeterminism, Observation, Response};

/// Maximum number of failures of each kind that are initially repeated.
const MAX_REPEATED_PER_KIND: usize = 8;

/// Number of repetitions that are always allowed, even if they exceed a tenth of the run.
const MIN_REPEATED: usize = 24;

/// Observations, one slot per case of the suite; `None` for cases that were not requested.
type Slots<V, T, D> = [Option<Observation<V, T, D>>];

/// A callback for each finished case. It receives the number of the case, its observation, the number of finished cases, and the total.
pub(super) type Finished<'a, V, T, D> =
    dyn Fn(usize, &Observation<V, T, D>, usize, usize) + Sync + 'a;

/// Sends requests for cases, which are numbers, and keeps count of them.
pub(super) trait Requests<V, T, D>: Sync
where
    V: Clone + Send,
    T: Output,
    D: Clone + Display + Send,
{
    fn plan(&self) -> &RunPlan;
    fn tally(&self) -> &Tally;
    /// Returns true if the file of a case must be decoded.
    fn is_legal(&self, case: usize) -> bool;
    /// Requests a case.
    fn observe(&self, case: usize, worker: usize) -> Observation<V, T, D>;
    /// Requests a case once more, alone and with a higher time limit, unless it may not be repeated.
    fn observe_alone(&self, case: usize, view: &V) -> Option<Observation<V, T, D>>;
    /// Requests a case once more in a new process. The request is not counted.
    fn observe_again(&self, case: usize, view: &V, worker: usize) -> Observation<V, T, D>;

    /// Returns the maximum number of cases that are requested at once.
    fn pipeline_depth(&self) -> usize {
        1
    }

    /// Requests several cases at once. Returns the observations of the first of them, perhaps of none.
    fn observe_pipelined(&self, _cases: &[usize], _worker: usize) -> Vec<Observation<V, T, D>> {
        Vec::new()
    }

    /// Requests these cases once.
    ///
    /// After three consecutive legal files that exceed the time limit, one of them after the other is requested alone until one is
    /// answered. If none is, the run ends, and the results of later cases are dropped, so the number of jobs does not affect the
    /// report.
    fn request_all(
        &self,
        cases: &[usize],
        observations: &mut Slots<V, T, D>,
        finished: &Finished<V, T, D>,
    ) {
        let (plan, tally) = (self.plan(), self.tally());
        let mut first = 0;
        while tally.end_reason(plan).is_none() {
            let legal = (first..cases.len()).filter(|&at| self.is_legal(cases[at]));
            let watch = TimeoutWatch::new(legal.collect());
            self.request_watched(cases, observations, finished, &watch);
            let Some(slow) = watch.consecutive().filter(|_| !plan.is_interrupted()) else {
                return;
            };
            let last = *slow.last().expect("the list is not empty");
            let mut slow_cases = slow.iter().map(|&at| cases[at]);
            if slow_cases.any(|case| self.repeat_alone(case, &mut observations[case]) == Some(true))
            {
                first = last + 1;
                continue;
            }
            if plan.is_interrupted() {
                return;
            }
            let limits = slow.iter().filter_map(|&at| {
                let observation = observations[cases[at]].as_ref()?;
                observation.response.time_limit()
            });
            let limit = limits.min().expect("the files exceeded a time limit");
            let _ = tally.exceeded_limit.set(limit);
            for &case in &cases[last + 1..] {
                self.drop_observation(&mut observations[case]);
            }
        }
    }

    /// Requests those of the cases that have no observation yet, until `watch` finds consecutive files that exceed the time limit.
    fn request_watched(
        &self,
        cases: &[usize],
        observations: &mut Slots<V, T, D>,
        finished: &Finished<V, T, D>,
        watch: &TimeoutWatch,
    ) {
        let plan = self.plan();
        let is_done = |case: &&usize| observations[**case].is_some();
        let done = cases.iter().filter(is_done).count();
        let state = Mutex::new((observations, done));
        let lock = || state.lock().expect("no worker panics");
        plan.run_in_batches(cases.len(), self.pipeline_depth(), |places, worker| {
            let is_new = |at: &&usize| lock().0[cases[**at]].is_none() && !watch.is_after(**at);
            let new: Vec<usize> = places.iter().filter(is_new).map(|&at| cases[at]).collect();
            if plan.is_interrupted() {
                return false;
            }
            let mut pipelined = self.observe_pipelined(&new, worker).into_iter();
            for &at in places {
                let case = cases[at];
                let seen = lock().0[case].as_ref().map(Observation::is_open);
                if let Some(timed_out) = seen {
                    watch.record(at, timed_out);
                    continue;
                }
                let observation = match pipelined.next() {
                    Some(observation) => observation,
                    None if watch.is_after(at) || plan.is_interrupted() => return false,
                    None => self.observe(case, worker),
                };
                if plan.is_interrupted() {
                    for observation in pipelined.chain([observation]) {
                        self.tally().uncount(&observation);
                    }
                    return false;
                }
                watch.record(at, observation.is_open());
                let (observations, done) = &mut *lock();
                *done += 1;
                finished(case, &observation, *done, cases.len());
                observations[case] = Some(observation);
            }
            true
        });
    }

    /// Repeats an open request alone, with a higher time limit. Returns true if it was answered, false if it exceeded this limit,
    /// too, and `None` if it was not repeated.
    fn repeat_alone(
        &self,
        case: usize,
        observation: &mut Option<Observation<V, T, D>>,
    ) -> Option<bool> {
        let open = observation.as_ref().filter(|seen| seen.is_open())?;
        let repeated = self.observe_alone(case, &open.view)?;
        let is_answered = repeated.response.time_limit().is_none();
        *observation = Some(repeated);
        Some(is_answered)
    }

    /// Repeats all requests that exceeded the time limit, one after the other: first those for legal files. If the user ends the
    /// run, drops those that are still open, because nothing is known about them.
    fn repeat_open(&self, observations: &mut Slots<V, T, D>, progress: &CountCallback) {
        let is_open = |&case: &usize| {
            observations[case]
                .as_ref()
                .is_some_and(Observation::is_open)
        };
        let mut open: Vec<usize> = (0..observations.len()).filter(is_open).collect();
        open.sort_by_key(|&case| !self.is_legal(case));
        for (done, &case) in open.iter().enumerate() {
            if self.repeat_alone(case, &mut observations[case]).is_none() {
                break;
            }
            progress(done + 1, open.len());
        }
        if self.plan().is_interrupted() {
            for case in open {
                if observations[case]
                    .as_ref()
                    .is_some_and(Observation::is_open)
                {
                    self.drop_observation(&mut observations[case]);
                }
            }
        }
    }

    /// Removes an observation and its request from the counts of this run.
    fn drop_observation(&self, observation: &mut Option<Observation<V, T, D>>) {
        if let Some(observation) = observation.take() {
            self.tally().uncount(&observation);
        }
    }

    /// Repeats cases in new processes. Returns true if a response differed.
    ///
    /// If one failure recurs, similar failures are likely to recur too, so only a few cases of each kind, and usually at most a
    /// tenth of the run, are repeated. If any response differs, the rest are repeated as well, because a varying response says
    /// nothing about the reading.
    fn repeat<K: Ord>(
        &self,
        wanted: Vec<usize>,
        kind: impl Fn(usize) -> K,
        observations: &mut Slots<V, T, D>,
        progress: &CountCallback,
    ) -> bool {
        let limit = (observations.iter().flatten().count() / 10).max(MIN_REPEATED);
        let mut kinds: BTreeMap<(K, &str), Vec<usize>> = BTreeMap::new();
        for &case in &wanted {
            let observation = observations[case].as_ref();
            let response = observation.map_or("", |seen| seen.response.name());
            kinds.entry((kind(case), response)).or_default().push(case);
        }
        // The sample is spread over the suite.
        let spread = kinds.values().flat_map(|cases| {
            let step = cases.len().div_ceil(MAX_REPEATED_PER_KIND).max(1);
            cases.iter().copied().step_by(step)
        });
        let some: BTreeSet<usize> = spread.take(limit).collect();
        let (some, rest): (Vec<usize>, Vec<usize>) =
            wanted.into_iter().partition(|case| some.contains(case));
        let differs = self.repeat_in_new_processes(&some, observations, progress);
        if differs {
            self.repeat_in_new_processes(&rest, observations, progress);
        }
        differs
    }

    /// Repeats each of the cases in a new process. If the response differs, repeats the case once more, to distinguish a decoder
    /// with random responses from one whose serve mode differs. Records differences and returns true if there are any. A repetition
    /// that exceeds the time limit says nothing about the decoder, so it is ignored.
    fn repeat_in_new_processes(
        &self,
        cases: &[usize],
        observations: &mut Slots<V, T, D>,
        progress: &CountCallback,
    ) -> bool {
        let is_serving = self.plan().repeat == Repeat::FailuresAndSample;
        let state = Mutex::new((observations, 0, false));
        let lock = || state.lock().expect("no worker panics");
        self.plan().run_in_parallel(cases.len(), |at, worker| {
            let case = cases[at];
            let first = lock().0[case].clone();
            let mut first = first.expect("only observations are repeated");
            let ask = || {
                let observation = self.observe_again(case, &first.view, worker);
                Some(observation).filter(|seen| seen.response.time_limit().is_none())
            };
            let repeated = ask();
            // A crash, a timeout or truncated output may have happened only to that process.
            let is_no_answer =
                |seen: &Observation<V, T, D>| matches!(seen.response, Response::Violation(_));
            let differing = repeated
                .as_ref()
                .filter(|last| !last.response.is_equivalent(&first.response));
            let is_doubtful = |last| is_serving || is_no_answer(last) != is_no_answer(&first);
            let once_more = differing
                .filter(|last| is_doubtful(last))
                .and_then(|_| ask());
            if self.plan().is_interrupted() {
                return false;
            }
            let differs = differing.is_some();
            if let Some(last) = differing {
                let agrees =
                    |seen: &Observation<V, T, D>| seen.response.is_equivalent(&last.response);
                let in_serve_mode = is_serving && once_more.as_ref().is_some_and(agrees);
                let message = difference(in_serve_mode, &first, last, once_more.as_ref());
                first.nondeterminism = Some(Nondeterminism {
                    in_serve_mode,
                    message,
                });
            }
            // A serving process may not have printed anything about this file yet.
            if let (true, Some(repeated)) = (first.stderr.is_empty(), repeated) {
                first.stderr = repeated.stderr;
            }
            let (observations, done, differ) = &mut *lock();
            observations[case] = Some(first);
            *done += 1;
            *differ |= differs;
            progress(*done, cases.len());
            true
        });
        state.into_inner().expect("no worker panics").2
    }
}

/// Describes the difference between the responses to one request.
fn difference<V, T: Output, D: Display>(
    in_serve_mode: bool,
    first: &Observation<V, T, D>,
    alone: &Observation<V, T, D>,
    once_more: Option<&Observation<V, T, D>>,
) -> String {
    let (one, other) = (first.response.describe(), alone.response.describe());
    let after = previous_request_text(first.previous_request.as_ref());
    match once_more {
        Some(once_more) if once_more.response.is_equivalent(&first.response) => format!(
            "answers with {one}; a repetition in a new process ended with {other}, but the next repetition gave the first response again"
        ),
        _ if in_serve_mode => format!(
            "in serve mode{after}, it answers with {one}; twice in one-shot mode, with {other}: state may leak between files"
        ),
        _ if one == other => format!("two calls returned different responses, each {one}"),
        _ => format!("two calls returned different responses: {one}, then {other}"),
    }
}
