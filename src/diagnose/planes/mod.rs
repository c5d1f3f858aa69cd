//! How planes are rebuilt from their streams (§2.9.2 – 2.9.5, 2.9.8): each decision taken otherwise, and where.

mod means;
mod places;
pub(super) mod rest;
pub(super) mod rules;
pub(super) mod slips;
pub(super) mod solve;
