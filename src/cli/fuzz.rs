//! Subcommand `ptm-conform fuzz`.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;

use super::guard::{ScratchGuard, check_for_trouble, stop_on_signals};
use super::output::{bar, jobs, print};
use super::{CommandError, CommandResult};
use super::{arguments::positive_seconds, calls::CallArgs};
use ptm::Format;
use ptm_harness::fuzz::finding::Finding;
use ptm_harness::fuzz::write::{cause_text, write};
use ptm_harness::fuzz::{FuzzPlan, FuzzProgress, FuzzResult, fuzz};
use ptm_harness::runner::serve::Servers;
use ptm_suite::cases::{Suite, TableSpelling};
use ptm_suite::protocol::frame::ViewKind;
use ptm_suite::protocol::request::Request;

/// Number of calls if neither this number nor the time is limited.
const DEFAULT_EXECUTIONS: usize = 20_000;

/// Template of a progress bar that counts calls.
pub const CALLS_TEMPLATE: &str = "{bar:40} {pos}/{len} calls {elapsed}";

/// Fuzz a decoder: generate random files of all formats, and keep the smallest file for each mistake.
///
/// Responses are judged as in the suite. Failures with the same cause count as one finding. For each finding, the cause is named,
/// the file is reduced, and a case is written to the output directory: NAME.yaml (the case), NAME.ptm (its file), NAME.expected
/// and NAME.received (frames), NAME.txt (the cause, and the meaning of each byte of the file).
///
/// Exit status: 0 nothing found, 1 mistakes found, 2 usage error, 3 not a decoder.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform fuzz ./my-decoder\n  ptm-conform fuzz --seconds 60 --ptm-format LRGB --seed 7 -- python3 decode.py"
)]
pub struct FuzzArgs {
    /// Random seed; the same seed generates the same files.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Stop after about this many calls [default: 20000, or no limit with --seconds].
    #[arg(long, value_name = "N")]
    executions: Option<usize>,
    /// Stop generating files after this many seconds; reducing a finding may take longer.
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
    /// Generate only files of this format, such as LRGB or JPEG_RGB. Repeatable.
    #[arg(long = "ptm-format", alias = "format", value_name = "FORMAT", value_parser = super::arguments::parse_format)]
    formats: Vec<Format>,
    /// Request only this view. Repeatable.
    #[arg(long = "view", value_name = "VIEW", value_parser = super::arguments::view_parser())]
    views: Vec<ViewKind>,
    /// Start a process for each call, even if the decoder's capabilities declare serve mode.
    #[arg(long)]
    one_shot: bool,
    /// The output directory.
    #[arg(short, long, value_name = "DIR", default_value = "ptm-conform-finds")]
    out: PathBuf,
    #[command(flatten)]
    call: CallArgs,
    /// The decoder and its arguments.
    #[arg(value_name = "DECODER", trailing_var_arg = true, required = true)]
    decoder: Vec<OsString>,
}

/// Runs the fuzzer and writes the findings.
pub fn run(args: &FuzzArgs) -> CommandResult {
    let suite = Suite::load()?;
    let decoder = args.call.decoder(&args.decoder, &stop_on_signals()?)?;
    // After the time limit, no more files are generated, but calls in progress are finished.
    let stop = stop_on_signals()?;
    let guarded = ScratchGuard::new()?;
    let scratch = &guarded.scratch;
    let declared = decoder.capabilities(scratch).unwrap_or_default();
    let serves = declared.serves && !args.one_shot;
    let default_executions = args.seconds.is_none().then_some(DEFAULT_EXECUTIONS);
    let executions = args.executions.or(default_executions);
    let plan = FuzzPlan {
        seed: args.seed,
        executions: executions.unwrap_or(usize::MAX),
        jobs: jobs(args.call.limits.jobs)?,
        views: args.views.clone(),
        declared,
        formats: args.formats.clone(),
        unanswered: Arc::default(),
        stop: Arc::clone(&stop),
    };
    if let Some(seconds) = args.seconds {
        let (time, stop) = (positive_seconds(seconds)?, Arc::clone(&stop));
        std::thread::spawn(move || {
            std::thread::sleep(time);
            stop.store(true, Ordering::Relaxed);
        });
    }
    let bar = match executions {
        Some(count) => bar(Some(count as u64), CALLS_TEMPLATE),
        None => bar(None, "{pos} calls {elapsed}"),
    };
    let servers = Servers::new(&decoder, scratch, plan.jobs);
    let ask = |request: &Request<'_>, job: usize| {
        let reply = match serves {
            true => servers.ask(request, job),
            false => decoder.ask(request, scratch),
        };
        if decoder.trouble().is_some() {
            stop.store(true, Ordering::Relaxed);
        }
        reply
    };
    let result = fuzz(&suite, &plan, &ask, &|progress| match progress {
        FuzzProgress::Executions(count) => bar.set_position(count as u64),
        FuzzProgress::Found(finding) => bar.suspend(|| args.write(finding)),
    });
    bar.finish_and_clear();
    check_for_trouble(&decoder)?;
    if let Some(why) = result.not_a_decoder {
        return Err(CommandError::new(3, &format!("not a decoder: {why}")));
    }
    let end = match result.ended_early {
        _ if decoder.stop.load(Ordering::Relaxed) => "; interrupted",
        _ if stop.load(Ordering::Relaxed) => "; the time limit was reached",
        Some(_) => "; three legal files in a row exceeded the time limit (`--timeout`)",
        None => "",
    };
    print(&summary(&result, end));
    Ok(u8::from(!result.findings.is_empty()))
}

impl FuzzArgs {
    /// Writes the files of a finding and prints a description.
    fn write(&self, finding: &Finding) {
        let written = match write(finding, TableSpelling::default(), &self.out) {
            Ok(name) => self.out.join(name).display().to_string(),
            Err(error) => format!("not written: {error}"),
        };
        print(&format!("found: {}\n  {written}\n", cause_text(finding)));
    }
}

/// Summarizes a run: the numbers of files, calls and findings.
fn summary(result: &FuzzResult, end: &str) -> String {
    let (files, calls, count) = (result.files, result.executions, result.findings.len());
    let plural = if count == 1 { "" } else { "s" };
    let found = format!("{count} mistake{plural} found{end}");
    let mut text = format!("{files} files generated, {calls} calls, {found}\n");
    for finding in &result.findings {
        let _ = writeln!(text, "  {:>6}  {}", finding.count, finding.cause.name());
    }
    text
}
