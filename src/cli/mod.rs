//! The subcommands: their arguments, output and exit status; a file for each.
//!
//! Commands that start other programs need a Unix system; all others run everywhere.

#![allow(clippy::doc_markdown, reason = "help is printed as it stands")]

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
pub mod minimise;
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

/// The exit status of a subcommand, or its failure.
pub type CommandResult = Result<u8, Failed>;

/// The failure of a subcommand.
pub struct Failed {
    /// The message for standard error.
    pub says: String,
    /// Its exit status.
    pub status: u8,
}

impl Failed {
    /// Creates a failure with a sentence and an exit status.
    pub fn new(status: u8, says: &str) -> Failed {
        let says = format!("ptm-conform: {says}");
        Failed { says, status }
    }

    /// Creates the failure of a file that is refused.
    pub fn refused(path: &Path, status: u8, says: &str) -> Failed {
        let says = format!("{}: {says}", path.display());
        Failed { says, status }
    }
}

/// Converts a message about wrong arguments, or a file that cannot be read or written.
impl From<String> for Failed {
    fn from(says: String) -> Failed {
        Failed::new(2, &says)
    }
}

/// Exit status if nothing was selected, so nothing was checked.
pub const EXIT_NOTHING_SELECTED: u8 = 5;
