//! The current activity of a run, on standard error: one updated line on a terminal, a new line every half minute elsewhere.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;

use super::output::{bar, complain, quiet};

/// The interval of updates on a terminal, and of new lines elsewhere.
const UPDATE_INTERVALS: (Duration, Duration) =
    (Duration::from_millis(500), Duration::from_secs(30));

/// Minimum number of finished items for an estimate of the remaining time.
const MIN_DONE: usize = 10;

/// The current activity of a run.
struct Doing {
    what: &'static str,
    done: Arc<AtomicUsize>,
    /// The number of items; 0 if unknown.
    all: usize,
    /// True if `all` is an upper bound on the work, not a number of items; `done` is then not shown.
    is_limit: bool,
    wrong: usize,
    since: Instant,
}

impl Doing {
    fn in_words(&self) -> String {
        let done = self.done.load(Ordering::Relaxed);
        let mut words = self.what.to_owned();
        if self.all > 0 && !self.is_limit {
            let _ = write!(words, " {done} of {}", self.all);
        }
        if self.wrong > 0 {
            let _ = write!(words, ", {} wrong so far", self.wrong);
        }
        let elapsed = self.since.elapsed();
        if done < MIN_DONE || done > self.all {
            return format!("{words}, for {}", in_words(elapsed));
        }
        let bound = if self.is_limit { "at most" } else { "about" };
        let left = elapsed.mul_f64((self.all - done) as f64 / done as f64);
        format!("{words}, {bound} {} left", in_words(left))
    }
}

/// Formats an approximate time: seconds, or minutes.
pub fn in_words(time: Duration) -> String {
    match time.as_secs() {
        seconds @ 0..100 => format!("{seconds} s"),
        seconds => format!("{} min", (seconds + 30) / 60),
    }
}

/// Shows the current activity of a run until it is dropped.
pub struct ProgressLine {
    bar: ProgressBar,
    doing: Arc<Mutex<Doing>>,
    ticker: Option<(Sender<()>, JoinHandle<()>)>,
}

impl ProgressLine {
    /// Shows nothing if only results are to be printed.
    pub fn new(what: &'static str) -> ProgressLine {
        let doing = Arc::new(Mutex::new(Doing {
            what,
            done: Arc::default(),
            all: 0,
            is_limit: false,
            wrong: 0,
            since: Instant::now(),
        }));
        let bar = bar(Some(0), "{bar:30} {msg}");
        let ticker = (!quiet()).then(|| {
            let (bar, doing) = (bar.clone(), Arc::clone(&doing));
            let (end, ended) = channel();
            let on_terminal = std::io::stderr().is_terminal();
            let tick = if on_terminal {
                UPDATE_INTERVALS.0
            } else {
                UPDATE_INTERVALS.1
            };
            let tell = move || {
                while ended.recv_timeout(tick) == Err(RecvTimeoutError::Timeout) {
                    let words = doing
                        .lock()
                        .expect("no thread panics while it holds the lock")
                        .in_words();
                    match on_terminal {
                        true => bar.set_message(words),
                        false => complain(&words),
                    }
                }
            };
            (end, std::thread::spawn(tell))
        });
        ProgressLine { bar, doing, ticker }
    }

    fn doing(&self) -> MutexGuard<'_, Doing> {
        self.doing
            .lock()
            .expect("no thread panics while it holds the lock")
    }

    /// Starts another activity.
    pub fn begin(&self, what: &'static str) {
        let mut doing = self.doing();
        (doing.done, doing.all, doing.is_limit) = (Arc::default(), 0, false);
        (doing.what, doing.since) = (what, Instant::now());
        self.bar.set_message(what);
        self.bar.set_length(0);
        self.bar.set_position(0);
    }

    /// Starts an activity that `counter` counts, up to at most `all`.
    pub fn begin_counted(&self, what: &'static str, counter: &Arc<AtomicUsize>, all: usize) {
        self.begin(what);
        let mut doing = self.doing();
        (doing.done, doing.all, doing.is_limit) = (Arc::clone(counter), all, true);
    }

    /// Shows that `done` of `all` are finished. Concurrent callers may be out of order.
    pub fn show(&self, done: usize, all: usize) {
        let mut doing = self.doing();
        let before = doing.done.fetch_max(done, Ordering::Relaxed);
        doing.all = all;
        self.bar.set_length(all as u64);
        self.bar.set_position(before.max(done) as u64);
    }

    /// Counts a wrong answer.
    pub fn one_wrong(&self) {
        self.doing().wrong += 1;
    }

    /// Prints a message between two lines of progress.
    pub fn say(&self, text: &str) {
        if !quiet() {
            self.bar.suspend(|| complain(text));
        }
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if let Some((end, thread)) = self.ticker.take() {
            drop(end);
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_line_shows_done_and_remaining_work() {
        let asking = "asking 100 of 300, 7 wrong so far, about 4 min left";
        let searching = "searching, 7 wrong so far, at most 60 s left";
        for (what, done, all, is_limit, expected) in [
            ("asking", 100, 300, false, asking),
            (
                "searching",
                0,
                0,
                false,
                "searching, 7 wrong so far, for 2 min",
            ),
            ("searching", 100, 150, true, searching),
        ] {
            let since = Instant::now().checked_sub(Duration::from_secs(120));
            let doing = Doing {
                what,
                done: Arc::new(AtomicUsize::new(done)),
                all,
                is_limit,
                wrong: 7,
                since: since.expect("it is later"),
            };
            assert_eq!(doing.in_words(), expected);
        }
    }
}
