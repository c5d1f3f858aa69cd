//! `ptm-conform check-writer`: runs a suite of requests, from first contact to the report and the likely causes.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::arguments::{id_selection, parse_success};
use super::check::list_cases;
use super::ending::{OutputArgs, ReportWriter};
use super::guard::{ScratchGuard, stop_on_signals};
use super::subject::{decoder_for_command, decoder_from_template};
use super::{CommandError, CommandResult, EXIT_NOTHING_SELECTED};
use super::{calls::RunArgs, display::Display, output::jobs};
use crate::report::html::{self, Evidence};
use ptm::Format;
use ptm_harness::pipeline::subject::Subject;
use ptm_harness::pipeline::{self, Check, Checked};
use ptm_harness::report::shards::{Circumstances, OtherRemarks};
use ptm_harness::runner::processes;
use ptm_harness::runner::template::Template;
use ptm_harness::runner::{run::Decoder, scratch::Scratch};
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_suite::cases::Suite;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_writers::asking;
use ptm_writers::cases::load_writer_requests;
use ptm_writers::fitting::cases::load_fitter_requests;
use ptm_writers::fitting::photographs::{Encoding, ImageSet};
use ptm_writers::notes::Notes;
use ptm_writers::test_case::{FileCase, RequestValues, WriteView, WrittenFile};

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
    after_help = "Examples:\n  ptm-conform check-writer ./my-writer\n  ptm-conform check-writer --ptm-format LRGB -- python3 write.py\n  ptm-conform check-writer --ptm-format LRGB --cmd 'convert-to-ptm --size {width}x{height} --scale {scale} --bias {bias} {planes} {out}.ptm'\n  ptm-conform check-writer --fitter --images jpeg --ok-exit 1 --ptm-format LRGB --cmd 'PTMfitter -i {lp} -o {out}.ptm'"
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
    /// Skip requests whose id matches; * and ? are wildcards. Repeatable.
    #[arg(long = "skip", value_name = "GLOB")]
    skipped: Vec<String>,
    /// Print the ids of the selected requests, one per line, and request nothing.
    #[arg(long)]
    list: bool,
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
    /// How the images are encoded that a fitter receives.
    #[arg(long, value_name = "FORMAT", requires = "fitter", default_value = "png", value_parser = encoding_parser())]
    images: Encoding,
    /// Check a program that does not speak the protocol by running this command line.
    ///
    /// The line is split into words as in a shell, but no shell is run. {out} is the output file and may have a suffix
    /// ({out}.ptm); {in} is the request in JSON; {planes} is the NumPy array; {format}, {width}, {height}, {scale},
    /// {bias}, {matrix}, {quality} and {near} are values from the request. With --fitter, the placeholders are {out}, {in}, {lp} (the
    /// .lp file), {format}, {width} and {height}. The numbers in a list are separated by commas. {{ and }} are braces.
    #[arg(long, value_name = "TEMPLATE", conflicts_with = "writer")]
    cmd: Option<String>,
    /// An exit status other than 0 that also means success. The file is then judged.
    #[arg(long, value_name = "N", value_parser = parse_success)]
    ok_exit: Option<i32>,
    #[command(flatten)]
    output: OutputArgs,
    /// The writer and its arguments. Without a writer, the built-in writer is checked.
    #[arg(value_name = "WRITER", trailing_var_arg = true)]
    writer: Vec<OsString>,
}

/// Returns a parser for the name of an image format that is sent to fitters.
fn encoding_parser() -> impl TypedValueParser<Value = Encoding> {
    PossibleValuesParser::new(Encoding::NAMES)
        .map(|name| Encoding::from_name(&name).expect("a possible value"))
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
        check(
            args,
            &load_fitter_requests(own.as_ref(), args.images),
            &stop,
        )
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
    let is_named = id_selection(&args.cases, &args.skipped)?;
    let matches = |case: &FileCase<V>| {
        is_named(&case.id)
            && (args.formats.is_empty() || args.formats.contains(&case.format))
            && (!args.smoke || case.smoke)
    };
    let selected: Vec<bool> = suite.cases.iter().map(matches).collect();
    if !selected.contains(&true) {
        let says = "no request matches --case, --skip, --ptm-format and --smoke";
        return Err(CommandError::new(EXIT_NOTHING_SELECTED, says));
    }
    if args.list {
        return Ok(list_cases(suite, &selected));
    }
    let (program, words) = args.writer::<V>(stop)?;
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
    let subject = Writer {
        program,
        suite,
        scratch: &guarded.scratch,
        notes: Notes::default(),
    };
    let report_writer = ReportWriter::new(suite, &args.run.report, &args.output)?;
    let display = Display::new(report_writer, None)?;
    let Checked { run, report, .. } = pipeline::check(&check, &subject, &display)?;
    let evidence = Evidence::new(suite, &run, html::file_evidence);
    Ok(display.finish(run.ending(), report, &evidence)?)
}

/// A program that writes files, and notes on them.
struct Writer<'a, V: RequestValues> {
    program: Decoder,
    suite: &'a Suite<FileCase<V>>,
    scratch: &'a Scratch,
    notes: Notes,
}

impl<V: RequestValues> Subject<WriteView, WrittenFile> for Writer<'_, V> {
    fn ask(&self, request: &Request<'_, WriteView>, _: usize) -> Reply<WrittenFile> {
        let case = self.suite.case(request.name).expect("the case exists");
        let reply = asking::request_file(&self.program, case, request.attempt, self.scratch);
        self.notes.add(case, &reply.answer);
        reply
    }

    fn trouble(&self) -> Option<String> {
        self.program.trouble().map(str::to_owned)
    }

    fn remarks(&self) -> OtherRemarks {
        OtherRemarks {
            after: self.notes.remarks(),
            ..OtherRemarks::default()
        }
    }
}

impl CheckWriterArgs {
    /// Returns the writer with its limits applied, and the writer's command line for the report.
    fn writer<V: RequestValues>(
        &self,
        stop: &Arc<AtomicBool>,
    ) -> Result<(Decoder, Vec<String>), String> {
        let (mut writer, words) = match &self.cmd {
            Some(text) => {
                decoder_from_template(text, Template::parse_for_writer(text, V::PLACEHOLDERS))?
            }
            None => decoder_for_command(&self.writer)
                .map(|(program, words)| (program.as_writer(V::VERB), words))?,
        };
        self.run.calls.apply_limits(&mut writer, stop)?;
        writer.success_exit = self.ok_exit;
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
