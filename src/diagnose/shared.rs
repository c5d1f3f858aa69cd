//! What files that were treated alike share, and no file has that was treated otherwise.

use super::scope::Scope;
use super::traits::{QUANTITIES, TRAITS, traits};
use super::witness::Witness;

/// A trait of fewer files is none.
const FEWEST: usize = 2;
/// Two traits together are said of no fewer files, and only of all of them: among so many pairs some fit by chance.
const FEWEST_OF_BOTH: usize = 8;
/// A trait is said where one in so many suites would have such a trait by chance.
const CHANCE: f64 = 50.0;

/// What files share.
pub(super) struct Shared {
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
pub(super) fn shared(
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
    groups.both(count).or(single)
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

    /// Two traits that none of the others has both of, of more files than `known`.
    fn both(&self, known: usize) -> Option<Shared> {
        let mut best: Option<Shared> = None;
        for (i, (a, has_a)) in self.having.iter().enumerate() {
            for (b, has_b) in &self.having[i + 1..] {
                let count = has_a.iter().zip(has_b).filter(|(a, b)| **a && **b).count();
                let most = best.as_ref().map_or(known, |best| best.of.len());
                let enough = count >= FEWEST_OF_BOTH && count == self.these.len();
                if count <= most || !enough || !self.is_telling(count / 2) {
                    continue;
                }
                let has_both = |&w: &usize| {
                    let has = &traits(&self.witnesses[w]).has;
                    has[*a] && has[*b]
                };
                if !self.others.iter().any(has_both) {
                    let has = has_a.iter().zip(has_b).map(|(a, b)| *a && *b);
                    best = Some(Shared {
                        scope: Scope::Both(*a, *b),
                        of: self.select(has),
                    });
                }
            }
        }
        best
    }

    /// Quantities over which, or under which, there is none of the others.
    fn thresholds(&self) -> Vec<Shared> {
        let mut found = Vec::new();
        for place in 0..QUANTITIES.len() {
            let of = |w: usize| traits(&self.witnesses[w]).quantities[place];
            let theirs: Vec<f64> = self.others.iter().filter_map(|&w| of(w)).collect();
            let (least, most) = theirs
                .iter()
                .fold((f64::MAX, f64::MIN), |(a, b), &x| (a.min(x), b.max(x)));
            if theirs.is_empty() {
                continue;
            }
            for (more, edge) in [(true, most), (false, least)] {
                let beyond = |x: f64| if more { x > edge } else { x < edge };
                let these = self.these.iter().copied();
                let of: Vec<(usize, f64)> = these
                    .filter_map(|w| Some((w, of(w)?)))
                    .filter(|&(_, x)| beyond(x))
                    .collect();
                let values = of.iter().map(|&(_, x)| x);
                let nearest = values.min_by(|a, b| (a - edge).abs().total_cmp(&(b - edge).abs()));
                let Some(nearest) = nearest.filter(|_| self.is_telling(of.len())) else {
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
