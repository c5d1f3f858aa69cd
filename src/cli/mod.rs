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
mod check;
#[cfg(unix)]
mod check_args;
#[cfg(unix)]
mod check_writer;
mod collection;
pub mod commands;
mod completions;
mod convert;
#[cfg(unix)]
mod coverage;
mod diff;
#[cfg(unix)]
mod display;
#[cfg(not(unix))]
mod elsewhere;
#[cfg(unix)]
mod ending;
mod example;
mod explain;
mod export;
mod files;
#[cfg(unix)]
mod fuzz;
mod generate;
#[cfg(unix)]
mod guard;
mod inspect;
mod links;
mod lint;
mod lint_history;
mod lint_rows;
#[cfg(unix)]
mod minimize;
mod names;
mod output;
#[cfg(unix)]
mod own_files;
#[cfg(unix)]
mod probe;
#[cfg(unix)]
mod progress;
mod readers;
mod reference;
mod render;
#[cfg(unix)]
mod report;
#[cfg(unix)]
mod site;
#[cfg(unix)]
mod subject;
mod terminal;
#[cfg(unix)]
mod texture;

/// Exit status of a subcommand, or the error that ended it.
pub(crate) type CommandResult = Result<u8, CommandError>;

/// Error that ends a subcommand.
pub(crate) struct CommandError {
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
/// Errors of the crates are usage errors or errors of the installation.
macro_rules! usage_errors {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for CommandError {
            fn from(error: $error) -> CommandError {
                CommandError::new(2, &error.to_string())
            }
        })*
    };
}
usage_errors![
    ptm::ParseError,
    ptm_generate::Error,
    ptm_suite::Error,
    ptm_files::Error
];

impl From<String> for CommandError {
    fn from(message: String) -> CommandError {
        CommandError::new(2, &message)
    }
}

#[cfg(unix)]
impl From<ptm_harness::pipeline::Error> for CommandError {
    fn from(error: ptm_harness::pipeline::Error) -> CommandError {
        match error {
            ptm_harness::pipeline::Error::Trouble(trouble) => guard::trouble_message(&trouble),
            other => other.to_string(),
        }
        .into()
    }
}

/// Exit status of a command that selects no case or file.
pub(crate) const EXIT_NOTHING_SELECTED: u8 = 5;
