//! Step-by-step minimization of an input that makes a decoder fail.

use std::sync::atomic::{AtomicBool, Ordering};

use ptm::Size;

/// Maximum number of requests for one file.
const MAX_REQUESTS: usize = 3000;

/// Repeatedly replaces `best` with a lighter candidate that still `fails`, and returns the last such candidate.
///
/// The lightest candidate is tried first, so a step that halves the image precedes a step that simplifies a number. A
/// candidate without a weight cannot be written and is skipped.
pub(super) fn shrink<T, W: Ord>(
    mut best: T,
    weigh: impl Fn(&T) -> Option<W>,
    steps: impl Fn(&T) -> Vec<T>,
    stop: &AtomicBool,
    fails: impl Fn(&T) -> bool,
) -> T {
    let mut weight = weigh(&best);
    let mut request_count = 0;
    loop {
        let mut lighter: Vec<(W, T)> = steps(&best)
            .into_iter()
            .filter_map(|candidate| Some((weigh(&candidate)?, candidate)))
            .filter(|(lighter, _)| weight.as_ref().is_none_or(|weight| lighter < weight))
            .collect();
        lighter.sort_by(|a, b| a.0.cmp(&b.0));
        let next = lighter.into_iter().find(|(_, candidate)| {
            request_count += 1;
            request_count <= MAX_REQUESTS && !stop.load(Ordering::Relaxed) && fails(candidate)
        });
        match next {
            Some((lighter, candidate)) => (weight, best) = (Some(lighter), candidate),
            None => return best,
        }
    }
}

pub(super) fn smaller_sizes(Size { width, height }: Size) -> Vec<Size> {
    let smaller = |side: u32| {
        let steps = [1, 2, side / 2, side - side / 4];
        let steps = steps
            .into_iter()
            .chain([8, 1].map(|difference| side.saturating_sub(difference)));
        let mut sides: Vec<u32> = steps.filter(|new| (1..side).contains(new)).collect();
        sides.push(side);
        sides.dedup();
        sides
    };
    let heights = smaller(height);
    let sizes = smaller(width).into_iter().flat_map(|width| {
        let heights = heights.iter();
        heights.map(move |&height| Size { width, height })
    });
    sizes
        .filter(|new| (new.width, new.height) != (width, height))
        .collect()
}
