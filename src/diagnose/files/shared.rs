//! What files that were treated alike share, and no file has that was treated otherwise.

use super::scope::Scope;
use super::traits::{QUANTITIES, TRAITS, traits};
use crate::diagnose::witness::Witness;

/// A trait of fewer files is none.
const FEWEST: usize = 2;
/// Files of one size must be so many to bound those of others.
const FEWEST_BESIDE: usize = 3;
/// Two traits together are said of no fewer files: among so many pairs some fit by chance.
const FEWEST_OF_BOTH: usize = 8;
/// Pairs of traits among which the widest is looked for.
const MOST_PAIRS: usize = 64;
/// A trait is said where one in so many suites would have such a trait by chance.
const CHANCE: f64 = 50.0;

/// What files share.
pub(in crate::diagnose) struct Shared {
    pub scope: Scope,
    /// Which files.
    pub of: Vec<usize>,
}

impl Shared {
    /// Completes "files …".
    pub fn says(&self) -> String {
        self.scope.says()
    }
}

/// Two groups of files, and what is known of each.
struct Groups<'a> {
    witnesses: &'a [Witness<'a>],
    these: &'a [usize],
    others: &'a [usize],
    /// For each trait that may be said, its place and which of `these` have it.
    having: Vec<(usize, Vec<bool>)>,
}

/// What most of `these` share and none of `others` has. It may be the view that was asked for, if `with_view`.
pub(in crate::diagnose) fn shared(
    witnesses: &[Witness],
    these: &[usize],
    others: &[usize],
    with_view: bool,
) -> Option<Shared> {
    let places = (0..TRAITS.len()).filter(|&one| with_view || !TRAITS[one].is_view);
    let has = |one: usize| {
        these
            .iter()
            .map(|&w| traits(&witnesses[w]).has[one])
            .collect()
    };
    let having = places.map(|one| (one, has(one)));
    let groups = Groups {
        witnesses,
        these,
        others,
        having: having
            .filter(|(_, has): &(usize, Vec<bool>)| has.contains(&true))
            .collect(),
    };
    let single = groups.single().into_iter().chain(groups.thresholds());
    let single = largest(single.collect());
    let count = single.as_ref().map_or(0, |single| single.of.len());
    // Two together must say clearly more than one alone.
    if count * 4 >= these.len() * 3 {
        return single;
    }
    groups.both().or(single)
}

/// The one of most files; among equals the first.
fn largest(found: Vec<Shared>) -> Option<Shared> {
    let most = found.iter().map(|shared| shared.of.len()).max()?;
    found.into_iter().find(|shared| shared.of.len() == most)
}

impl Groups<'_> {
    /// The files of `these` for which `has` is true.
    fn select(&self, has: impl Iterator<Item = bool>) -> Vec<usize> {
        let pairs = self.these.iter().zip(has);
        pairs.filter_map(|(&w, has)| has.then_some(w)).collect()
    }

    /// Whether so many files alone are no coincidence: each other file could have been among them.
    fn is_telling(&self, count: usize) -> bool {
        let part = self.these.len() as f64 / (self.these.len() + self.others.len()) as f64;
        count >= FEWEST && part.powi(count as i32) * self.having.len() as f64 * CHANCE < 1.0
    }

    /// Traits that none of the others has.
    fn single(&self) -> Vec<Shared> {
        let absent = |one: usize| {
            let mut others = self.others.iter();
            !others.any(|&w| traits(&self.witnesses[w]).has[one])
        };
        let found = self
            .having
            .iter()
            .map(|(one, has)| (*one, self.select(has.iter().copied())));
        found
            .filter(|(one, of)| self.is_telling(of.len()) && absent(*one))
            .map(|(one, of)| Shared {
                scope: Scope::Trait(one),
                of,
            })
            .collect()
    }

    /// Two traits that all of these files have and none of the others has both of; nothing where several pairs would do of which
    /// none follows from another.
    fn both(&self) -> Option<Shared> {
        if self.these.len() < FEWEST_OF_BOTH || !self.is_telling(self.these.len() / 2) {
            return None;
        }
        let all = self.having.iter().filter(|(_, has)| !has.contains(&false));
        let all: Vec<usize> = all.map(|(one, _)| *one).collect();
        let others: Vec<&[bool]> = self
            .others
            .iter()
            .map(|&w| &traits(&self.witnesses[w]).has[..])
            .collect();
        // Traits that tell the same of all these files are one.
        let is_first = |&k: &usize| {
            let same = |j: &usize| others.iter().all(|has| has[all[*j]] == has[all[k]]);
            !(0..k).any(|j| same(&j))
        };
        let all: Vec<usize> = (0..all.len()).filter(is_first).map(|k| all[k]).collect();
        let is_pair = |&(a, b): &(usize, usize)| !others.iter().any(|has| has[a] && has[b]);
        let pairs = all
            .iter()
            .enumerate()
            .flat_map(|(i, &a)| all[i + 1..].iter().map(move |&b| (a, b)));
        let pairs: Vec<(usize, usize)> = pairs.filter(is_pair).take(MOST_PAIRS).collect();
        // A pair that follows from a wider one says no more than that.
        let implies = |a: usize, b: usize| others.iter().all(|has| !has[a] || has[b]);
        let is_wider = |&(a, b): &(usize, usize), &(c, d): &(usize, usize)| {
            (a, b) != (c, d) && (implies(a, c) && implies(b, d) || implies(a, d) && implies(b, c))
        };
        let mut widest =
            (pairs.iter()).filter(|one| !pairs.iter().any(|other| is_wider(one, other)));
        match (widest.next(), widest.next()) {
            (Some(&(a, b)), None) if pairs.len() < MOST_PAIRS => Some(Shared {
                scope: Scope::Both(a, b),
                of: self.these.to_vec(),
            }),
            _ => None,
        }
    }

    /// Quantities over which, or under which, there is none of the others.
    fn thresholds(&self) -> Vec<Shared> {
        let mut found = Vec::new();
        for place in 0..QUANTITIES.len() {
            let quantity = |w: usize| traits(&self.witnesses[w]).quantities[place];
            let theirs: Vec<f64> = self.others.iter().filter_map(|&w| quantity(w)).collect();
            let (least, most) = theirs
                .iter()
                .fold((f64::MAX, f64::MIN), |(a, b), &x| (a.min(x), b.max(x)));
            // One number alone that is read may be another matter.
            if theirs.is_empty() || least == most && theirs.len() < FEWEST_BESIDE {
                continue;
            }
            for (more, edge) in [(true, most), (false, least)] {
                let beyond = |x: f64| if more { x > edge } else { x < edge };
                let these = self.these.iter().copied();
                let of: Vec<(usize, f64)> = these
                    .filter_map(|w| Some((w, quantity(w)?)))
                    .filter(|&(_, x)| beyond(x))
                    .collect();
                let values = of.iter().map(|&(_, x)| x);
                let nearest = values.min_by(|a, b| (a - edge).abs().total_cmp(&(b - edge).abs()));
                // A size goes with much else: what only some of these share is another thing.
                let sized = self.these.iter().filter_map(|&w| quantity(w)).count();
                let is_telling = self.is_telling(of.len()) && of.len() == sized;
                let Some(nearest) = nearest.filter(|_| is_telling) else {
                    continue;
                };
                found.push(Shared {
                    scope: Scope::Beyond {
                        quantity: place,
                        nearest,
                        more,
                        edge,
                    },
                    of: of.into_iter().map(|(w, _)| w).collect(),
                });
            }
        }
        found
    }
}
