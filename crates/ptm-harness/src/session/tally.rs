//! Counters of a run, and a condition that ends the run early.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, OnceLock};

use crate::session::{plan::RunPlan, remark::Remark};
use ptm_suite::protocol::frame::{Answer, TimeLimit};
use ptm_suite::protocol::request::{AttemptKind, Reply};
use ptm_suite::verdicts::observation::{Observation, Response};

/// Number of consecutive legal files that exceed the time limit before one of them is requested alone.
pub(super) const MAX_CONSECUTIVE: usize = 3;

/// Maximum number of files that a remark names.
const MAX_NAMED: usize = 3;

/// Facts about the calls so far.
#[derive(Default)]
pub(super) struct Tally {
    pub calls: AtomicUsize,
    /// Number of calls that ended in neither a frame nor a refusal.
    pub violations: AtomicUsize,
    /// The time limit that ended the run: three consecutive legal files exceeded it.
    pub exceeded_limit: OnceLock<TimeLimit>,
    /// The usual time limit, if a request exceeded it.
    pub usual_limit: OnceLock<TimeLimit>,
    /// The names of the files that exceeded the usual time limit, but were answered when they were requested alone.
    slow_files: Mutex<BTreeSet<String>>,
}

impl Tally {
    /// Counts a request.
    pub fn count<T>(&self, reply: &Reply<T>, attempt: AttemptKind) {
        self.calls.fetch_add(1, Relaxed);
        if reply.is_violation() {
            self.violations.fetch_add(1, Relaxed);
        }
        if let (AttemptKind::Usual, Answer::TimedOut(limit)) = (attempt, &reply.answer) {
            let _ = self.usual_limit.set(*limit);
        }
    }

    /// Counts the answer to a request that had exceeded the time limit and was repeated alone. It replaces the first answer.
    pub fn count_alone<T>(&self, reply: &Reply<T>, name: &str) {
        if !reply.is_violation() {
            self.violations.fetch_sub(1, Relaxed);
        }
        if !reply.is_timeout() {
            let mut files = self.slow_files.lock().expect("no worker panics");
            files.insert(name.to_owned());
        }
    }

    /// Removes a request from the counts.
    pub fn uncount<V, T, D>(&self, observation: &Observation<V, T, D>) {
        // True if the call ended in neither a frame nor a refusal, or a serving process did not answer.
        let is_violation = matches!(observation.response, Response::Violation(_))
            || observation.nondeterminism.is_some();
        self.calls.fetch_sub(1, Relaxed);
        self.violations.fetch_sub(is_violation.into(), Relaxed);
    }

    /// Returns the reason why no more requests will be sent, if there is one.
    pub fn end_reason(&self, plan: &RunPlan) -> Option<String> {
        if plan.ends_after_failure() {
            return Some("the run ended after the first failure (--fail-fast)".to_owned());
        }
        if plan.is_interrupted() {
            return Some("the run was interrupted".to_owned());
        }
        let limit = self.exceeded_limit.get()?;
        Some(format!(
            "the run ended early: the decoder {limit} on three legal files in a row"
        ))
    }

    /// Returns the remarks on requests that exceeded the usual time limit. `open` requests were not repeated.
    pub fn remarks(&self, open: usize) -> Vec<Remark> {
        let Some(usual) = self.usual_limit.get() else {
            return Vec::new();
        };
        let [limit, higher] = [usual.0, AttemptKind::Alone.time_limit(usual.0).0];
        let [limit, higher] = [limit, higher].map(|limit| limit.as_secs_f64());
        let slow = self.slow_files.lock().expect("no worker panics");
        let mut remarks = Vec::new();
        if !slow.is_empty() {
            let count = match slow.len() {
                1 => "1 file".to_owned(),
                count => format!("{count} files"),
            };
            let named: Vec<&str> = slow.iter().take(MAX_NAMED).map(String::as_str).collect();
            let more = if slow.len() > MAX_NAMED { ", …" } else { "" };
            let named = named.join(", ");
            remarks.push(Remark::note(format!(
                "it exceeded the time limit of {limit} s (`--timeout`) on {count} and ended within {higher} s when no other request was in progress; the time is no failure: {named}{more}"
            )));
        }
        if open > 0 {
            remarks.push(Remark::note(format!(
                "requests that exceeded the time limit of {limit} s (`--timeout`) and were not repeated, because others exceeded {higher} s: {open}"
            )));
        }
        remarks
    }
}

/// Tracks requests that exceed the time limit, in sequence or in parallel, to find consecutive ones.
pub(super) struct TimeoutWatch {
    /// The indices of the legal files, in order.
    legal: Vec<usize>,
    /// For each legal file, true if all its requests so far exceeded the time limit; `None` before the first result.
    timed_out: Mutex<Vec<Option<bool>>>,
    /// The rank of the last of the first consecutive legal files that exceeded the time limit.
    last_rank: AtomicUsize,
}

impl TimeoutWatch {
    /// Creates a watch for the legal files at these indices, which must be in ascending order.
    pub fn new(legal: Vec<usize>) -> TimeoutWatch {
        TimeoutWatch {
            timed_out: Mutex::new(vec![None; legal.len()]),
            legal,
            last_rank: AtomicUsize::new(usize::MAX),
        }
    }

    /// Records whether a request for the file at `index` exceeded the time limit. Files are consecutive by index, regardless of
    /// the order of their answers.
    pub fn record(&self, index: usize, timed_out: bool) {
        let Ok(rank) = self.legal.binary_search(&index) else {
            return;
        };
        let mut all = self.timed_out.lock().expect("no worker panics");
        all[rank] = Some(timed_out && all[rank] != Some(false));
        let near = rank.saturating_sub(MAX_CONSECUTIVE - 1);
        let mut rows = all[near..].windows(MAX_CONSECUTIVE).take(MAX_CONSECUTIVE);
        if let Some(row) = rows.position(|row| row.iter().all(|file| *file == Some(true))) {
            let last = near + row + MAX_CONSECUTIVE - 1;
            self.last_rank.fetch_min(last, Relaxed);
        }
    }

    /// Returns the indices of the first consecutive legal files that exceeded the time limit, if there are any.
    pub fn consecutive(&self) -> Option<&[usize]> {
        let last = self.last_rank.load(Relaxed);
        (last < usize::MAX).then(|| &self.legal[last + 1 - MAX_CONSECUTIVE..=last])
    }

    /// Returns true if `index` is after those files, so its request can wait.
    pub fn is_after(&self, index: usize) -> bool {
        let last = self.consecutive().and_then(<[usize]>::last);
        last.is_some_and(|&last| index > last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The files at even indices are legal. The first request for file 12 is answered in time.
    #[test]
    fn three_consecutive_timeouts_are_found_in_any_order_of_answers() {
        let backward: Vec<usize> = (0..20).rev().collect();
        let forward: Vec<usize> = (0..20).collect();
        for (asked, slow, found) in [
            (&forward[..], &[4, 6, 8][..], Some(&[4, 6, 8][..])),
            (&backward, &[4, 6, 8], Some(&[4, 6, 8])),
            (&[8, 0, 4, 2, 6], &[4, 6, 8], Some(&[4, 6, 8])),
            (&backward, &[4, 6, 8, 10, 12, 14], Some(&[4, 6, 8])),
            (&[0, 2, 2, 4], &[0, 2, 4], Some(&[0, 2, 4])),
            // Other files in between, malformed files, or an answer in a different view.
            (&forward, &[4, 6, 10, 12, 18], None),
            (&[4, 6, 10, 8], &[4, 6, 10], None),
            (&forward, &[1, 3, 5, 7, 9, 11], None),
            (&[10, 12, 12, 14], &[10, 12, 14], None),
            (&forward, &[14, 16, 18], Some(&[14, 16, 18])),
        ] {
            let watch = TimeoutWatch::new((0..20).step_by(2).collect());
            let mut in_time = Some(12);
            for &index in asked {
                let timed_out =
                    slow.contains(&index) && in_time.take_if(|of| *of == index).is_none();
                watch.record(index, timed_out);
            }
            assert_eq!(watch.consecutive(), found);
        }
    }
}
