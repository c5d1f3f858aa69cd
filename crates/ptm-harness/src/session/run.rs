//! The requests of a run and their results: requests every case once, repeats failed cases, and computes verdicts.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::session::asking::CountCallback;
pub use crate::session::asking::Session;
use crate::session::contact::{ContactOf, FirstFile};
use crate::session::plan::{Repeat, RunPlan, SAMPLE_INTERVAL};
use crate::session::remark::Remark;
use crate::session::sample::NotAsked;
use crate::session::schedule::Requests;
use crate::session::tally::Tally;
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::compare::Difference;
use ptm_suite::protocol::frame::{Frame, View};
use ptm_suite::protocol::request::AttemptKind;
use ptm_suite::verdicts::judge::{Judgment, judge};
use ptm_suite::verdicts::observation::{Observation, ObservationOf, Response};
use ptm_suite::verdicts::scores::{Fraction, Scores};
use ptm_suite::verdicts::{offer::Offer, outcome::Outcome};
use ptm_suite::{features::Feature, test_case::TestCase};

/// The results of a run of a suite of cases.
pub type RunOf<C> =
    Run<<C as TestCase>::View, <C as TestCase>::Output, <C as TestCase>::Difference>;

/// The results of a run. The parameters are the types of views, outputs, differences and features.
#[derive(Clone, Debug)]
pub struct Run<V = View, T = Frame, D = Difference, F = Feature> {
    /// Observations, one slot per case of the suite; `None` for cases that were not requested.
    pub observations: Vec<Option<Observation<V, T, D>>>,
    /// The verdicts.
    pub judgment: Judgment<F>,
    /// The decoder's replies to the first files.
    pub first: Vec<FirstFile<V, T>>,
    /// The views and the kinds of cases that the decoder offers.
    pub offer: Offer<F>,
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
    /// Features that the decoder lacks, each with the cases that were not requested for that reason. They have no verdict.
    pub not_asked: NotAsked<F>,
    /// Flag that is set when the user ends the search for causes.
    pub stop: Arc<AtomicBool>,
    /// Units of work done so far by the search for causes, at most [`MAX_WORK`](crate::diagnose::MAX_WORK).
    pub work: Arc<AtomicUsize>,
}

/// Observations of a suite of cases, one slot per case.
pub type ObservationsOf<C> = Vec<Option<ObservationOf<C>>>;

/// A callback for each finished case. It receives the case, its observation, the number of finished cases, and the total.
pub type Progress<'a, C = Case> = dyn Fn(&C, &ObservationOf<C>, usize, usize) + Sync + 'a;

impl<C: TestCase> Session<'_, C> {
    /// Returns the indices of the cases that may be requested: selected cases and their twins, but no case that is withheld or
    /// whose views are not offered. The list is empty if nothing can be requested.
    pub(crate) fn agenda(&self, contact: &ContactOf<C>) -> Vec<usize> {
        let (suite, plan) = (self.suite, self.plan);
        let withheld = plan.withheld_in(suite, contact.table);
        let mut wanted = plan.selected.clone();
        for (i, twins) in C::twins(&suite.cases).into_iter().enumerate() {
            if let (true, Some(&twin)) = (plan.selected[i], twins.first()) {
                wanted[twin] = true;
            }
        }
        let is_offered = |i: usize| contact.offer.chosen_view(&suite.cases[i]).is_some();
        let is_asked = |&i: &usize| wanted[i] && withheld[i].is_none() && is_offered(i);
        let cases = if contact.is_ready() {
            suite.cases.len()
        } else {
            0
        };
        (0..cases).filter(is_asked).collect()
    }

    /// Requests these cases once, each in the first of its views that the decoder offers.
    pub(crate) fn request_cases(
        &self,
        contact: &ContactOf<C>,
        case_indices: &[usize],
        observations: &mut [Option<ObservationOf<C>>],
        progress: &Progress<C>,
    ) {
        let finished = |i: usize, observation: &ObservationOf<C>, done: usize, total: usize| {
            progress(&self.suite.cases[i], observation, done, total);
        };
        let requests = CaseRequests {
            session: self,
            contact,
        };
        requests.request_all(case_indices, observations, &finished);
    }

    /// Judges the selected cases that have been requested so far. Nothing is repeated.
    pub(crate) fn partial_judgment(
        &self,
        contact: &ContactOf<C>,
        observations: &ObservationsOf<C>,
    ) -> Judgment {
        // Open requests will be repeated, so they have no verdict yet.
        let is_closed = |seen: &ObservationOf<C>| !seen.is_open();
        let pairs = self.plan.selected.iter().zip(observations);
        let selected: Vec<bool> = pairs
            .map(|(&selected, seen)| selected && seen.as_ref().is_some_and(is_closed))
            .collect();
        judge(self.suite, &selected, observations, &contact.offer)
    }

    /// Repeats the requests that exceeded the time limit, judges the observations, repeats failures, and judges again if a
    /// response differed. Cases that were not requested because of a feature in `not_asked` have no verdict. `progress` is called
    /// after each repetition with the number of finished repetitions and the total.
    #[must_use]
    pub fn verdicts(
        self,
        contact: ContactOf<C>,
        mut observations: ObservationsOf<C>,
        mut not_asked: NotAsked,
        progress: &CountCallback,
    ) -> RunOf<C> {
        let suite = self.suite;
        let nothing = vec![false; suite.cases.len()];
        let mut asked = self.plan.selected.clone();
        for (_, cases) in &mut not_asked {
            cases.retain(|&i| asked[i]);
            for &i in &*cases {
                asked[i] = false;
            }
        }
        not_asked.retain(|(_, cases)| !cases.is_empty());
        let requests = CaseRequests {
            session: &self,
            contact: &contact,
        };
        requests.repeat_open(&mut observations, progress);
        let end_reason = self.end_reason();
        let (selected, ended_early) = match contact.not_a_decoder {
            Some(_) => (&nothing, end_reason),
            None => (&asked, contact.end_reason.clone().or(end_reason)),
        };
        let mut judgment = judge(suite, selected, &observations, &contact.offer);
        if ended_early.is_none() {
            let wanted = self.cases_to_repeat(&observations, &judgment);
            let kind = |i: usize| suite.cases[i].kind();
            if requests.repeat(wanted, kind, &mut observations, progress) {
                judgment = judge(suite, selected, &observations, &contact.offer);
            }
        }
        // The run may be interrupted while cases are repeated.
        let ended_early = ended_early.or(self.end_reason());
        let reason = || {
            let cases = suite.cases.iter().zip(&observations);
            let legal = cases.filter(|(case, _)| case.expect() == Expect::Decode);
            all_unsupported_reason(legal.filter_map(|(_, seen)| seen.as_ref()))
        };
        let not_a_decoder = contact.not_a_decoder.clone().or_else(reason);
        let is_open = |seen: &&ObservationOf<C>| seen.is_open();
        let open = observations.iter().flatten().filter(is_open).count();
        let withheld = self.plan.withheld_in(suite, contact.table);
        let mut run = self.run(contact, observations, judgment);
        run.remarks.extend(self.tally.remarks(open));
        let mut run = Run {
            ended_early,
            not_a_decoder,
            not_asked,
            ..run
        };
        let offer = run.offer.clone();
        let is_offered = |i: usize| offer.chosen_view(&suite.cases[i]).is_some();
        run.explain_skipped_cases(&withheld, is_offered);
        run.report_early_end();
        run
    }

    /// Returns the failures and, if the decoder serves, a sample of the other cases.
    fn cases_to_repeat(
        &self,
        observations: &[Option<ObservationOf<C>>],
        judgment: &Judgment,
    ) -> Vec<usize> {
        let cases = &self.suite.cases;
        let is_wanted = |&i: &usize| {
            let (Some(observation), Some(judged)) = (&observations[i], &judgment.cases[i]) else {
                return false;
            };
            // The sample includes the first legal case of each unsupported kind.
            let is_first_unsupported = || {
                let mut unsupported = judgment.with_outcome(Outcome::Unsupported);
                let key = |index: usize| (cases[index].kind(), cases[index].expect());
                let first = (cases[i].kind(), Expect::Decode);
                unsupported.find(|&index| key(index) == first) == Some(i)
            };
            let is_sampled = || {
                self.plan.repeat == Repeat::FailuresAndSample
                    && (i % SAMPLE_INTERVAL == SAMPLE_INTERVAL / 2 || is_first_unsupported())
            };
            !observation.is_settled() && (judged.outcome == Outcome::Fail || is_sampled())
        };
        match self.plan.repeat {
            Repeat::Nothing => Vec::new(),
            _ => (0..observations.len()).filter(is_wanted).collect(),
        }
    }

    fn run(
        &self,
        contact: ContactOf<C>,
        observations: ObservationsOf<C>,
        judgment: Judgment,
    ) -> RunOf<C> {
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
            not_asked: Vec::new(),
            stop: Arc::clone(&self.plan.stop),
            work: Arc::default(),
        }
    }
}

/// The requests for the cases of a suite, after first contact.
struct CaseRequests<'a, C: TestCase> {
    session: &'a Session<'a, C>,
    contact: &'a ContactOf<C>,
}

impl<C: TestCase> CaseRequests<'_, C> {
    /// Returns a case and the view in which it is requested.
    fn case_and_view(&self, case: usize) -> (&C, &C::View) {
        let case = &self.session.suite.cases[case];
        let view = self.contact.offer.chosen_view(case);
        (
            case,
            view.expect("only cases with an offered view are requested"),
        )
    }
}

impl<C: TestCase> Requests<C::View, C::Output, C::Difference> for CaseRequests<'_, C> {
    fn plan(&self) -> &RunPlan {
        self.session.plan
    }

    fn tally(&self) -> &Tally {
        &self.session.tally
    }

    fn is_legal(&self, case: usize) -> bool {
        self.session.suite.cases[case].expect() == Expect::Decode
    }

    fn observe(&self, case: usize, worker: usize) -> ObservationOf<C> {
        let (case, view) = self.case_and_view(case);
        let (table, usual) = (self.contact.table, AttemptKind::Usual);
        self.session.observe(case, view, table, worker, usual).0
    }

    fn pipeline_depth(&self) -> usize {
        self.session.pipeline_depth()
    }

    fn observe_pipelined(&self, cases: &[usize], worker: usize) -> Vec<ObservationOf<C>> {
        let cases: Vec<_> = cases.iter().map(|&case| self.case_and_view(case)).collect();
        self.session
            .observe_pipelined(&cases, self.contact.table, worker)
    }

    fn observe_alone(&self, case: usize, view: &C::View) -> Option<ObservationOf<C>> {
        let case = &self.session.suite.cases[case];
        let (observation, _) = self.session.observe_alone(case, view, self.contact.table)?;
        Some(observation)
    }

    fn observe_again(&self, case: usize, view: &C::View, worker: usize) -> ObservationOf<C> {
        let case = &self.session.suite.cases[case];
        let (table, again) = (self.contact.table, AttemptKind::Repetition);
        self.session.request(case, view, table, worker, again).0
    }
}

/// Returns the reason why a program that exited with 69 for every must-accept file is not a decoder. `legal` are the observations
/// of these files.
pub(super) fn all_unsupported_reason<'a, V: 'a, T: 'a, D: 'a>(
    legal: impl Iterator<Item = &'a Observation<V, T, D>>,
) -> Option<String> {
    let mut legal = legal.peekable();
    let unsupported = |seen: &Observation<V, T, D>| matches!(seen.response, Response::Unsupported);
    (legal.peek().is_some() && legal.all(unsupported))
        .then(|| "it exits with 69 (unsupported) on every legal file".to_owned())
}

impl<V, T, D, F> Run<V, T, D, F> {
    /// Returns true if the decoder reads a file that tests the spelling in which the suite sent tables. Otherwise, this spelling
    /// is a guess.
    pub(crate) fn shows_table_spelling<C: TestCase>(&self, suite: &Suite<C>) -> bool {
        let mut passing = self.judgment.with_outcome(Outcome::Pass);
        passing.any(|i| self.is_image_in_table_spelling(suite, i))
    }

    /// Returns true if case `i` tests the spelling in which the suite sent tables, and the response is an image.
    pub(crate) fn is_image_in_table_spelling<C: TestCase>(
        &self,
        suite: &Suite<C>,
        i: usize,
    ) -> bool {
        let response = self.observations[i].as_ref().map(|seen| &seen.response);
        matches!(response, Some(Response::Image { .. }))
            && suite.cases[i].spelling() == Some(self.table)
    }
}

impl<V, T, D, F: Ord> Run<V, T, D, F> {
    /// Explains why cases were not requested: they were withheld, or the run ended early.
    pub(super) fn explain_skipped_cases(
        &mut self,
        withheld: &[Option<String>],
        is_offered: impl Fn(usize) -> bool,
    ) {
        for (i, judged) in self.judgment.cases.iter_mut().enumerate() {
            let Some(judged) = judged else { continue };
            if let Some(Some(why)) = withheld.get(i) {
                judged.outcome = Outcome::NotJudged;
                judged.message.clone_from(why);
            } else if self.observations[i].is_none() && is_offered(i) {
                judged.outcome = Outcome::NotRun;
                judged.message = self.ended_early.clone().unwrap_or_default();
            }
        }
    }

    /// Reports why the run ended early: in a remark or, if the program is not a decoder, in the reason for that verdict.
    pub(super) fn report_early_end(&mut self) {
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

    /// Returns the scores of this run. `features` returns the features that a decoder may need for a case.
    #[must_use]
    pub fn scores(&self, features: impl Fn(usize) -> BTreeSet<F>) -> Scores {
        let count = |outcome: Outcome| self.judgment.with_outcome(outcome).count();
        let cases = self.judgment.cases.iter().enumerate();
        let judged = cases.filter_map(|(i, judged)| judged.as_ref().map(|_| i));
        let not_asked = self
            .not_asked
            .iter()
            .flat_map(|(_, cases)| cases.iter().copied());
        let features: BTreeSet<F> = judged.chain(not_asked).flat_map(features).collect();
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
        self.ending().exit_status()
    }

    /// Returns how the run ended.
    #[must_use]
    pub fn ending(&self) -> Ending {
        let is_image =
            |seen: &Observation<V, T, D>| matches!(seen.response, Response::Image { .. });
        Ending {
            is_decoder: self.not_a_decoder.is_none(),
            ended_early: self.ended_early.clone(),
            fails_as_a_whole: self.ended_early.is_some()
                || self.remarks.iter().any(|remark| remark.failure)
                || !self.observations.iter().flatten().any(is_image),
            has_failing_case: self.judgment.with_outcome(Outcome::Fail).next().is_some(),
        }
    }
}

/// How a run ended. The exit status depends on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ending {
    /// True if the program is a decoder.
    pub is_decoder: bool,
    /// The reason why the run ended before all cases were requested, if it did.
    pub ended_early: Option<String>,
    /// True if the run fails even if no case does.
    pub fails_as_a_whole: bool,
    /// True if a case fails.
    pub has_failing_case: bool,
}

impl Ending {
    /// Returns true if all selected cases were requested.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.is_decoder && self.ended_early.is_none()
    }

    /// Returns the exit status of `check`: 0, 1 or 3.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        if self.is_decoder {
            u8::from(self.has_failing_case || self.fails_as_a_whole)
        } else {
            3
        }
    }

    /// Returns the ending of a run in which some failures are ignored. `has_failing_case` is true if other cases fail.
    #[must_use]
    pub fn with_failing_case(self, has_failing_case: bool) -> Ending {
        Ending {
            has_failing_case,
            ..self
        }
    }
}
