//! A run, from first contact to the verdicts.
//!
//! Start with [`run::check`], which calls all stages in order. All requests, for PTM files or texture questions, are
//! [`TestCase`](ptm_suite::test_case::TestCase)s.

mod again;
pub mod asking;
pub mod contact;
mod curve;
pub mod dialect;
pub mod files;
pub mod judge;
pub mod lit_scene;
pub mod locale;
pub mod observation;
pub mod offer;
#[cfg(test)]
mod other_transforms;
pub mod outcome;
pub mod outputs;
pub mod plan;
pub mod probe;
pub mod remark;
pub mod run;
pub mod scores;
mod tally;
pub mod texture_stage;
#[cfg(test)]
mod texture_unit;
pub mod transform;
