//! `ptm-conform check-writer`: arguments, plan, first contact, requests, verdicts, report, causes.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::arguments::{globs, limit, memory_limit_to_text, parse_size, time_limit_to_text};
use super::driver::Check;
use super::ending::{Ending, OutputArgs};
use super::guard::{Guarded, check_trouble, stop_on_signals};
use super::output::jobs;
use super::subject;
use super::{CommandResult, EXIT_NOTHING_SELECTED, Failed};
use ptm_conform::ptm::Format;
use ptm_conform::report::shards::{Circumstances, OtherRemarks};
use ptm_conform::runner::processes;
use ptm_conform::runner::run::{Decoder, Request};
use ptm_conform::runner::template::Template;
use ptm_conform::session::plan::{Repeat, RunPlan};
use ptm_conform::suite::cases::Suite;
use ptm_conform::writers::asking::{self, VALUES, WritingCase};
use ptm_conform::writers::fitting::pictures::PictureSet;
use ptm_conform::writers::test_case::WriteView;

/// Have a writer write PTM files from given values, and say which clauses it gets wrong.
///
/// The writer is called as `WRITER [ARG…] write REQUEST OUT` once for each request. REQUEST is a JSON file with format,
/// width, height, scale, bias and so on, and the path of the planes: a NumPy array, height × width × channels, u8, top row
/// first. The writer puts a PTM file at OUT and exits with 0; or it exits with 69 if it does not write such files, with 65
/// if no file can hold the values. --fitter asks for fits of pictures instead; see docs/writers.md.
///
/// Exit status: 0 the writer passes, 1 it fails, 2 wrong usage, 3 it is not a writer, 4 known failures were fixed and
/// should be taken off the list, 5 no request was selected.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform check-writer ./my-writer\n  ptm-conform check-writer --format LRGB -- python3 write.py\n  ptm-conform check-writer --format LRGB --cmd 'convert-to-ptm --size {width}x{height} --scale {scale} --bias {bias} {planes} {out}.ptm'"
)]
pub struct CheckWriterArgs {
    /// The path of the report.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    report: PathBuf,
    /// Calls at a time; as many as there are processors by default.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Wall-clock limit of a call; the first one gets three times as much.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    memory: u64,
    /// Only requests for this format: LRGB, JPEG_RGB, … May be given more than once.
    #[arg(long = "format", value_name = "FORMAT")]
    formats: Vec<Format>,
    /// Only requests whose id matches; * and ? are wild cards. May be given more than once.
    #[arg(long = "case", value_name = "GLOB")]
    cases: Vec<String>,
    /// Only the smoke subset: few requests of every format.
    #[arg(long)]
    smoke: bool,
    /// Check a fitter: a program that makes a PTM of pictures under known lights.
    ///
    /// It is called as `FITTER [ARG…] fit REQUEST OUT`. REQUEST is a JSON file with format (LRGB or RGB), width, height and
    /// the path of an .lp file. How far its map is from the pictures is held against the least-squares optimum.
    #[arg(long)]
    fitter: bool,
    /// Have a fitter fit these pictures, too.
    #[arg(long, value_name = "FILE", requires = "fitter")]
    lp: Option<PathBuf>,
    /// Check a program that does not speak the protocol, by a line that calls it.
    ///
    /// The line is split as a shell splits it, but no shell runs. {out} is the file to write, which may have a suffix
    /// ({out}.ptm); {in} is the request in JSON; {planes} is the NumPy array, {lp} the .lp file of a fitter; {format}, {width}, {height}, {scale}, {bias},
    /// {matrix}, {quality} and {near} are values, lists with commas between their numbers. {{ and }} are braces.
    #[arg(long, value_name = "TEMPLATE", conflicts_with = "writer")]
    cmd: Option<String>,
    #[command(flatten)]
    written: OutputArgs,
    /// Failures to print in full; the report has all of them.
    #[arg(long, value_name = "N", default_value_t = 10)]
    show: usize,
    /// The writer and its arguments; the reference itself if there is none.
    #[arg(value_name = "WRITER", trailing_var_arg = true)]
    writer: Vec<OsString>,
}

/// Maximum size of a file that a writer may write; all requests need far less.
pub const MAX_FILE_SIZE: u64 = 64 << 20;

/// Runs the suite of requests.
pub fn run(args: &CheckWriterArgs) -> CommandResult {
    let stop = stop_on_signals()?;
    processes::prepare_for(MAX_FILE_SIZE);
    args.written.check(&args.report)?;
    if args.fitter {
        let own = args.lp.as_deref().map(PictureSet::read).transpose()?;
        check(args, &Suite::of_photographs(own.as_ref()), &stop)
    } else {
        check(args, &Suite::of_requests()?, &stop)
    }
}

/// Checks the writer with the selected cases of a suite.
fn check<C: WritingCase>(
    args: &CheckWriterArgs,
    suite: &Suite<C>,
    stop: &Arc<AtomicBool>,
) -> CommandResult {
    let selected = args.selected(suite)?;
    if !selected.contains(&true) {
        let says = "no request matches what --case, --format and --smoke ask for";
        return Err(Failed::new(EXIT_NOTHING_SELECTED, says));
    }
    let (writer, words) = args.writer(C::VERB, stop)?;
    let plan = RunPlan {
        selected,
        repeat: Repeat::Failures,
        stop: Arc::clone(stop),
        ..RunPlan::of(suite, jobs(args.jobs)?)
    };
    let ending = Ending::new(suite, &args.report, args.show, &args.written)?;
    let guarded = Guarded::new()?;
    let circumstances = Circumstances {
        limits: args.limits(),
        ..Circumstances::of(suite, &plan, &words, &[])
    };
    let check = Check::new(suite, &plan, circumstances, ending, None)?;
    let ask = |request: &Request<'_, WriteView>, _: usize| {
        let case = suite.case(request.name).expect("a case of this suite");
        asking::ask(&writer, case, request.timeout_factor, &guarded.scratch)
    };
    let mut run = check.ask(&ask, &|_| ());
    check_trouble(&writer)?;
    asking::reword(&mut run);
    Ok(check.conclude(run, OtherRemarks::default())?)
}

impl CheckWriterArgs {
    /// Returns the requests that match; the first ones of the selected formats are always included.
    fn selected<C: WritingCase>(&self, suite: &Suite<C>) -> Result<Vec<bool>, String> {
        let globs = globs(&self.cases)?;
        let matches = |case: &C| {
            (globs.is_empty() || globs.iter().any(|glob| glob.matches(case.id())))
                && (self.formats.is_empty() || self.formats.contains(&case.format()))
                && (!self.smoke || case.is_smoke())
        };
        Ok(suite.cases.iter().map(matches).collect())
    }

    /// Returns the writer with its limits, and its command for the report.
    fn writer(&self, verb: &str, stop: &Arc<AtomicBool>) -> Result<(Decoder, Vec<String>), String> {
        let (mut writer, words) = if let Some(text) = &self.cmd {
            let template = Template::parse_for_writer(text, &VALUES);
            let template = template.map_err(|error| format!("--cmd: {error}"))?;
            let writer = Decoder::with_template(template).map_err(|error| error.to_string())?;
            (writer, shlex::split(text).unwrap_or_default())
        } else {
            let program = subject::program(&self.writer)?;
            (program.as_writer(verb), subject::words_of(&self.writer)?)
        };
        limit(&mut writer, self.timeout, self.memory, stop)?;
        Ok((writer, words))
    }

    /// Returns the limits in force, in words.
    fn limits(&self) -> Vec<String> {
        vec![
            time_limit_to_text(self.timeout),
            memory_limit_to_text(self.memory),
            "the file: twice the bytes of its planes and 64 KiB; larger ones are not read"
                .to_owned(),
            format!("files: {} MiB each, no core dumps", MAX_FILE_SIZE >> 20),
            "input: the request and its files are held against their bytes after the call"
                .to_owned(),
        ]
    }
}
