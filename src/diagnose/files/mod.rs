//! What files that a decoder treats alike have in common.

pub(super) mod scope;
pub(super) mod shared;
pub(super) mod trait_list;
mod traits;
