//! Minimizes something step by step while a decoder still fails on it in the same way.

use std::sync::atomic::{AtomicBool, Ordering};

/// Maximum number of requests for one file.
const MAX_REQUESTS: usize = 3000;

/// Returns the lightest candidate reached from `best` by steps after each of which it still `fails`.
///
/// The lightest step is tried first, so that one that halves the image precedes one that simplifies a number. A candidate
/// without a weight cannot be written and is skipped.
pub(super) fn shrink<T, W: Ord>(
    mut best: T,
    weigh: impl Fn(&T) -> Option<W>,
    steps: impl Fn(&T) -> Vec<T>,
    stop: &AtomicBool,
    fails: impl Fn(&T) -> bool,
) -> T {
    let mut weight = weigh(&best);
    let mut asked = 0;
    loop {
        let mut lighter: Vec<(W, T)> = steps(&best)
            .into_iter()
            .filter_map(|candidate| Some((weigh(&candidate)?, candidate)))
            .filter(|(lighter, _)| weight.as_ref().is_none_or(|weight| lighter < weight))
            .collect();
        lighter.sort_by(|a, b| a.0.cmp(&b.0));
        let next = lighter.into_iter().find(|(_, candidate)| {
            asked += 1;
            asked <= MAX_REQUESTS && !stop.load(Ordering::Relaxed) && fails(candidate)
        });
        match next {
            Some((lighter, candidate)) => (weight, best) = (Some(lighter), candidate),
            None => return best,
        }
    }
}
