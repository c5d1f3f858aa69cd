//! Reports and all other text that a user of `check` reads.
//!
//! A report is plain data ([`document`]). YAML, text and the other output formats are generated from it and work for all suites.

pub mod badge;
pub mod baseline;
mod diff;
pub mod document;
pub mod github;
pub mod html;
pub mod junit;
mod leniency;
pub(crate) mod make;
pub mod shards;
pub mod suite_texts;
pub mod text;
pub mod words;
mod yaml;

pub use document::Report;
