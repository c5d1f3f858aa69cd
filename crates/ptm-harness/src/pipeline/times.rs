//! How long the requests of each case take.

use std::collections::HashMap;
use std::sync::Mutex;
use std::time::{Duration, Instant, SystemTime};

/// The start of a run, and the wall-clock time of the requests of each case. Reports in YAML do not contain times, because they are
/// the same for the same answers.
#[derive(Clone, Debug)]
pub struct Times {
    /// The start of the run.
    pub start: SystemTime,
    /// The time of all requests of each case, by id. Requests that are sent together share their time equally.
    pub of_case: HashMap<String, Duration>,
}

impl Times {
    /// Returns the `count` slowest cases with their times, the slowest first.
    #[must_use]
    pub fn slowest(&self, count: usize) -> Vec<(&str, Duration)> {
        let mut all: Vec<(&str, Duration)> = self
            .of_case
            .iter()
            .map(|(id, time)| (&**id, *time))
            .collect();
        all.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        all.truncate(count);
        all
    }
}

impl Default for Times {
    /// Starts a run now.
    fn default() -> Times {
        Times {
            start: SystemTime::now(),
            of_case: HashMap::new(),
        }
    }
}

/// Measures requests in several threads.
#[derive(Default)]
pub(super) struct Stopwatch(Mutex<Times>);

impl Stopwatch {
    /// Sends requests for the cases with these ids, and adds the time to theirs.
    pub fn measure<T>(&self, ids: &[&str], send: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let replies = send();
        let time = start.elapsed() / ids.len().max(1) as u32;
        let mut times = self.0.lock().expect("no holder of the lock panics");
        for id in ids {
            match times.of_case.get_mut(*id) {
                Some(sum) => *sum += time,
                None => {
                    times.of_case.insert((*id).to_owned(), time);
                }
            }
        }
        replies
    }

    /// Returns the times so far.
    pub fn times(&self) -> Times {
        self.0.lock().expect("no holder of the lock panics").clone()
    }
}
