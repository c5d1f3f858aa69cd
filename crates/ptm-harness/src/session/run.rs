//! The requests of a run and their results: requests every case once, repeats failed cases, and computes verdicts.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use crate::session::asking::CountCallback;
pub use crate::session::asking::Session;
use crate::session::contact::{Contact, FirstFile};
use crate::session::remark::Remark;
use crate::session::tally::TimeoutWatch;
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::protocol::request::AttemptKind;
use ptm_suite::test_case::TestCase;
use ptm_suite::verdicts::judge::{Judgment, judge};
use ptm_suite::verdicts::observation::{Observation, Response};
use ptm_suite::verdicts::scores::{Fraction, Scores};
use ptm_suite::verdicts::{offer::Offer, outcome::Outcome};

/// The results of a run.
#[derive(Clone, Debug)]
pub struct Run<C: TestCase = Case> {
    /// Observations, one slot per case of the suite.
    pub observations: Observations<C>,
    /// The verdicts.
    pub judgment: Judgment<C::Feature>,
    /// The decoder's replies to the first files.
    pub first: Vec<FirstFile<C>>,
    /// The views and the kinds of cases that the decoder offers.
    pub offer: Offer<C>,
    /// The spelling of tables that are sent to the decoder.
    pub table: TableSpelling,
    /// Remarks on the run as a whole.
    pub remarks: Vec<Remark>,
    /// Number of requests, not counting repeated ones.
    pub request_count: usize,
    /// Number of requests that ended in neither a frame nor a refusal.
    pub violations: usize,
    /// The reason why the run ended before all cases were requested, if it did.
    pub ended_early: Option<String>,
    /// The reason why the program is not a decoder, if it is not one.
    pub not_a_decoder: Option<String>,
    /// Flag that is set when the user ends the search for causes.
    pub stop: Arc<AtomicBool>,
    /// Units of work done so far by the search for causes, at most [`MAX_WORK`](crate::diagnose::MAX_WORK).
    pub work: Arc<AtomicUsize>,
}

/// Observations, one slot per case of the suite; `None` for cases that were not requested.
pub type Observations<C> = Vec<Option<Observation<C>>>;

/// A callback for each finished case. It receives the case, its observation, the number of finished cases, and the total.
pub type Progress<'a, C = Case> = dyn Fn(&C, &Observation<C>, usize, usize) + Sync + 'a;

impl<C: TestCase> Session<'_, C> {
    /// Returns the indices of the cases to request in two lists: the prioritized cases, and the others. The lists contain
    /// selected cases and their twins, but no case that is withheld or whose views are not offered. Both lists are empty if
    /// nothing can be requested.
    pub(crate) fn agenda(&self, contact: &Contact<C>) -> (Vec<usize>, Vec<usize>) {
        let (suite, plan) = (self.suite, self.plan);
        let withheld = plan.withheld_in(suite, contact.table);
        let (mut wanted, mut soonest) = (plan.selected.clone(), plan.prioritized.clone());
        soonest.resize(suite.cases.len(), false);
        for (i, twins) in C::twins(&suite.cases).into_iter().enumerate() {
            if let (true, Some(&twin)) = (plan.selected[i], twins.first()) {
                wanted[twin] = true;
                soonest[twin] |= soonest[i];
            }
        }
        let is_offered = |i: usize| contact.offer.chosen_view(&suite.cases[i]).is_some();
        let is_asked = |&i: &usize| wanted[i] && withheld[i].is_none() && is_offered(i);
        let cases = if contact.is_ready() {
            suite.cases.len()
        } else {
            0
        };
        (0..cases).filter(is_asked).partition(|&i| soonest[i])
    }

    /// Requests these cases once, each in the first of its views that the decoder offers.
    ///
    /// After three consecutive legal files that exceed the time limit, one of them after the other is requested alone until one is
    /// answered. If none is, the run ends, and the results of later cases are dropped, so the number of jobs does not affect the
    /// report.
    pub fn request_cases(
        &self,
        contact: &Contact<C>,
        case_indices: &[usize],
        observations: &mut [Option<Observation<C>>],
        progress: &Progress<C>,
    ) {
        let is_legal = |at: usize| self.suite.cases[case_indices[at]].expect() == Expect::Decode;
        let mut first = 0;
        while !self.is_over() {
            let legal = (first..case_indices.len()).filter(|&at| is_legal(at));
            let watch = TimeoutWatch::new(legal.collect());
            self.request_watched(contact, case_indices, observations, progress, &watch);
            let Some(slow) = watch.consecutive().filter(|_| !self.is_interrupted()) else {
                return;
            };
            let last = *slow.last().expect("the list is not empty");
            let slow: Vec<usize> = slow.iter().map(|&at| case_indices[at]).collect();
            let mut slow_files = slow.iter();
            if slow_files.any(|&i| {
                let case = &self.suite.cases[i];
                self.repeat_alone(contact.table, &mut observations[i], case) == Some(true)
            }) {
                first = last + 1;
                continue;
            }
            if self.is_interrupted() {
                return;
            }
            let limits = slow
                .iter()
                .filter_map(|&i| observations[i].as_ref()?.response.time_limit());
            let limit = limits.min().expect("the files exceeded a time limit");
            let _ = self.tally.exceeded_limit.set(limit);
            for &i in &case_indices[last + 1..] {
                self.drop_observation(&mut observations[i]);
            }
        }
    }

    /// Requests those of the cases that have no observation yet, until `watch` finds consecutive files that exceed the time limit.
    fn request_watched(
        &self,
        contact: &Contact<C>,
        case_indices: &[usize],
        observations: &mut [Option<Observation<C>>],
        progress: &Progress<C>,
        watch: &TimeoutWatch,
    ) {
        let cases = &self.suite.cases;
        let is_done = |i: &&usize| observations[**i].is_some();
        let done = case_indices.iter().filter(is_done).count();
        let state = Mutex::new((observations, done));
        let lock = || state.lock().expect("no worker panics");
        self.run_in_parallel(case_indices.len(), |at, worker| {
            let i = case_indices[at];
            let Some(view) = contact.offer.chosen_view(&cases[i]) else {
                return true;
            };
            let seen = lock().0[i].as_ref().map(Observation::is_open);
            if let Some(timed_out) = seen {
                watch.record(at, timed_out);
                return true;
            }
            if watch.is_after(at) || self.is_interrupted() {
                return false;
            }
            let usual = AttemptKind::Usual;
            let (observation, _) = self.observe(&cases[i], view, contact.table, worker, usual);
            if self.is_interrupted() {
                self.drop_observation(&mut Some(observation));
                return false;
            }
            watch.record(at, observation.is_open());
            let (observations, done) = &mut *lock();
            *done += 1;
            progress(&cases[i], &observation, *done, case_indices.len());
            observations[i] = Some(observation);
            true
        });
    }

    /// Repeats an open request alone, with a higher time limit. Returns true if it was answered, false if it exceeded this limit,
    /// too, and `None` if it was not repeated.
    fn repeat_alone(
        &self,
        table: TableSpelling,
        observation: &mut Option<Observation<C>>,
        case: &C,
    ) -> Option<bool> {
        let open = observation.as_ref().filter(|seen| seen.is_open())?;
        let (repeated, _) = self.observe_alone(case, &open.view, table)?;
        let is_answered = repeated.response.time_limit().is_none();
        *observation = Some(repeated);
        Some(is_answered)
    }

    /// Repeats all requests that exceeded the time limit, one after the other: first those for legal files. If the user ends the
    /// run, drops those that are still open, because nothing is known about them.
    fn repeat_open_requests(
        &self,
        table: TableSpelling,
        observations: &mut [Option<Observation<C>>],
        progress: &CountCallback,
    ) {
        let cases = &self.suite.cases;
        let is_open = |&i: &usize| observations[i].as_ref().is_some_and(Observation::is_open);
        let mut open: Vec<usize> = (0..cases.len()).filter(is_open).collect();
        open.sort_by_key(|&i| cases[i].expect() != Expect::Decode);
        for (done, &i) in open.iter().enumerate() {
            let repeated = self.repeat_alone(table, &mut observations[i], &cases[i]);
            if repeated.is_none() {
                break;
            }
            progress(done + 1, open.len());
        }
        if self.is_interrupted() {
            for i in open {
                if observations[i].as_ref().is_some_and(Observation::is_open) {
                    self.drop_observation(&mut observations[i]);
                }
            }
        }
    }

    /// Removes an observation and its request from the counts of this run.
    fn drop_observation(&self, observation: &mut Option<Observation<C>>) {
        let Some(observation) = observation.take() else {
            return;
        };
        // True if the call ended in neither a frame nor a refusal, or a serving process did not answer.
        let is_violation = matches!(observation.response, Response::Violation(_))
            || observation.nondeterminism.is_some();
        self.tally.calls.fetch_sub(1, Ordering::Relaxed);
        (self.tally.violations).fetch_sub(is_violation.into(), Ordering::Relaxed);
    }

    /// Returns the run that results if only these cases are selected. Nothing is repeated.
    #[must_use]
    pub fn partial_run(
        &self,
        contact: &Contact<C>,
        indices: &[usize],
        observations: &[Option<Observation<C>>],
    ) -> Run<C> {
        let selected = &self.plan.selected;
        // Open requests will be repeated, so they have no verdict yet.
        let is_closed = |seen: &Observation<C>| !seen.is_open();
        let is_seen = |i: usize| {
            selected[i] && indices.contains(&i) && observations[i].as_ref().is_some_and(is_closed)
        };
        let selected: Vec<bool> = (0..selected.len()).map(is_seen).collect();
        let judgment = judge(self.suite, &selected, observations, &contact.offer);
        self.run(contact.clone(), observations.to_vec(), judgment)
    }

    /// Repeats the requests that exceeded the time limit, judges the observations, repeats failures, and judges again if a
    /// response differed. `progress` is called after each repetition with the number of finished repetitions and the total.
    #[must_use]
    pub fn verdicts(
        self,
        contact: Contact<C>,
        mut observations: Observations<C>,
        progress: &CountCallback,
    ) -> Run<C> {
        let (suite, table) = (self.suite, contact.table);
        let nothing = vec![false; suite.cases.len()];
        self.repeat_open_requests(table, &mut observations, progress);
        let end_reason = self.end_reason();
        let (selected, ended_early) = match contact.not_a_decoder {
            Some(_) => (&nothing, end_reason),
            None => (
                &self.plan.selected,
                contact.end_reason.clone().or(end_reason),
            ),
        };
        let mut judgment = judge(suite, selected, &observations, &contact.offer);
        if ended_early.is_none() && self.repeat(table, &mut observations, &judgment, progress) {
            judgment = judge(suite, selected, &observations, &contact.offer);
        }
        // The run may be interrupted while cases are repeated.
        let ended_early = ended_early.or(self.end_reason());
        let reason = || all_unsupported_reason(suite, &observations);
        let not_a_decoder = contact.not_a_decoder.clone().or_else(reason);
        let is_open = |seen: &&Observation<C>| seen.is_open();
        let open = observations.iter().flatten().filter(is_open).count();
        let mut run = self.run(contact, observations, judgment);
        run.remarks.extend(self.tally.remarks(open));
        let mut run = Run {
            ended_early,
            not_a_decoder,
            ..run
        };
        run.explain_skipped_cases(suite, &self.plan.withheld_in(suite, table));
        run.report_early_end();
        run
    }

    fn run(
        &self,
        contact: Contact<C>,
        observations: Observations<C>,
        judgment: Judgment<C::Feature>,
    ) -> Run<C> {
        Run {
            observations,
            judgment,
            first: contact.first,
            offer: contact.offer,
            table: contact.table,
            remarks: contact.remarks,
            request_count: self.tally.calls.load(Ordering::Relaxed),
            violations: self.tally.violations.load(Ordering::Relaxed),
            ended_early: None,
            not_a_decoder: None,
            stop: Arc::clone(&self.plan.stop),
            work: Arc::default(),
        }
    }
}

/// Returns the reason why a program that exited with 69 for every must-accept file is not a decoder.
fn all_unsupported_reason<C: TestCase>(
    suite: &Suite<C>,
    observations: &[Option<Observation<C>>],
) -> Option<String> {
    let cases = suite.cases.iter().zip(observations);
    let legal = cases.filter(|(case, _)| case.expect() == Expect::Decode);
    let mut asked = legal.filter_map(|(_, seen)| seen.as_ref()).peekable();
    let unsupported = |seen: &Observation<C>| matches!(seen.response, Response::Unsupported);
    (asked.peek().is_some() && asked.all(unsupported))
        .then(|| "it exits with 69 (unsupported) on every legal file".to_owned())
}

impl<C: TestCase> Run<C> {
    /// Explains why cases were not requested: they were withheld, or the run ended early.
    fn explain_skipped_cases(&mut self, suite: &Suite<C>, withheld: &[Option<String>]) {
        let judged = suite.cases.iter().zip(&mut self.judgment.cases);
        for (((case, judged), observation), why) in judged.zip(&self.observations).zip(withheld) {
            let Some(judged) = judged else { continue };
            if let Some(why) = why {
                judged.outcome = Outcome::NotJudged;
                judged.message.clone_from(why);
            } else if observation.is_none() && self.offer.chosen_view(case).is_some() {
                judged.outcome = Outcome::NotRun;
                judged.message = self.ended_early.clone().unwrap_or_default();
            }
        }
    }

    /// Reports why the run ended early: in a remark or, if the program is not a decoder, in the reason for that verdict.
    fn report_early_end(&mut self) {
        let Some(why) = &self.ended_early else { return };
        if let Some(reason) = &mut self.not_a_decoder {
            *reason = format!("{reason}\n{why}");
            return;
        }
        let not_run = self.judgment.with_outcome(Outcome::NotRun);
        let asked = self.request_count;
        let not_run = format!("{} cases were not run", not_run.count());
        let says = format!("{why}; {not_run}; {asked} requests were sent");
        self.remarks.push(Remark::failure(says));
    }

    /// Returns the scores of this run.
    #[must_use]
    pub fn scores(&self, suite: &Suite<C>) -> Scores {
        let count = |outcome: Outcome| self.judgment.with_outcome(outcome).count();
        let mut features: BTreeSet<C::Feature> = BTreeSet::new();
        for (case, _) in (suite.cases.iter().zip(&self.judgment.cases)).filter(|of| of.1.is_some())
        {
            features.extend(case.views().iter().flat_map(|view| case.features(view)));
        }
        let passed = count(Outcome::Pass);
        let decoded = self.judgment.decoded.intersection(&features).count();
        let fraction = |part, whole| Fraction { part, whole };
        Scores {
            correctness: fraction(passed, passed + count(Outcome::Fail)),
            breadth: fraction(decoded, features.len()),
            robustness: fraction(self.request_count - self.violations, self.request_count),
        }
    }

    /// Returns the exit status of `check`: 0, 1 or 3.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        self.status(self.judgment.with_outcome(Outcome::Fail).next().is_some())
    }

    /// Returns the exit status of a run in which some failures may be ignored. `failed` is true if the run has a failure that is
    /// not ignored.
    #[must_use]
    pub fn status(&self, failed: bool) -> u8 {
        if self.not_a_decoder.is_some() {
            return 3;
        }
        let is_image = |seen: &Observation<C>| matches!(seen.response, Response::Image { .. });
        u8::from(
            failed
                || self.ended_early.is_some()
                || self.remarks.iter().any(|remark| remark.failure)
                || !self.observations.iter().flatten().any(is_image),
        )
    }
}
