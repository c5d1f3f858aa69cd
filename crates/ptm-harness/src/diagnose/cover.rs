//! Greedy set cover: finds a small set of causes that together explain the failures.
//!
//! - The candidate that explains the most failures is chosen first, then the best candidate for the remaining failures.
//! - A passing case that a decoder with the mistake would fail contradicts the candidate. It is not chosen.
//! - Ties are broken by the order in the list.
//! - Candidates that explain the same failures are equivalent: no case distinguishes them.

use super::diagnosis::{Cause, Diagnosis};
use ptm_mistakes::Misreading;

/// A possible cause, with the cases that support it.
pub struct CoverCandidate<T> {
    /// The candidate.
    pub cause: T,
    /// Suite indices of the failing cases that the candidate reproduces.
    pub explains: Vec<usize>,
    /// Causes that no case distinguishes from this cause. Filled in by [`cover`].
    pub equivalents: Vec<T>,
}

impl<T> CoverCandidate<T> {
    /// Tests `cause` against the failing and the passing cases. Returns `None` if it explains no failure, or if a passing case
    /// contradicts it.
    pub fn new(
        cause: T,
        failing: &[usize],
        explains: impl Fn(usize) -> bool,
        passing: &[usize],
        contradicts: impl Fn(usize) -> bool,
    ) -> Option<CoverCandidate<T>> {
        let explains: Vec<usize> = failing
            .iter()
            .copied()
            .filter(|&case| explains(case))
            .collect();
        let is_possible = !explains.is_empty() && !passing.iter().any(|&case| contradicts(case));
        is_possible.then(|| CoverCandidate {
            cause,
            explains,
            equivalents: Vec::new(),
        })
    }
}

impl<A> CoverCandidate<&'static Misreading<A>> {
    /// Converts the candidate to a diagnosis.
    #[must_use]
    pub fn diagnosis(self) -> Diagnosis<A> {
        let cause = Cause::Misreading {
            misreading: self.cause,
            equivalents: self.equivalents,
        };
        Diagnosis {
            is_mechanism: true,
            ..Diagnosis::new(cause, self.explains)
        }
    }
}

/// Returns candidates, chosen one by one until none explains any case in `failing`. Removes the explained cases from `failing`.
pub fn cover<T: Copy>(
    mut candidates: Vec<CoverCandidate<T>>,
    failing: &mut Vec<usize>,
) -> Vec<CoverCandidate<T>> {
    let mut chosen = Vec::new();
    loop {
        for candidate in &mut candidates {
            candidate.explains.retain(|case| failing.contains(case));
        }
        candidates.retain(|candidate| !candidate.explains.is_empty());
        // `max_by_key` returns the last maximum.
        let best = (0..candidates.len())
            .rev()
            .max_by_key(|&i| candidates[i].explains.len());
        let Some(best) = best else {
            return chosen;
        };
        let mut best = candidates.remove(best);
        let others = candidates
            .iter()
            .filter(|other| other.explains == best.explains);
        best.equivalents = others.map(|other| other.cause).collect();
        failing.retain(|case| !best.explains.contains(case));
        chosen.push(best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(cause: char, explains: &[usize]) -> CoverCandidate<char> {
        CoverCandidate {
            cause,
            explains: explains.to_vec(),
            equivalents: Vec::new(),
        }
    }

    #[test]
    fn cover_chooses_the_largest_candidate_first() {
        let mut failing = vec![1, 2, 3, 4, 5];
        let candidates = vec![
            candidate('a', &[1, 2]),
            candidate('b', &[1, 2, 3]),
            candidate('c', &[3, 4]),
        ];
        let chosen = cover(candidates, &mut failing);
        let causes: Vec<char> = chosen.iter().map(|candidate| candidate.cause).collect();
        assert_eq!((causes, failing), (vec!['b', 'c'], vec![5]));
    }

    #[test]
    fn candidates_with_the_same_failures_are_equivalent() {
        let mut failing = vec![1, 2];
        let candidates = vec![
            candidate('b', &[1]),
            candidate('c', &[1]),
            candidate('a', &[2]),
        ];
        let chosen = cover(candidates, &mut failing);
        let causes = chosen.into_iter().map(|c| (c.cause, c.equivalents));
        assert_eq!(
            causes.collect::<Vec<_>>(),
            [('b', vec!['c']), ('a', vec![])]
        );
    }

    #[test]
    fn a_contradicted_candidate_is_dropped() {
        let is_one = |case| case == 1;
        assert!(CoverCandidate::new('a', &[1, 2], is_one, &[3], |_| false).is_some());
        assert!(CoverCandidate::new('a', &[1, 2], is_one, &[3], |_| true).is_none());
        assert!(CoverCandidate::new('a', &[2], is_one, &[3], |_| false).is_none());
    }
}
