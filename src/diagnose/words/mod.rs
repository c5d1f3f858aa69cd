//! What no mistake explains, put into words.

pub(super) mod acceptances;
pub(super) mod formats;
pub(super) mod nondeterminism;
pub(super) mod pictures;
mod places;
pub(super) mod promises;
pub(super) mod refusals;
pub(super) mod violation;
