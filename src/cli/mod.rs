//! Subcommands, one file each, with their arguments, output and exit statuses.
//!
//! Commands that start other programs need a Unix system. All others run everywhere.

#![allow(clippy::doc_markdown, reason = "help texts are plain text")]

use std::path::Path;

#[cfg_attr(not(unix), allow(dead_code))]
mod arguments;
#[cfg(unix)]
mod calls;
#[cfg(unix)]
pub mod check;
#[cfg(unix)]
pub mod check_args;
#[cfg(unix)]
pub mod check_writer;
mod collection;
pub mod completions;
pub mod convert;
#[cfg(unix)]
pub mod coverage;
pub mod diff;
#[cfg(unix)]
mod driver;
#[cfg(not(unix))]
pub mod elsewhere;
#[cfg(unix)]
mod ending;
pub mod example;
pub mod explain;
pub mod export;
pub mod files;
#[cfg(unix)]
pub mod fuzz;
pub mod generate;
#[cfg(unix)]
pub mod guard;
pub mod inspect;
mod links;
pub mod lint;
mod lint_rows;
#[cfg(unix)]
pub mod minimize;
mod names;
pub mod output;
#[cfg(unix)]
mod own_files;
#[cfg(unix)]
pub mod probe;
#[cfg(unix)]
mod progress;
mod readers;
pub mod reference;
pub mod render;
#[cfg(unix)]
pub mod report;
#[cfg(unix)]
pub mod site;
#[cfg(unix)]
mod subject;
mod terminal;
#[cfg(unix)]
pub mod texture;

/// Exit status of a subcommand, or the error that ended it.
pub type CommandResult = Result<u8, CommandError>;

/// Error that ends a subcommand.
pub struct CommandError {
    /// Message for standard error.
    pub message: String,
    /// Exit status of the process.
    pub status: u8,
}

impl CommandError {
    /// Creates an error with an exit status and a message.
    pub fn new(status: u8, message: &str) -> CommandError {
        let message = format!("ptm-conform: {message}");
        CommandError { message, status }
    }

    /// Creates an error for a file that is refused.
    pub fn refused(path: &Path, status: u8, message: &str) -> CommandError {
        let message = format!("{}: {message}", path.display());
        CommandError { message, status }
    }
}

/// Creates an error with exit status 2 from a message about a usage error, or about a file that cannot be read or written.
impl From<String> for CommandError {
    fn from(message: String) -> CommandError {
        CommandError::new(2, &message)
    }
}

/// Exit status of a command that selects no case or file.
pub const EXIT_NOTHING_SELECTED: u8 = 5;
