//! The report, and all words that the user of `check` reads.
//!
//! A report is plain data ([`document`]); YAML, text and all other forms are output formats, for all suites.

pub mod document;

pub(crate) mod make;

mod leniency;

pub mod reported;

pub mod words;

pub mod text;

mod yaml;

mod diff;

pub mod baseline;

pub mod conclude;

pub mod shards;

pub mod merge;

pub mod html;

pub mod junit;

pub mod github;

pub mod badge;

pub use document::Report;
