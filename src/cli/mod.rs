//! The subcommands: their arguments, what they print, and their exit status; a file for each.
//!
//! Commands that start somebody else's program need a Unix system; all others run everywhere.

#![allow(clippy::doc_markdown, reason = "help is printed as it stands")]

pub mod files;

pub mod output;

mod terminal;

mod wrapping;

mod links;

mod names;

#[cfg_attr(not(unix), allow(dead_code))]
mod arguments;

#[cfg(unix)]
mod call;

#[cfg(unix)]
pub mod guard;

#[cfg(unix)]
mod partial;

#[cfg(unix)]
mod progress;

#[cfg(unix)]
pub mod check_args;

#[cfg(unix)]
pub mod check;

#[cfg(unix)]
pub mod check_writer;

#[cfg(unix)]
mod ending;

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
pub mod minimise;

#[cfg(unix)]
pub mod coverage;

#[cfg(unix)]
pub mod texture;

#[cfg(unix)]
pub mod site;

pub mod inspect;

mod collection;

mod readers;

mod lint_rows;

pub mod lint;

pub mod render;

pub mod export;

pub mod convert;

pub mod diff;

pub mod completions;

/// What a subcommand ends with: its exit status, or a sentence for wrong usage.
pub type CommandResult = Result<u8, String>;

/// Wrong arguments, or a file that cannot be read or written.
pub const EXIT_USAGE: u8 = 2;

/// Nothing was selected, so nothing was checked.
#[cfg(unix)]
pub const EXIT_NOTHING_SELECTED: u8 = 5;
