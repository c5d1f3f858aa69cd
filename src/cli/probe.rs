//! `ptm-conform probe`: a checklist for authors of decoders and writers.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::calls::{quote_command, reordered_command};
use super::guard::{ScratchGuard, check_for_trouble};
use super::terminal::print_styled;
use super::{CommandResult, arguments::positive_seconds};
use ptm_harness::runner::{processes, run::Decoder};
use ptm_harness::session::probe::{Reproduction, probe};

/// Test a new wrapper step by step and say what to fix.
///
/// The decoder is called with ordinary files in every view, with a large file, with malformed files and with an unknown view. It
/// is also called in serve mode if it supports that mode. Wrong images are compared with common wrapper mistakes: flipped rows,
/// BGR, planar samples, wrong byte order. If nothing is decoded, other ways to call the decoder are tried (the current directory,
/// the file on standard input, FILE before VIEW). The files that show a fault are kept, along with a command that reproduces each
/// observation.
///
/// With --writer, the program is a writer, and one file of each format is requested.
///
/// Exit status: 0 ready for check, 1 something needs fixing, 2 usage error, 3 not a decoder (or writer) yet.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform probe ./my-decoder\n  ptm-conform probe -- python3 decode.py\n  ptm-conform probe --writer ./my-writer"
)]
pub struct ProbeArgs {
    /// The program is a writer (see check-writer).
    #[arg(long)]
    writer: bool,
    /// Wall-clock limit for each call in check; a call of probe may take three times as long.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// The directory for files that show a fault; created if there are any.
    #[arg(long, value_name = "DIR", default_value = "ptm-conform-probe")]
    keep: PathBuf,
    /// The decoder and its arguments.
    #[arg(value_name = "DECODER", trailing_var_arg = true, required = true)]
    decoder: Vec<OsString>,
}

/// Runs the steps of a probe and prints the checklist.
pub fn run(args: &ProbeArgs) -> CommandResult {
    match args.writer {
        true => processes::prepare_for(super::check_writer::MAX_FILE_SIZE),
        false => processes::prepare(),
    }
    let mut program = Decoder::new(&args.decoder).map_err(|error| error.to_string())?;
    if args.writer {
        program = program.as_writer("write");
    }
    program.timeout = positive_seconds(args.timeout)?;
    let guarded = ScratchGuard::new()?;
    let list = match args.writer {
        true => ptm_writers::probe::probe(&program, &guarded.scratch)?,
        false => probe(&args.decoder, &program, &guarded.scratch),
    };
    check_for_trouble(&program)?;
    let command = quote_command(&args.decoder);
    let repeat = |repeat: &Reproduction| save_files(repeat, &command, &args.keep);
    let next = match (list.faults(), args.writer) {
        (0, true) => format!("ready. Next: ptm-conform check-writer -- {command}\n"),
        (faults, true) => format!("faults to fix: {faults}; then run probe again\n"),
        (0, false) => format!("ready. Next: ptm-conform check -- {command}\n"),
        (1, false) => "1 thing to fix; then run probe again\n".to_owned(),
        (faults, false) => format!("{faults} things to fix; then run probe again\n"),
    };
    print_styled(&list.to_text(&repeat));
    print_styled(&next);
    if let Some(command) = reordered_command::<ProbeArgs>("probe", &args.decoder) {
        print_styled(&format!("options come before the program: {command}\n"));
    }
    Ok(list.exit_status())
}

/// Saves the files of the requests and returns a command that repeats the requests. Returns `None` if a file cannot be written.
pub fn save_files(repeat: &Reproduction, command: &str, directory: &Path) -> Option<String> {
    fs::create_dir_all(directory).ok()?;
    for request in &repeat.requests {
        fs::write(directory.join(&request.file_name), &request.file).ok()?;
    }
    Some(repeat.command(command, directory))
}
