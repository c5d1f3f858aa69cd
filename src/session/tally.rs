//! What a run counts while it goes on, and why it should not go on.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// So many hangs in a row end a run.
const HANGS: usize = 3;

/// Calls so far.
pub(super) struct Tally<'a> {
    calls: AtomicUsize,
    violation: AtomicUsize,
    /// Hangs in a row.
    hangs: AtomicUsize,
    stop: &'a AtomicBool,
}

impl<'a> Tally<'a> {
    /// Nothing yet; `stop` is set when the user wants the run to end.
    pub fn new(stop: &'a AtomicBool) -> Tally<'a> {
        Tally {
            calls: AtomicUsize::new(0),
            violation: AtomicUsize::new(0),
            hangs: AtomicUsize::new(0),
            stop,
        }
    }

    /// Counts a call; returns how many times the ordinary time limit it gets, for the first may have to warm up.
    pub fn call(&self) -> u32 {
        match self.calls.fetch_add(1, Ordering::Relaxed) {
            0 => 3,
            _ => 1,
        }
    }

    /// Counts how a call ended.
    pub fn count(&self, violation: bool, hang: bool) {
        if violation {
            self.violation.fetch_add(1, Ordering::Relaxed);
        }
        if hang {
            self.hangs.fetch_add(1, Ordering::Relaxed);
        } else if self.why_over().is_none() {
            self.hangs.store(0, Ordering::Relaxed);
        }
    }

    /// Why the run should not go on, if it should not.
    pub fn why_over(&self) -> Option<&'static str> {
        if self.stop.load(Ordering::Relaxed) {
            Some("the run was ended by its user")
        } else if self.hangs.load(Ordering::Relaxed) >= HANGS {
            Some("the run ended after three hangs in a row")
        } else {
            None
        }
    }

    /// Calls, and those of them that ended in neither a frame nor a refusal.
    pub fn counts(&self) -> (usize, usize) {
        let [calls, violation] =
            [&self.calls, &self.violation].map(|count| count.load(Ordering::Relaxed));
        (calls, violation)
    }
}
