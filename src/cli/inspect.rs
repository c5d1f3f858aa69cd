//! Subcommand `ptm-conform inspect`.

use std::path::PathBuf;

use clap::Args;

use super::output::{self, MachineFormatArgs};
use super::{CommandResult, files};
use ptm_files::{dissection::Dissection, inspect::inspect};

/// Show every field of a file: offset, clause and value.
///
/// A damaged file is shown up to the damage, with an error message. Compressed files are shown with the marker segments of their
/// JPEG or JPEG-LS streams and the records of their side information.
///
/// Exit status: 0 success, 2 usage error, 65 the file is malformed, 69 it is not supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform inspect coin.ptm\n  ptm-conform inspect --all --color always coin.ptm | less -R\n  ptm-conform inspect --json coin.ptm | jq '.fields[] | select(.name == \"width\")'"
)]
pub struct InspectArgs {
    /// A PTM file.
    file: PathBuf,
    /// Show every table entry, marker segment and record, not only the first ones.
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    machine: MachineFormatArgs,
}

pub fn run(args: &InspectArgs) -> CommandResult {
    let file = files::read(&args.file)?;
    let inspection = inspect(&file);
    if !args.machine.print(&inspection)? {
        output::print(&inspection.to_text(&args.file.display().to_string(), args.all));
    }
    let outcome = &Dissection::parse(&file).outcome;
    Ok(outcome.as_ref().err().map_or(0, files::status))
}
