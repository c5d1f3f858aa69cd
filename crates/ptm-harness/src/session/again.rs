//! Repeats failures and a sample of the other cases, with a new process for each request.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use crate::session::asking::{CountCallback, Session, previous_request_text};
use crate::session::plan::{Repeat, SAMPLE_INTERVAL};
use ptm_suite::cases::{Expect, TableSpelling};
use ptm_suite::protocol::request::AttemptKind;
use ptm_suite::test_case::TestCase;
use ptm_suite::verdicts::judge::Judgment;
use ptm_suite::verdicts::observation::{Nondeterminism, Observation, Response};
use ptm_suite::verdicts::outcome::Outcome;

/// Maximum number of failures of each kind that are initially repeated.
const MAX_REPEATED_PER_KIND: usize = 8;

/// Number of repetitions that are always allowed, even if they exceed a tenth of the run.
const MIN_REPEATED: usize = 24;

impl<C: TestCase> Session<'_, C> {
    /// Repeats failures and a sample of the other cases. Returns true if a response differed. If one failure recurs, similar
    /// failures are likely to recur too, so only a few cases of each kind, and usually at most a tenth of the run, are repeated.
    /// If any response differs, the rest are repeated as well, because a varying response says nothing about the reading.
    pub(super) fn repeat(
        &self,
        table: TableSpelling,
        observations: &mut [Option<Observation<C>>],
        judgment: &Judgment<C::Feature>,
        progress: &CountCallback,
    ) -> bool {
        if self.plan.repeat == Repeat::Nothing {
            return false;
        }
        let is_wanted = |&i: &usize| {
            let (Some(observation), Some(judged)) = (&observations[i], &judgment.cases[i]) else {
                return false;
            };
            // A request that exceeded the time limit has been repeated already, and would probably exceed it again. If two
            // responses already differ, the case is decided.
            let is_settled = observation.nondeterminism.is_some()
                || observation.attempt == AttemptKind::Alone
                || observation.response.time_limit().is_some();
            // The sample includes the first legal case of each unsupported kind.
            let cases = &self.suite.cases;
            let is_first_unsupported = || {
                let mut unsupported = judgment.with_outcome(Outcome::Unsupported);
                let key = |index: usize| (cases[index].kind(), cases[index].expect());
                let first = (cases[i].kind(), Expect::Decode);
                unsupported.find(|&index| key(index) == first) == Some(i)
            };
            let sampled = self.plan.repeat == Repeat::FailuresAndSample
                && (i % SAMPLE_INTERVAL == SAMPLE_INTERVAL / 2 || is_first_unsupported());
            !is_settled && (judged.outcome == Outcome::Fail || sampled)
        };
        let wanted = (0..observations.len()).filter(is_wanted).collect();
        let (some, rest) = self.sample_each_kind(observations, wanted);
        let differs = self.repeat_in_new_processes(table, observations, &some, progress);
        if differs {
            self.repeat_in_new_processes(table, observations, &rest, progress);
        }
        differs
    }

    /// Splits `wanted` into a sample and the rest. The sample contains a few cases of each kind, spread over the suite.
    fn sample_each_kind(
        &self,
        observations: &[Option<Observation<C>>],
        wanted: Vec<usize>,
    ) -> (Vec<usize>, Vec<usize>) {
        let limit = (observations.iter().flatten().count() / 10).max(MIN_REPEATED);
        let mut kinds: BTreeMap<(C::Feature, &str), Vec<usize>> = BTreeMap::new();
        for &i in &wanted {
            let response = (observations[i].as_ref()).map_or("", |seen| seen.response.name());
            let kind = (self.suite.cases[i].kind(), response);
            kinds.entry(kind).or_default().push(i);
        }
        let spread = kinds.values().flat_map(|case_indices| {
            let step = case_indices.len().div_ceil(MAX_REPEATED_PER_KIND).max(1);
            case_indices.iter().copied().step_by(step)
        });
        let some: BTreeSet<usize> = spread.take(limit).collect();
        wanted.into_iter().partition(|i| some.contains(i))
    }

    /// Repeats each case in `case_indices` in a new process. If the response differs, repeats the case once more, to distinguish
    /// a decoder with random responses from one whose serve mode differs. Records differences and returns true if there are any.
    /// A repetition that exceeds the time limit says nothing about the decoder, so it is ignored.
    fn repeat_in_new_processes(
        &self,
        table: TableSpelling,
        observations: &mut [Option<Observation<C>>],
        case_indices: &[usize],
        progress: &CountCallback,
    ) -> bool {
        let is_serving = self.plan.repeat == Repeat::FailuresAndSample;
        let state = Mutex::new((observations, 0, false));
        let lock = || state.lock().expect("no worker panics");
        self.run_in_parallel(case_indices.len(), |at, worker| {
            let index = case_indices[at];
            let first = lock().0[index].clone();
            let mut first = first.expect("only observations are repeated");
            let case = &self.suite.cases[index];
            let ask = || {
                let repetition = AttemptKind::Repetition;
                let (observation, _) = self.request(case, &first.view, table, worker, repetition);
                Some(observation).filter(|seen| seen.response.time_limit().is_none())
            };
            let repeated = ask();
            // A crash, a timeout or truncated output may have happened only to that process.
            let is_no_answer =
                |seen: &Observation<C>| matches!(seen.response, Response::Violation(_));
            let differing = repeated
                .as_ref()
                .filter(|last| !last.response.is_equivalent(&first.response));
            let is_doubtful = |last| is_serving || is_no_answer(last) != is_no_answer(&first);
            let once_more = differing
                .filter(|last| is_doubtful(last))
                .and_then(|_| ask());
            if self.is_interrupted() {
                return false;
            }
            let differs = differing.is_some();
            if let Some(last) = differing {
                let agrees = |seen: &Observation<C>| seen.response.is_equivalent(&last.response);
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
            observations[index] = Some(first);
            *done += 1;
            *differ |= differs;
            progress(*done, case_indices.len());
            true
        });
        state.into_inner().expect("no worker panics").2
    }
}

/// Describes the difference between the responses to one request.
fn difference<C: TestCase>(
    in_serve_mode: bool,
    first: &Observation<C>,
    alone: &Observation<C>,
    once_more: Option<&Observation<C>>,
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
