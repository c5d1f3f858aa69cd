//! Greedy set cover: finds a small set of causes that together explain the failures.
//!
//! - The candidate that explains the most failures is chosen first, then the best candidate for the remaining failures.
//! - A candidate is chosen last unless more failures support it than passing cases contradict it.
//! - Ties are broken in favor of fewer contradictions, then by order in the list.
//! - Candidates that explain the same failures and have the same contradictions are equivalent: no case distinguishes them.

use std::cmp::Reverse;

use super::diagnosis::{Cause, Diagnosis};
use ptm_mistakes::Misreading;

/// A possible cause, with the cases that support and contradict it.
pub struct CoverCandidate<T> {
    /// The candidate.
    pub cause: T,
    /// Suite indices of the failing cases that the candidate reproduces.
    pub explains: Vec<usize>,
    /// Suite indices of the passing cases that a decoder with this mistake would fail.
    pub contradicted: Vec<usize>,
    /// Causes that no case distinguishes from this cause. Filled in by [`cover`].
    pub equivalents: Vec<T>,
}

impl<T> CoverCandidate<T> {
    /// Tests `cause` against the failing and the passing cases. Returns `None` if the cause explains no failure.
    pub fn new(
        cause: T,
        failing: &[usize],
        explains: impl Fn(usize) -> bool,
        passing: &[usize],
        contradicts: impl Fn(usize) -> bool,
    ) -> Option<CoverCandidate<T>> {
        let select = |all: &[usize], holds: &dyn Fn(usize) -> bool| -> Vec<usize> {
            all.iter().copied().filter(|&case| holds(case)).collect()
        };
        let explains = select(failing, &explains);
        (!explains.is_empty()).then(|| CoverCandidate {
            cause,
            explains,
            contradicted: select(passing, &contradicts),
            equivalents: Vec::new(),
        })
    }

    /// Returns true if more failures support the candidate than passing cases contradict it.
    pub fn is_supported(&self) -> bool {
        self.explains.len() > self.contradicted.len()
    }
}

impl<A> CoverCandidate<&'static Misreading<A>> {
    /// Converts the candidate to a diagnosis.
    #[must_use]
    pub fn diagnosis(self) -> Diagnosis<A> {
        let cause = Cause::Misreading {
            misreading: self.cause,
            equivalents: self.equivalents,
            accompanying: Vec::new(),
        };
        Diagnosis {
            is_certain: self.contradicted.is_empty(),
            contradicted_by: self.contradicted,
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
        let best = (0..candidates.len()).min_by_key(|&i| {
            let candidate = &candidates[i];
            let (explained, contradicted) = (&candidate.explains, &candidate.contradicted);
            let order = (Reverse(explained.len()), contradicted.len());
            (!candidate.is_supported(), order)
        });
        let Some(best) = best else {
            return chosen;
        };
        let mut best = candidates.remove(best);
        let others = candidates.iter().filter(|other| {
            other.explains == best.explains && other.contradicted == best.contradicted
        });
        best.equivalents = others.map(|other| other.cause).collect();
        failing.retain(|case| !best.explains.contains(case));
        chosen.push(best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(cause: char, explains: &[usize], contradicted: &[usize]) -> CoverCandidate<char> {
        CoverCandidate {
            cause,
            explains: explains.to_vec(),
            contradicted: contradicted.to_vec(),
            equivalents: Vec::new(),
        }
    }

    #[test]
    fn cover_chooses_the_largest_candidate_first() {
        let mut failing = vec![1, 2, 3, 4, 5];
        let candidates = vec![
            candidate('a', &[1, 2], &[]),
            candidate('b', &[1, 2, 3], &[]),
            candidate('c', &[3, 4], &[]),
        ];
        let chosen = cover(candidates, &mut failing);
        let causes: Vec<char> = chosen.iter().map(|candidate| candidate.cause).collect();
        assert_eq!((causes, failing), (vec!['b', 'c'], vec![5]));
    }

    #[test]
    fn contradicted_candidates_come_last() {
        let mut failing = vec![1, 2];
        let candidates = vec![
            candidate('a', &[1, 2], &[7, 8]),
            candidate('b', &[1], &[]),
            candidate('c', &[1], &[]),
        ];
        let chosen = cover(candidates, &mut failing);
        let causes = chosen.into_iter().map(|c| (c.cause, c.equivalents));
        assert_eq!(
            causes.collect::<Vec<_>>(),
            [('b', vec!['c']), ('a', vec![])]
        );
    }
}
