//! Verdicts: from the observations of a run to the outcome of each case.

pub mod dialect;
pub mod judge;
pub mod observation;
pub mod offer;
pub mod outcome;
pub mod scores;
