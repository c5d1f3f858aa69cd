//! Counters of a run, and conditions that end the run early.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// Number of timeouts on consecutive legal files after which a run ends.
const MAX_CONSECUTIVE_HANGS: usize = 3;

/// Counts of calls so far.
#[derive(Default)]
pub(super) struct Tally {
    pub calls: AtomicUsize,
    /// Number of calls that ended in neither a frame nor a refusal.
    pub violations: AtomicUsize,
    /// True if the decoder timed out on too many consecutive legal files.
    pub too_many_hangs: AtomicBool,
}

/// Tracks timeouts on files that are requested in sequence or in parallel, to decide when to end the run.
pub(super) struct HangWatch {
    /// The indices of the legal files, in order.
    legal: Vec<usize>,
    /// For each legal file, true if all its requests so far have timed out; `None` before the first result.
    timed_out: Mutex<Vec<Option<bool>>>,
    /// The index of the last file to request.
    last_index: AtomicUsize,
}

impl HangWatch {
    /// Creates a watch for the legal files at these indices, which must be in ascending order.
    pub fn new(legal: Vec<usize>) -> HangWatch {
        HangWatch {
            timed_out: Mutex::new(vec![None; legal.len()]),
            legal,
            last_index: AtomicUsize::new(usize::MAX),
        }
    }

    /// Records an answer, and ends the run if the decoder timed out on three consecutive legal files. Files are consecutive by
    /// index, regardless of the order of their answers.
    pub fn record_answer(&self, index: usize, is_hang: bool, tally: &Tally) {
        let Ok(rank) = self.legal.binary_search(&index) else {
            return;
        };
        let mut timed_out = self.timed_out.lock().expect("no worker panics");
        timed_out[rank] = Some(is_hang && timed_out[rank] != Some(false));
        let near = rank.saturating_sub(MAX_CONSECUTIVE_HANGS - 1);
        let rows = timed_out[near..].windows(MAX_CONSECUTIVE_HANGS);
        let mut rows = rows.take(MAX_CONSECUTIVE_HANGS);
        if let Some(row) = rows.position(|row| row.iter().all(|file| *file == Some(true))) {
            let last = self.legal[near + row + MAX_CONSECUTIVE_HANGS - 1];
            self.last_index.fetch_min(last, Relaxed);
            tally.too_many_hangs.store(true, Relaxed);
        }
    }

    /// Returns the index of the last file to request, or `None` if the run continues.
    pub fn last(&self) -> Option<usize> {
        Some(self.last_index.load(Relaxed)).filter(|&last| last < usize::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The files at even indices are legal. The first request for file 12 is answered in time.
    #[test]
    fn three_hangs_in_a_row_end_a_run_in_any_order_of_answers() {
        let backward: Vec<usize> = (0..20).rev().collect();
        let forward: Vec<usize> = (0..20).collect();
        for (asked, hanging, end) in [
            (&forward[..], &[4, 6, 8][..], Some(8)),
            (&backward, &[4, 6, 8], Some(8)),
            (&[8, 0, 4, 2, 6], &[4, 6, 8], Some(8)),
            (&backward, &[4, 6, 8, 10, 12, 14], Some(8)),
            (&[0, 2, 2, 4], &[0, 2, 4], Some(4)),
            // Other files in between, malformed files, or an answer in a different view.
            (&forward, &[4, 6, 10, 12, 18], None),
            (&[4, 6, 10, 8], &[4, 6, 10], None),
            (&forward, &[1, 3, 5, 7, 9, 11], None),
            (&[10, 12, 12, 14], &[10, 12, 14], None),
            (&forward, &[14, 16, 18], Some(18)),
        ] {
            let tally = Tally::default();
            let watch = HangWatch::new((0..20).step_by(2).collect());
            let mut in_time = Some(12);
            for &index in asked {
                let is_hang =
                    hanging.contains(&index) && in_time.take_if(|of| *of == index).is_none();
                watch.record_answer(index, is_hang, &tally);
            }
            assert_eq!(watch.last(), end);
            assert_eq!(tally.too_many_hangs.into_inner(), end.is_some());
        }
    }
}
