//! The report of a check as a value.
//!
//! A report is plain data ([`document`]). YAML, text and the other output formats are generated from it and work for all suites.

pub mod baseline;
mod diff;
pub mod document;
pub mod leniency;
pub(crate) mod make;
pub mod shards;
pub mod suite_texts;
pub mod words;
mod yaml;

pub use document::Report;
