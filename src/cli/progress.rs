//! Progress display on standard error. On a terminal, one line is updated. Elsewhere, a new line is printed every half minute.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use ptm_harness::diagnose::MAX_WORK;

use super::output::{bar, is_quiet, print_error};

/// Intervals between updates on a terminal and between new lines elsewhere.
const UPDATE_INTERVALS: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(30)];

/// Minimum number of finished items for an estimate of the remaining time.
const MIN_DONE: usize = 10;

struct Activity {
    label: &'static str,
    done: Arc<AtomicUsize>,
    /// Number of items; 0 if unknown.
    total: usize,
    /// True if `total` is an upper bound rather than the number of items. The number of finished items is then not displayed.
    is_limit: bool,
    wrong: usize,
    since: Instant,
}

impl Activity {
    fn status_text(&self) -> String {
        let done = self.done.load(Ordering::Relaxed);
        let mut words = self.label.to_owned();
        if self.total > 0 && !self.is_limit {
            let _ = write!(words, " {done} of {}", self.total);
        }
        if self.wrong > 0 {
            let _ = write!(words, ", {} wrong so far", self.wrong);
        }
        let elapsed = self.since.elapsed();
        if done < MIN_DONE || done > self.total {
            return format!("{words}, for {}", format_duration(elapsed));
        }
        let bound = if self.is_limit { "at most" } else { "about" };
        let left = elapsed.mul_f64((self.total - done) as f64 / done as f64);
        format!("{words}, {bound} {} left", format_duration(left))
    }
}

/// Formats an approximate duration in seconds or minutes.
pub fn format_duration(time: Duration) -> String {
    match time.as_secs() {
        seconds @ 0..100 => format!("{seconds} s"),
        seconds => format!("{} min", (seconds + 30) / 60),
    }
}

fn lock(activity: &Mutex<Activity>) -> MutexGuard<'_, Activity> {
    (activity.lock()).expect("no thread panics while it holds the lock")
}

/// Display of the current activity of a run. The display ends when this value is dropped.
pub struct ProgressLine {
    bar: ProgressBar,
    activity: Arc<Mutex<Activity>>,
    ticker: Option<(Sender<()>, JoinHandle<()>)>,
}

impl ProgressLine {
    /// Starts the display. Nothing is displayed if `--quiet` is given.
    pub fn new(label: &'static str) -> ProgressLine {
        let activity = Arc::new(Mutex::new(Activity {
            label,
            done: Arc::default(),
            total: 0,
            is_limit: false,
            wrong: 0,
            since: Instant::now(),
        }));
        let bar = bar(Some(0), "{bar:30} {msg}");
        let ticker = (!is_quiet()).then(|| {
            let (bar, activity) = (bar.clone(), Arc::clone(&activity));
            let (end, ended) = channel();
            let on_terminal = std::io::stderr().is_terminal();
            let tick = UPDATE_INTERVALS[usize::from(!on_terminal)];
            let print_updates = move || {
                while ended.recv_timeout(tick) == Err(RecvTimeoutError::Timeout) {
                    let words = lock(&activity).status_text();
                    match on_terminal {
                        true => bar.set_message(words),
                        false => print_error(&words),
                    }
                }
            };
            (end, std::thread::spawn(print_updates))
        });
        ProgressLine {
            bar,
            activity,
            ticker,
        }
    }

    /// Starts a new activity.
    pub fn begin(&self, label: &'static str) {
        let mut activity = lock(&self.activity);
        (activity.done, activity.total, activity.is_limit) = (Arc::default(), 0, false);
        (activity.label, activity.since) = (label, Instant::now());
        self.bar.set_message(label);
        self.bar.set_length(0);
        self.bar.set_position(0);
    }

    /// Starts a search of at most [`MAX_WORK`] steps, which are counted in `counter`.
    pub fn begin_search(&self, label: &'static str, counter: &Arc<AtomicUsize>) {
        self.begin(label);
        let mut activity = lock(&self.activity);
        (activity.done, activity.total, activity.is_limit) = (Arc::clone(counter), MAX_WORK, true);
    }

    /// Reports that `done` of `total` items are finished. Concurrent calls may arrive out of order.
    pub fn update(&self, done: usize, total: usize) {
        let mut activity = lock(&self.activity);
        let before = activity.done.fetch_max(done, Ordering::Relaxed);
        activity.total = total;
        self.bar.set_length(total as u64);
        self.bar.set_position(before.max(done) as u64);
    }

    /// Counts a wrong answer.
    pub fn count_wrong_answer(&self) {
        lock(&self.activity).wrong += 1;
    }

    /// Prints a message without disturbing the progress display.
    pub fn print_message(&self, text: &str) {
        if !is_quiet() {
            self.bar.suspend(|| print_error(text));
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
    fn progress_line_contains_done_and_remaining_work() {
        let since = Instant::now().checked_sub(Duration::from_secs(120));
        let mut activity = Activity {
            label: "running",
            done: Arc::default(),
            total: 0,
            is_limit: false,
            wrong: 7,
            since: since.expect("it is later"),
        };
        let about = " 100 of 300, 7 wrong so far, about 4 min left";
        for (done, all, is_limit, expected) in [
            (0, 0, false, ", 7 wrong so far, for 2 min"),
            (100, 150, true, ", 7 wrong so far, at most 60 s left"),
            (100, 300, false, about),
        ] {
            activity.done.store(done, Ordering::Relaxed);
            (activity.total, activity.is_limit) = (all, is_limit);
            assert_eq!(activity.status_text(), format!("running{expected}"));
        }
    }
}
