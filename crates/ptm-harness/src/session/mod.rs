//! The stages of a run, from first contact to the verdicts. [`pipeline::check`](crate::pipeline::check) calls them in order.
//!
//! All requests for PTM files, to decode or to write, are [`TestCase`](ptm_suite::test_case::TestCase)s. Texture questions have
//! stages of their own ([`texture`]).

pub mod asking;
pub mod contact;
mod curve;
pub mod files;
pub mod lit_scene;
pub mod locale;
pub mod outputs;
pub mod plan;
pub mod probe;
pub mod remark;
pub mod run;
pub mod sample;
mod schedule;
mod tally;
pub mod texture;
pub mod texture_stage;
pub mod transform;
