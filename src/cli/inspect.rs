//! Subcommand `ptm-conform inspect`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::collection::{WalkItem, walk};
use super::output::{self, MachineFormatArgs, print_error};
use super::{CommandResult, files};
use ptm_files::dissection::Dissection;
use ptm_files::inspect::{Inspection, inspect};
use ptm_files::lint::{names::escape_name, status::is_named_ptm};
use ptm_suite::kit::yaml::to_yaml;

/// Show every field of a file: offset, clause and value.
///
/// A damaged file is shown up to the damage, with an error message. Compressed files are shown with the marker segments of their
/// JPEG or JPEG-LS streams and the records of their side information.
///
/// Of a folder, the files named .ptm are shown. With several files, --json prints one record per line, with the name of the file.
///
/// Exit status: 0 success, 2 usage error or a file cannot be read, 65 a file is malformed, 69 it is not supported.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform inspect coin.ptm\n  ptm-conform inspect --all --color always coin.ptm | less -R\n  ptm-conform inspect --json coin.ptm | jq '.fields[] | select(.name == \"width\")'\n  ptm-conform inspect --json /archive | jq -r '[.file, .width, .height] | @tsv'"
)]
pub struct InspectArgs {
    /// PTM files and folders.
    #[arg(required = true, value_name = "PATH")]
    files: Vec<PathBuf>,
    /// Show every table entry, marker segment and record, not only the first ones.
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    machine: MachineFormatArgs,
}

/// An inspection of one of several files.
#[derive(Serialize)]
struct NamedInspection<'a> {
    file: &'a str,
    #[serde(flatten)]
    inspection: &'a Inspection,
}

pub fn run(args: &InspectArgs) -> CommandResult {
    if let [file] = &args.files[..]
        && !file.is_dir()
    {
        return inspect_file(args, file, false);
    }
    let mut status = 0;
    for item in walk(args.files.iter().map(|path| (path.clone(), false)), true) {
        let path = match &item {
            WalkItem::Found(path) if !is_named_ptm(&path.to_string_lossy()) => continue,
            WalkItem::File(path) | WalkItem::Found(path) => path,
            WalkItem::Skipped(..) => continue,
            WalkItem::Unreadable(path, error) => {
                print_error(&files::with_path(path)(error));
                status = 2;
                continue;
            }
        };
        match inspect_file(args, path, true) {
            Ok(0) => {}
            Ok(found) if status == 0 => status = found,
            Ok(_) => {}
            Err(error) => {
                print_error(&error.message);
                status = 2;
            }
        }
    }
    Ok(status)
}

/// Shows a file, one of several if `is_named` is true.
fn inspect_file(args: &InspectArgs, path: &Path, is_named: bool) -> CommandResult {
    let file = files::read(path)?;
    let inspection = inspect(&file);
    let name = escape_name(path.as_os_str());
    let named = NamedInspection {
        file: &name,
        inspection: &inspection,
    };
    match (is_named, args.machine.json, args.machine.yaml) {
        (true, true, _) => {
            let record = serde_json::to_string(&named).map_err(|error| error.to_string())?;
            output::print(&(record + "\n"));
        }
        (true, _, true) => output::print(&to_yaml(&[named])?),
        _ if args.machine.print(&inspection)? => {}
        _ => output::print(&inspection.to_text(&name, args.all)),
    }
    let outcome = &Dissection::parse(&file).outcome;
    Ok(outcome.as_ref().err().map_or(0, files::status))
}
