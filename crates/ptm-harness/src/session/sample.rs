//! Which cases are requested first, and which are not requested because the decoder lacks a feature.
//!
//! Of each feature, a few files are requested first. If the decoder answers the legal ones with exit status 69, its other files
//! are not requested: they would say the same, and most of a run would consist of them.

use std::collections::{BTreeMap, BTreeSet};

use ptm_suite::cases::{Expect, Suite};
use ptm_suite::features::Feature;
use ptm_suite::test_case::TestCase;
use ptm_suite::verdicts::{observation::Response, offer::Offer};

use crate::session::run::ObservationsOf;

/// Number of ordinary legal files of each feature that are requested first.
const ORDINARY: usize = 4;

/// Number of malformed files of each feature that are requested first.
const MALFORMED: usize = 2;

/// Minimum number of legal files that the decoder must answer with 69 before a feature counts as lacking.
const MIN_LEGAL: usize = 2;

/// Features that a decoder lacks, each with the cases that are not requested for that reason.
pub type NotAsked<F = Feature> = Vec<(F, Vec<usize>)>;

/// The cases that are still to be requested, and the features that the decoder lacks.
pub(crate) struct Sample<'a, C: TestCase> {
    suite: &'a Suite<C>,
    /// The features of each case, in the view in which it is requested.
    features: BTreeMap<usize, BTreeSet<Feature>>,
    /// The features that the decoder lacks, each with the cases that are not requested for that reason.
    pub lacking: NotAsked,
}

impl<'a, C: TestCase> Sample<'a, C> {
    /// Creates a sample of these cases.
    pub fn new(suite: &'a Suite<C>, offer: &Offer, cases: &[usize]) -> Sample<'a, C> {
        let features = |&i: &usize| {
            let case: &C = &suite.cases[i];
            let view = offer.chosen_view(case);
            (
                i,
                view.map_or_else(BTreeSet::new, |view| case.features(view)),
            )
        };
        Sample {
            suite,
            features: cases.iter().map(features).collect(),
            lacking: Vec::new(),
        }
    }

    /// Returns all features of the cases: the formats first.
    pub fn all_features(&self) -> BTreeSet<Feature> {
        self.features.values().flatten().cloned().collect()
    }

    /// Returns the cases that are still to be requested.
    pub fn cases(&self) -> impl Iterator<Item = usize> {
        self.features.keys().copied()
    }

    /// Returns the files of a feature that are requested first: ordinary legal files, of all formats if possible, the smallest one,
    /// and malformed files. An ordinary file needs few other features.
    pub fn of_feature(&self, feature: &Feature) -> Vec<usize> {
        let mut legal = self.with_feature(feature, |expect| expect == Expect::Decode);
        let smallest = legal
            .iter()
            .copied()
            .min_by_key(|&i| self.suite.cases[i].texels().unwrap_or(u64::MAX));
        legal.sort_by_key(|i| self.features[i].len());
        let ordinary = self.interleave_kinds(&legal).into_iter().take(ORDINARY);
        let malformed = self.with_feature(feature, Expect::is_refusal);
        let malformed = self
            .interleave_kinds(&malformed)
            .into_iter()
            .take(MALFORMED);
        let all: BTreeSet<usize> = ordinary.chain(smallest).chain(malformed).collect();
        all.into_iter().collect()
    }

    fn with_feature(&self, feature: &Feature, is_wanted: fn(Expect) -> bool) -> Vec<usize> {
        let has = |(&i, features): (&usize, &BTreeSet<Feature>)| {
            (features.contains(feature) && is_wanted(self.suite.cases[i].expect())).then_some(i)
        };
        self.features.iter().filter_map(has).collect()
    }

    /// Reorders cases: the first of each kind, then the second of each, and so on.
    fn interleave_kinds(&self, cases: &[usize]) -> Vec<usize> {
        let mut ranks: BTreeMap<Feature, usize> = BTreeMap::new();
        let mut ranked: Vec<(usize, usize)> = Vec::new();
        for &i in cases {
            let rank = ranks.entry(self.suite.cases[i].kind()).or_default();
            ranked.push((*rank, i));
            *rank += 1;
        }
        ranked.sort_by_key(|&(rank, _)| rank);
        ranked.into_iter().map(|(_, i)| i).collect()
    }

    /// Withholds the other cases that need this feature if the decoder answered all legal files that need it with 69.
    pub fn withhold_if_lacking(&mut self, feature: &Feature, observations: &ObservationsOf<C>) {
        let legal = self.with_feature(feature, |expect| expect == Expect::Decode);
        let seen: Vec<_> = legal
            .iter()
            .filter_map(|&i| observations[i].as_ref())
            .collect();
        let is_lacking = seen.len() >= MIN_LEGAL.min(legal.len())
            && !seen.is_empty()
            && seen
                .iter()
                .all(|seen| matches!(seen.response, Response::Unsupported));
        if !is_lacking {
            return;
        }
        let mut withheld = Vec::new();
        self.features.retain(|&i, features| {
            let stays = observations[i].is_some() || !features.contains(feature);
            if !stays {
                withheld.push(i);
            }
            stays
        });
        if !withheld.is_empty() {
            self.lacking.push((feature.clone(), withheld));
        }
    }

    /// Returns the cases to request next: the prioritized ones, and the first case of each clause that neither these nor the
    /// requested ones test.
    pub fn of_every_clause(
        &self,
        prioritized: &[bool],
        observations: &ObservationsOf<C>,
    ) -> Vec<usize> {
        let is_first = |i: &usize| prioritized.get(*i) == Some(&true) || observations[*i].is_some();
        let (first, others): (Vec<usize>, Vec<usize>) = self.cases().partition(is_first);
        let clauses = |i: usize| self.suite.cases[i].clauses().iter();
        let mut tested: BTreeSet<&String> = first.iter().copied().flat_map(clauses).collect();
        let mut chosen: Vec<usize> = first;
        for i in others {
            if clauses(i).any(|clause| !tested.contains(clause)) {
                tested.extend(clauses(i));
                chosen.push(i);
            }
        }
        chosen.retain(|&i| observations[i].is_none());
        chosen.sort_unstable();
        chosen
    }
}
