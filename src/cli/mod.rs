//! The subcommands: their arguments, what they print, and their exit status; a file for each.
//!
//! Commands that start somebody else's program need a Unix system; all others run everywhere.

#![allow(clippy::doc_markdown, reason = "help is printed as it stands")]

pub mod files;

pub mod output;

#[cfg(unix)]
mod arguments;

#[cfg(unix)]
pub mod guard;

#[cfg(unix)]
mod partial;

#[cfg(unix)]
pub mod check;

#[cfg(unix)]
mod subject;

#[cfg(unix)]
mod own_files;

#[cfg(unix)]
mod known_failures;

#[cfg(unix)]
mod renderings;

#[cfg(not(unix))]
pub mod elsewhere;

pub mod reference;

pub mod generate;

pub mod explain;

#[cfg(unix)]
pub mod probe;

#[cfg(unix)]
pub mod report;

#[cfg(unix)]
pub mod fuzz;

#[cfg(unix)]
pub mod coverage;

#[cfg(unix)]
pub mod texture;

pub mod inspect;

pub mod lint;

pub mod render;

pub mod export;

pub mod convert;

pub mod diff;

pub mod completions;

/// What a subcommand ends with: its exit status, or a sentence for wrong usage.
pub type Outcome = Result<u8, String>;

/// Wrong arguments, or a file that cannot be read or written.
pub const EXIT_USAGE: u8 = 2;

/// Nothing was selected, so nothing was checked.
#[cfg(unix)]
pub const EXIT_NOTHING_SELECTED: u8 = 5;
