//! A run from first contact to the last answer, and the verdicts.
//!
//! [`run::check`] is the contents page. Whatever is asked, PTM files or texture questions, is a
//! [`TestCase`](crate::suite::test_case::TestCase).

pub mod run;

pub mod plan;

pub mod asking;

pub mod contact;

mod spelling;

mod again;

pub mod observation;

pub mod offer;

pub mod outcome;

pub mod judge;

pub mod dialect;

pub mod scores;

pub mod remark;

mod tally;

pub mod lit_scene;

pub mod texture_stage;

pub mod transform;

mod curve;

pub mod locale;

pub mod outputs;

pub mod files;

pub mod metamorphic;

#[cfg(test)]
mod other_transforms;

pub mod probe;
