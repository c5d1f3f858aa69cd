//! What a decoder computes of right values: other numbers, other formulas, other bits.

pub mod arithmetic;
pub(super) mod changes;
pub(super) mod color_rules;
pub(super) mod final_rules;
pub(super) mod formulas;
pub(super) mod grid;
pub(super) mod number_readers;
pub(super) mod numbers;
pub(super) mod powers;
pub(super) mod relations;
pub(super) mod solve_powers;
pub(super) mod solve_terms;
pub(super) mod terms;
pub(super) mod variants;
