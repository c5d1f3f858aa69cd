//! A mistake that a decoder may make: one of the catalog, everywhere or in some files, or one solved from its answers.

use super::files::scope::Scope;
use super::solved::Solved;
use crate::misreadings::Misreading;

pub(super) enum Mistake {
    Listed(&'static Misreading),
    /// Made in some files only.
    Narrow(&'static Misreading, Scope),
    Solved(Solved),
}

impl Mistake {
    pub const fn listed(&self) -> Option<&'static Misreading> {
        match self {
            Mistake::Listed(misreading) | Mistake::Narrow(misreading, _) => Some(misreading),
            Mistake::Solved(_) => None,
        }
    }

    pub const fn solved(&self) -> Option<&Solved> {
        match self {
            Mistake::Listed(_) | Mistake::Narrow(..) => None,
            Mistake::Solved(solved) => Some(solved),
        }
    }
}
