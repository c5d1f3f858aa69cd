//! `probe`: the checklist of a decoder's author.

use std::ffi::OsString;
use std::time::Duration;

use clap::Args;

use ptm_conform::harness::probe::{Mark, probe};
use ptm_conform::harness::processes;
use ptm_conform::harness::run::Decoder;

/// Walk a new decoder through the contract, and say what is wrong and what to do.
///
/// It is asked for ordinary files in every view, a large one, malformed ones and an unknown view, and for its serve mode
/// and capabilities, if it has any. A wrong picture is compared with what wrappers get wrong: rows upside down, BGR, planes
/// one behind the other, the wrong byte order. Where nothing comes at all, it is also called in other ways (from
/// this directory, with the file on standard input, FILE before VIEW) to find out which one it expects.
///
/// Exit status: 0 it is ready for check, 1 something is to be mended, 2 wrong usage, 3 it is not a decoder yet.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform probe ./my-decoder\n  ptm-conform probe -- python3 decode.py"
)]
pub struct ProbeArgs {
    /// Wall-clock limit of a call.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// The decoder and its arguments.
    #[arg(value_name = "DECODER", trailing_var_arg = true, required = true)]
    decoder: Vec<OsString>,
}

pub fn run(args: &ProbeArgs) -> Result<u8, String> {
    processes::prepare();
    let mut decoder = Decoder::new(&args.decoder).map_err(|error| error.to_string())?;
    decoder.timeout = Duration::try_from_secs_f64(args.timeout)
        .ok()
        .filter(|timeout| !timeout.is_zero())
        .ok_or("a time limit is a positive number of seconds")?;
    let guarded = super::guard::Guarded::new()?;
    let list = probe(&args.decoder, &decoder, &guarded.scratch);
    super::output::print(&list.to_string());
    let command: Vec<String> = args
        .decoder
        .iter()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let command = shlex::try_join(command.iter().map(String::as_str)).unwrap_or_default();
    let bad = list
        .steps
        .iter()
        .filter(|step| step.mark == Mark::Bad)
        .count();
    super::output::print(&match bad {
        0 => format!("ready. Next: ptm-conform check -- {command}\n"),
        1 => "1 thing to mend; then probe again\n".to_owned(),
        _ => format!("{bad} things to mend; then probe again\n"),
    });
    Ok(list.exit_status())
}
