//! Subcommand `ptm-conform diff`.

use std::path::PathBuf;

use clap::Args;

use super::output::{self, MachineFormatArgs};
use super::terminal::print_styled;
use super::{CommandResult, files};
use ptm_files::{diff::diff, dissection::Dissection};

/// Compare two maps: header fields, planes, number of texels that differ, size and position of the first difference.
///
/// Files with the same map are equal. Differences in spelling, compression and the order of table entries are mentioned but do
/// not count as differences.
///
/// Exit status: 0 the same map, 1 different maps, 2 a file cannot be opened or decoded, or usage error.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform diff before.ptm after.ptm\n  ptm-conform diff --quiet a.ptm b.ptm && echo same"
)]
pub struct DiffArgs {
    /// A PTM file.
    a: PathBuf,
    /// Another PTM file.
    b: PathBuf,
    #[command(flatten)]
    machine: MachineFormatArgs,
}

pub fn run(args: &DiffArgs) -> CommandResult {
    let (a_file, b_file) = (files::read(&args.a)?, files::read(&args.b)?);
    let (a_anatomy, b_anatomy) = (Dissection::parse(&a_file), Dissection::parse(&b_file));
    let maps =
        [(&args.a, &a_anatomy), (&args.b, &b_anatomy)].map(|(path, of)| files::map(path, of));
    let [Ok(a), Ok(b)] = maps else {
        for failed in maps.into_iter().filter_map(Result::err) {
            output::print_error(&failed.message);
        }
        return Ok(2);
    };
    let difference = diff((&a_file, a), (&b_file, b));
    if !args.machine.print(&difference)? && !output::is_quiet() {
        let same = match difference.same {
            true => "the same map\n",
            false => "",
        };
        print_styled(&(difference.to_text() + same));
    }
    Ok(u8::from(!difference.same))
}
