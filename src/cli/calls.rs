//! Options for running other programs: limits and the number of parallel calls.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::arguments::{parse_refusal, parse_size, positive_seconds};
use ptm_harness::runner::{processes, run::Decoder};

/// Flag that is set when the user ends a run.
pub type StopFlag = Arc<AtomicBool>;

/// Options for running a suite.
#[derive(Args)]
#[command(mut_arg("timeout", |timeout| timeout.help("Wall-clock limit for each call; requests that exceed it are repeated alone, with three times the limit")))]
pub struct RunArgs {
    /// The file for the YAML report.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    pub report: PathBuf,
    #[command(flatten)]
    pub calls: LimitArgs,
}

/// Options for the limits of a call and the number of parallel calls.
#[derive(Args)]
pub struct LimitArgs {
    /// Number of parallel calls; one per processor by default.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Wall-clock limit for each call.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory limit for all processes of a call, in bytes or with the suffix K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    memory: u64,
}

impl LimitArgs {
    /// Applies the limits to a program and makes its calls end when `stop` is set.
    pub fn apply_limits(&self, program: &mut Decoder, stop: &StopFlag) -> Result<(), String> {
        program.timeout = positive_seconds(self.timeout)?;
        program.memory = self.memory;
        program.stop = Arc::clone(stop);
        Ok(())
    }

    /// Describes the limits in force.
    pub fn describe_limits(&self) -> Vec<String> {
        let (seconds, size) = (self.timeout, self.memory >> 20);
        let memory = match processes::can_inspect_processes() {
            true => {
                format!("{size} MiB resident in all processes of a call (measured by sampling)")
            }
            false => "not limited, because this system has no /proc".to_owned(),
        };
        let time = format!(
            "{seconds} s per call; requests that exceed it are repeated alone, with three times the limit"
        );
        let limits = [("wall-clock time", time), ("memory", memory)];
        Vec::from(limits.map(|(name, text)| format!("{name}: {text}")))
    }
}

/// Options for calling a decoder.
#[derive(Args)]
pub struct CallArgs {
    #[command(flatten)]
    pub limits: LimitArgs,
    /// An exit status other than 65 that also means "malformed".
    #[arg(long, value_name = "N", value_parser = parse_refusal)]
    reject_exit: Option<i32>,
}

impl CallArgs {
    /// Creates the decoder for `command`. Its calls end when `stop` is set.
    pub fn decoder(&self, command: &[OsString], stop: &StopFlag) -> Result<Decoder, String> {
        processes::prepare();
        let mut decoder = Decoder::new(command).map_err(|error| error.to_string())?;
        self.limits.apply_limits(&mut decoder, stop)?;
        decoder.reject_exit = self.reject_exit;
        Ok(decoder)
    }
}

/// Quotes a command for a shell.
pub fn quote_command(command: &[OsString]) -> String {
    let words: Vec<_> = command.iter().map(|word| word.to_string_lossy()).collect();
    shlex::try_join(words.iter().map(AsRef::as_ref)).unwrap_or_default()
}

/// Returns a corrected command line if options of this command, whose arguments are `A`, follow the program under test.
pub fn reordered_command<A: Args>(name: &str, program: &[OsString]) -> Option<String> {
    let options = A::augment_args(clap::Command::new("options"));
    let is_option = |word: &&OsString| {
        let word = word.to_string_lossy();
        let name = word.strip_prefix("--").map(|word| word.split('=').next());
        let mut known = options.get_arguments().map(clap::Arg::get_long);
        name.is_some_and(|name| known.any(|long| long.is_some() && long == name))
    };
    let first = program.iter().position(|word| is_option(&word))?;
    let (program, misplaced) = program.split_at(first);
    let words = [misplaced, &["--".into()], program].concat();
    Some(format!("ptm-conform {name} {}", quote_command(&words)))
}
