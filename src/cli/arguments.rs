//! Parsing of option values: times, sizes, exit statuses, patterns.

#[cfg(unix)]
use std::ffi::OsString;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};
use std::time::Duration;

use ptm_conform::protocol::frame::EXIT_UNSUPPORTED;
#[cfg(unix)]
use ptm_conform::runner::run::Decoder;

/// Parses a timeout in seconds.
pub fn positive_seconds(seconds: f64) -> Result<Duration, String> {
    Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|time| !time.is_zero())
        .ok_or_else(|| "a time limit is a positive number of seconds".to_owned())
}

/// Returns a command quoted for a shell.
#[cfg(unix)]
pub fn in_one_line(command: &[OsString]) -> String {
    let words: Vec<_> = command.iter().map(|word| word.to_string_lossy()).collect();
    shlex::try_join(words.iter().map(AsRef::as_ref)).unwrap_or_default()
}

/// Applies the limits of the command line to a program, which stops when `stop` is set.
#[cfg(unix)]
pub fn limit(
    program: &mut Decoder,
    seconds: f64,
    memory: u64,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    program.timeout = positive_seconds(seconds)?;
    program.memory = memory;
    program.stop = Arc::clone(stop);
    Ok(())
}

/// Describes a timeout for the report.
#[cfg(unix)]
pub fn time_limit_to_text(seconds: f64) -> String {
    format!("wall clock: {seconds} s a call, three times that for the first")
}

/// Describes a memory limit for the report.
#[cfg(unix)]
pub fn memory_limit_to_text(bytes: u64) -> String {
    match ptm_conform::runner::processes::can_be_watched() {
        true => {
            let size = bytes >> 20;
            format!("memory: {size} MiB, the resident sets of a call's processes, sampled")
        }
        false => "memory: not limited, because this system has no /proc".to_owned(),
    }
}

/// Parses an exit status that may mean a refusal; 0 and 69 have other meanings.
pub fn parse_refusal(text: &str) -> Result<i32, String> {
    let status = text
        .parse()
        .ok()
        .filter(|status| (1..=255).contains(status) && *status != EXIT_UNSUPPORTED);
    status.ok_or_else(|| {
        format!(
            "expected an exit status from 1 to 255 other than {EXIT_UNSUPPORTED}, found {text:?}"
        )
    })
}

/// Parses a number of bytes, optionally with K, M or G.
pub fn parse_size(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.as_bytes().last() {
        Some(b'K') => (&text[..text.len() - 1], 10),
        Some(b'M') => (&text[..text.len() - 1], 20),
        Some(b'G') => (&text[..text.len() - 1], 30),
        _ => (text, 0),
    };
    let bytes = digits
        .parse::<u64>()
        .ok()
        .filter(|&size| size > 0)
        .and_then(|size| size.checked_mul(1 << shift));
    bytes.ok_or_else(|| format!("expected a size such as 500M or 2G, found {text:?}"))
}

/// Parses two numbers separated by a comma.
pub fn parse_pair(text: &str) -> Option<(f64, f64)> {
    let (first, second) = text.split_once(',')?;
    Some((first.trim().parse().ok()?, second.trim().parse().ok()?))
}

/// Parses patterns for the ids of cases.
pub fn globs(texts: &[String]) -> Result<Vec<glob::Pattern>, String> {
    let pattern =
        |text: &String| glob::Pattern::new(text).map_err(|error| format!("--case {text}: {error}"));
    texts.iter().map(pattern).collect()
}

/// Options for calls of a decoder.
#[cfg(unix)]
#[derive(clap::Args)]
pub struct CallArgs {
    /// Calls at a time; by default as many as there are processors.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Wall-clock limit of a call.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    memory: u64,
    /// An exit status that means "malformed" besides 65.
    #[arg(long, value_name = "N", value_parser = parse_refusal)]
    reject_exit: Option<i32>,
}

#[cfg(unix)]
impl CallArgs {
    /// Returns the decoder that `command` starts; it stops when `stop` is set.
    pub fn decoder(
        &self,
        command: &[std::ffi::OsString],
        stop: &Arc<AtomicBool>,
    ) -> Result<Decoder, String> {
        ptm_conform::runner::processes::prepare();
        let mut decoder = Decoder::new(command).map_err(|error| error.to_string())?;
        limit(&mut decoder, self.timeout, self.memory, stop)?;
        decoder.reject_exit = self.reject_exit;
        Ok(decoder)
    }
}
