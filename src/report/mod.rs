//! The report, and every word that the user of `check` reads.
//!
//! A report is a plain value ([`document`]); YAML, text and all other forms are ways of writing it, whatever the suite.

pub mod document;

mod make;

mod leniency;

pub mod reported;

mod words;

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
