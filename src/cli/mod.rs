//! The subcommands: their arguments, what they print, and their exit status; a file for each.

#![allow(clippy::doc_markdown, reason = "help is printed as it stands")]

pub mod files;

pub mod output;

pub mod profile;

pub mod explain;

pub mod inspect;

pub mod lint;

pub mod render;

pub mod export;

pub mod convert;

pub mod diff;

pub mod completions;

#[cfg(unix)]
pub mod fuzz;

#[cfg(not(unix))]
pub mod elsewhere;

/// What a subcommand ends with: its exit status, or a sentence for wrong usage.
pub type Outcome = Result<u8, String>;
