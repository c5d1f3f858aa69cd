//! What a run is doing, on standard error: a line that moves on a terminal, a line every half minute elsewhere.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::output::{complain, quiet};

/// How often the line is renewed on a terminal, and how often there is a new one elsewhere.
const TICKS: (Duration, Duration) = (Duration::from_millis(500), Duration::from_secs(30));

/// A run of which so much is done is judged by it.
const TELLING: usize = 10;

/// What a run is doing.
struct Doing {
    what: &'static str,
    done: usize,
    /// Nothing where that is not known.
    all: usize,
    /// Counts what is done of at most `all`, instead of `done`.
    counter: Option<Arc<AtomicUsize>>,
    wrong: usize,
    since: Instant,
}

impl Doing {
    fn in_words(&self) -> String {
        let counted = match self.all {
            _ if self.counter.is_some() => String::new(),
            0 => String::new(),
            all => format!(" {} of {all}", self.done),
        };
        let wrong = match self.wrong {
            0 => String::new(),
            wrong => format!(", {wrong} wrong so far"),
        };
        let time = match self.left() {
            Some(left) if self.counter.is_some() => format!(", at most {} left", in_words(left)),
            Some(left) => format!(", about {} left", in_words(left)),
            None => format!(", for {}", in_words(self.since.elapsed())),
        };
        format!("{}{counted}{wrong}{time}", self.what)
    }

    fn left(&self) -> Option<Duration> {
        let done = match &self.counter {
            Some(counter) => counter.load(Ordering::Relaxed),
            None => self.done,
        };
        let is_known = done >= TELLING && done <= self.all;
        is_known.then(|| {
            self.since
                .elapsed()
                .mul_f64((self.all - done) as f64 / done as f64)
        })
    }
}

/// A time that nobody measures: seconds, or minutes.
pub fn in_words(time: Duration) -> String {
    match time.as_secs() {
        seconds @ 0..100 => format!("{seconds} s"),
        seconds => format!("{} min", (seconds + 30) / 60),
    }
}

/// Says what a run is doing until it is dropped.
pub struct ProgressLine {
    bar: ProgressBar,
    doing: Arc<Mutex<Doing>>,
    ticker: Option<(Sender<()>, JoinHandle<()>)>,
}

impl ProgressLine {
    /// Nothing is said where only results are wanted.
    pub fn new(what: &'static str) -> ProgressLine {
        let doing = Arc::new(Mutex::new(Doing {
            what,
            done: 0,
            all: 0,
            counter: None,
            wrong: 0,
            since: Instant::now(),
        }));
        let bar = match quiet() {
            true => ProgressBar::hidden(),
            false => ProgressBar::new(0).with_style(style()),
        };
        let ticker = (!quiet()).then(|| {
            let (bar, doing) = (bar.clone(), Arc::clone(&doing));
            let (end, ended) = channel();
            let on_terminal = std::io::stderr().is_terminal();
            let tick = if on_terminal { TICKS.0 } else { TICKS.1 };
            let tell = move || {
                while ended.recv_timeout(tick) == Err(RecvTimeoutError::Timeout) {
                    let words = doing.lock().expect("no panic while it is held").in_words();
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

    /// Something else begins.
    pub fn begin(&self, what: &'static str) {
        let mut doing = self.doing.lock().expect("no panic while it is held");
        doing.what = what;
        (doing.done, doing.all, doing.counter) = (0, 0, None);
        doing.since = Instant::now();
        self.bar.set_message(what);
        self.bar.set_length(0);
        self.bar.set_position(0);
    }

    /// Begins work that `counter` counts and that ends when at most `all` is done.
    pub fn begin_counted(&self, what: &'static str, counter: &Arc<AtomicUsize>, all: usize) {
        self.begin(what);
        let mut doing = self.doing.lock().expect("no panic while it is held");
        (doing.counter, doing.all) = (Some(Arc::clone(counter)), all);
    }

    /// So many of so many are done.
    pub fn show(&self, done: usize, all: usize) {
        let mut doing = self.doing.lock().expect("no panic while it is held");
        // Of those who report at once the one who is ahead may be first.
        doing.done = doing.done.max(done);
        doing.all = all;
        self.bar.set_length(all as u64);
        self.bar.set_position(doing.done as u64);
    }

    /// One more answer is wrong.
    pub fn one_wrong(&self) {
        self.doing.lock().expect("no panic while it is held").wrong += 1;
    }

    /// Says something between two lines of progress.
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

fn style() -> ProgressStyle {
    ProgressStyle::with_template("{bar:30} {msg}").expect("the template is well-formed")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_says_what_is_done_and_what_is_left() {
        let doing = Doing {
            what: "asking",
            done: 100,
            all: 300,
            wrong: 7,
            counter: None,
            since: (Instant::now().checked_sub(Duration::from_secs(120))).expect("it is later"),
        };
        assert_eq!(
            doing.in_words(),
            "asking 100 of 300, 7 wrong so far, about 4 min left"
        );
        let searching = Doing {
            what: "searching for causes",
            all: 0,
            done: 0,
            ..doing
        };
        assert_eq!(
            searching.in_words(),
            "searching for causes, 7 wrong so far, for 2 min"
        );
        let counted = Doing {
            counter: Some(Arc::new(AtomicUsize::new(100))),
            all: 150,
            ..searching
        };
        assert_eq!(
            counted.in_words(),
            "searching for causes, 7 wrong so far, at most 60 s left"
        );
    }
}
