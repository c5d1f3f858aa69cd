//! `ptm-conform check-writer`: runs a suite of requests, from first contact to the report and the likely causes.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::ending::{OutputArgs, ReportWriter};
use super::guard::{ScratchGuard, stop_on_signals};
use super::subject::{decoder_for_command, decoder_from_template};
use super::{CommandError, CommandResult, EXIT_NOTHING_SELECTED};
use super::{arguments::id_filter, calls::RunArgs, display::Display, output::jobs};
use crate::report::html::{self, Evidence};
use ptm::Format;
use ptm_harness::pipeline::subject::OneShot;
use ptm_harness::pipeline::{self, Check, Checked};
use ptm_harness::report::shards::Circumstances;
use ptm_harness::runner::processes;
use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::template::Template;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_suite::cases::Suite;
use ptm_suite::protocol::request::Request;
use ptm_writers::asking::{self, VALUES};
use ptm_writers::cases::load_writer_requests;
use ptm_writers::fitting::cases::load_fitter_requests;
use ptm_writers::fitting::photographs::ImageSet;
use ptm_writers::test_case::{FileCase, RequestValues, WriteView};

/// Check a program that writes PTM files and name the clauses that it gets wrong.
///
/// The writer is called as `WRITER [ARG…] write REQUEST OUT` once per request. REQUEST is a JSON file with format, width, height,
/// scale, bias and so on, and the path of the planes: a NumPy array, height × width × channels, u8, top row first. The writer
/// writes a PTM file to OUT and exits with 0. It exits with 69 if it does not support the request, and with 65 if no file can
/// hold the values. --fitter requests fits to images instead; see docs/writers.md.
///
/// Exit status: 0 no request fails, 1 a request fails, 2 usage error, 3 not a writer, 4 baseline entries pass and should be
/// removed, 5 no request was selected.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform check-writer ./my-writer\n  ptm-conform check-writer --ptm-format LRGB -- python3 write.py\n  ptm-conform check-writer --ptm-format LRGB --cmd 'convert-to-ptm --size {width}x{height} --scale {scale} --bias {bias} {planes} {out}.ptm'"
)]
pub struct CheckWriterArgs {
    #[command(flatten)]
    run: RunArgs,
    /// Run only requests for this format: LRGB, JPEG_RGB, … Repeatable.
    #[arg(long = "ptm-format", alias = "format", value_name = "FORMAT", value_parser = super::arguments::parse_format)]
    formats: Vec<Format>,
    /// Run only requests whose id matches; * and ? are wildcards. Repeatable.
    #[arg(long = "case", value_name = "GLOB")]
    cases: Vec<String>,
    /// Run only the smoke subset: a few requests for each format.
    #[arg(long)]
    smoke: bool,
    /// Check a fitter: a program that creates a PTM from images taken under known lights.
    ///
    /// It is called as `FITTER [ARG…] fit REQUEST OUT`. REQUEST is a JSON file with format (LRGB or RGB), width, height and the
    /// path of an .lp file. The error of the fitted map is compared with the least-squares optimum.
    #[arg(long)]
    fitter: bool,
    /// Also request a fit to the images listed in this .lp file.
    #[arg(long, value_name = "FILE", requires = "fitter")]
    lp: Option<PathBuf>,
    /// Check a program that does not speak the protocol by running this command line.
    ///
    /// The line is split into words as in a shell, but no shell is run. {out} is the output file and may have a suffix
    /// ({out}.ptm); {in} is the request in JSON; {planes} is the NumPy array; {lp} is the .lp file of a fitter; {format},
    /// {width}, {height}, {scale}, {bias}, {matrix}, {quality} and {near} are values from the request. The numbers in a list are
    /// separated by commas. {{ and }} are braces.
    #[arg(long, value_name = "TEMPLATE", conflicts_with = "writer")]
    cmd: Option<String>,
    #[command(flatten)]
    output: OutputArgs,
    /// The writer and its arguments. Without a writer, the built-in writer is checked.
    #[arg(value_name = "WRITER", trailing_var_arg = true)]
    writer: Vec<OsString>,
}

/// Maximum size in bytes of the output of a writer. All requested files are much smaller.
pub const MAX_FILE_SIZE: u64 = 64 << 20;

/// Runs the suite of requests.
pub fn run(args: &CheckWriterArgs) -> CommandResult {
    let stop = stop_on_signals()?;
    processes::prepare_for(MAX_FILE_SIZE);
    args.output.check(&args.run.report)?;
    if args.fitter {
        let own = args.lp.as_deref().map(ImageSet::read).transpose()?;
        check(args, &load_fitter_requests(own.as_ref()), &stop)
    } else {
        check(args, &load_writer_requests()?, &stop)
    }
}

/// Runs the selected cases of a suite with the writer.
fn check<V: RequestValues>(
    args: &CheckWriterArgs,
    suite: &Suite<FileCase<V>>,
    stop: &Arc<AtomicBool>,
) -> CommandResult {
    let is_named = id_filter("--case", &args.cases)?;
    let matches = |case: &FileCase<V>| {
        is_named(&case.id)
            && (args.formats.is_empty() || args.formats.contains(&case.format))
            && (!args.smoke || case.smoke)
    };
    let selected: Vec<bool> = suite.cases.iter().map(matches).collect();
    if !selected.contains(&true) {
        let says = "no request matches --case, --ptm-format and --smoke";
        return Err(CommandError::new(EXIT_NOTHING_SELECTED, says));
    }
    let (writer, words) = args.writer(V::VERB, stop)?;
    let guarded = ScratchGuard::new()?;
    let plan = RunPlan {
        selected,
        repeat: Repeat::Failures,
        stop: Arc::clone(stop),
        ..RunPlan::new(suite, jobs(args.run.calls.jobs)?)
    };
    let check = Check {
        circumstances: Circumstances {
            command: words,
            limits: args.limits(),
            ..Circumstances::default()
        },
        ..Check::new(suite, &plan)
    };
    let subject = OneShot {
        program: &writer,
        ask: |request: &Request<'_, WriteView>, _: usize| {
            let case = suite.case(request.name).expect("the case exists");
            asking::request_file(&writer, case, request.attempt, &guarded.scratch)
        },
    };
    let report_writer = ReportWriter::new(suite, &args.run.report, &args.output)?;
    let display = Display::new(report_writer, None)?;
    let Checked { run, report, .. } = pipeline::check(&check, &subject, &display)?;
    let evidence = Evidence::new(suite, &run, html::file_evidence);
    Ok(display.finish(run.ending(), report, &evidence)?)
}

impl CheckWriterArgs {
    /// Returns the writer with its limits applied, and the writer's command line for the report.
    fn writer(&self, verb: &str, stop: &Arc<AtomicBool>) -> Result<(Decoder, Vec<String>), String> {
        let (mut writer, words) = match &self.cmd {
            Some(text) => decoder_from_template(text, Template::parse_for_writer(text, &VALUES))?,
            None => decoder_for_command(&self.writer)
                .map(|(program, words)| (program.as_writer(verb), words))?,
        };
        self.run.calls.apply_limits(&mut writer, stop)?;
        Ok((writer, words))
    }

    fn limits(&self) -> Vec<String> {
        let mut limits = self.run.calls.describe_limits();
        let others = [
            "the file: twice the size of its planes, plus 64 KiB; larger files are not read",
            &format!("files: {} MiB each, no core dumps", MAX_FILE_SIZE >> 20),
            "input: the request and its files are compared with their original bytes after the call",
        ];
        limits.extend(others.map(str::to_owned));
        limits
    }
}
