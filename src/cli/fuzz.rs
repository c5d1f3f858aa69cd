//! `fuzz` and `minimise`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::EXIT_USAGE;
use super::guard::{Guarded, stop_on_signals};
use super::output::{jobs, print};
use ptm_conform::harness::cases::{Suite, TableSpelling};
use ptm_conform::harness::fuzz::write::{because, write};
use ptm_conform::harness::fuzz::{News, Plan, fuzz, reduce};
use ptm_conform::harness::processes;
use ptm_conform::harness::protocol::{Answer, Frame, View};
use ptm_conform::harness::run::{Decoder, Request};
use ptm_conform::harness::serve::Servers;
use ptm_conform::ptm::Format;

/// Nothing was found; a mistake was; the program is no decoder.
const EXIT_FOUND: u8 = 1;
const EXIT_NO_DECODER: u8 = 3;

/// How a decoder is called.
#[derive(Args)]
pub struct CallArgs {
    /// Calls at a time; as many as there are processors unless told.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Wall-clock limit of a call.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = super::arguments::parse_size)]
    memory: u64,
    /// An exit status that means "malformed" besides 65.
    #[arg(long, value_name = "N", value_parser = super::arguments::parse_refusal)]
    reject_exit: Option<i32>,
}

impl CallArgs {
    fn decoder(&self, command: &[OsString], stop: &Arc<AtomicBool>) -> Result<Decoder, String> {
        processes::prepare();
        let mut decoder = Decoder::new(command).map_err(|error| error.to_string())?;
        decoder.timeout = super::arguments::positive_seconds(self.timeout)?;
        decoder.memory = self.memory;
        decoder.reject_exit = self.reject_exit;
        decoder.stop = Arc::clone(stop);
        Ok(decoder)
    }
}

/// Draw random files of all formats, ask a decoder for them, and keep the smallest file for each of its mistakes.
///
/// Files are judged as cases are. What fails alike is one find: its cause is named, the file is made small, and a ready
/// case is written to the directory of finds at once: NAME.yaml (the case), NAME.ptm (its file), NAME.expected and
/// NAME.received (frames), NAME.txt (the cause, and what each byte of the file is).
///
/// Exit status: 0 nothing was found, 1 something was, 2 wrong usage, 3 it is not a decoder.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform fuzz ./my-decoder\n  ptm-conform fuzz --seconds 60 --format LRGB --seed 7 -- python3 decode.py"
)]
pub struct FuzzArgs {
    /// Where the draws start; the same seed draws the same files.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Stop after about so many calls.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    executions: usize,
    /// Stop after so many seconds.
    #[arg(long, value_name = "SECONDS")]
    seconds: Option<f64>,
    /// Only files of this format, such as LRGB or `JPEG_RGB`. May be given more than once.
    #[arg(long = "format", value_name = "FORMAT", value_parser = parse_format)]
    formats: Vec<Format>,
    /// Ask in this view only. May be given more than once.
    #[arg(long = "view", value_name = "VIEW", value_parser = ["raw", "coef", "rgb"])]
    views: Vec<String>,
    /// Ask a process of its own each time, even if the decoder's capabilities say that it serves.
    #[arg(long)]
    one_shot: bool,
    /// The directory to write finds to.
    #[arg(long, value_name = "DIR", default_value = "ptm-conform-finds")]
    out: PathBuf,
    #[command(flatten)]
    call: CallArgs,
    /// The decoder and its arguments.
    #[arg(value_name = "DECODER", trailing_var_arg = true, required = true)]
    decoder: Vec<OsString>,
}

fn parse_format(text: &str) -> Result<Format, String> {
    text.parse()
}

/// Fuzzes.
pub fn run_fuzz(args: &FuzzArgs) -> Result<u8, String> {
    let suite = Suite::load()?;
    let decoder = args.call.decoder(&args.decoder, &stop_on_signals()?)?;
    // When the time is over nothing more is drawn, but calls that are under way come to their end.
    let stop = stop_on_signals()?;
    let guarded = Guarded::new()?;
    let scratch = &guarded.scratch;
    let declared = decoder.capabilities(scratch).unwrap_or_default();
    let serves = declared.serves && !args.one_shot;
    let plan = Plan {
        seed: args.seed,
        executions: args.executions,
        jobs: jobs(args.call.jobs)?,
        views: ["raw", "coef", "rgb"]
            .into_iter()
            .filter(|view| args.views.iter().any(|asked| asked == view))
            .collect(),
        declared,
        formats: args.formats.clone(),
        stop: Arc::clone(&stop),
    };
    if let Some(seconds) = args.seconds {
        stop_after(super::arguments::positive_seconds(seconds)?, &stop);
    }
    let bar = bar(args.executions as u64);
    let servers = Servers::new(&decoder, scratch, plan.jobs);
    let ask = |request: &Request<'_>, job: usize| match serves {
        true => servers.ask(request, job),
        false => decoder.ask(request, scratch),
    };
    let outcomes = fuzz(&suite, &plan, &ask, &|news| match news {
        News::Executions(count) => bar.set_position(count as u64),
        News::Found(find) => {
            let written = match write(find, TableSpelling::default(), &args.out) {
                Ok(name) => args.out.join(name).display().to_string(),
                Err(error) => format!("not written: {error}"),
            };
            bar.suspend(|| print(&format!("found: {}\n  {written}\n", because(find))));
        }
    });
    bar.finish_and_clear();
    drop(servers);
    if let Some(why) = outcomes.not_a_decoder {
        super::output::complain(&format!("ptm-conform: not a decoder: {why}"));
        return Ok(EXIT_NO_DECODER);
    }
    print(&format!(
        "{} files drawn, {} calls, {} found{}\n",
        outcomes.files,
        outcomes.executions,
        match outcomes.finds.len() {
            1 => "1 mistake".to_owned(),
            count => format!("{count} mistakes"),
        },
        match decoder.stop.load(Ordering::Relaxed) {
            true => "; the run was ended by its user",
            false if stop.load(Ordering::Relaxed) => "; the time is over",
            false => outcomes
                .ended_early
                .map_or("", |_| "; the decoder does not come to an end"),
        }
    ));
    for find in &outcomes.finds {
        print(&format!("  {:>6}  {}\n", find.seen, find.cause.name()));
    }
    Ok(if outcomes.finds.is_empty() {
        0
    } else {
        EXIT_FOUND
    })
}

/// Ends the run when the time is over.
fn stop_after(time: Duration, stop: &Arc<AtomicBool>) {
    let stop = Arc::clone(stop);
    std::thread::spawn(move || {
        std::thread::sleep(time);
        stop.store(true, Ordering::Relaxed);
    });
}

fn bar(length: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} calls {per_sec} {elapsed}")
        .expect("the template is well-formed");
    ProgressBar::new(length).with_style(style)
}

/// Make a file small while a decoder fails on it alike.
///
/// The file is taken apart, made narrower, lower and simpler step by step, and written again; a step is kept if the
/// decoder still answers otherwise than the reference, and in the same way: a wrong picture, a refusal or a crash.
///
/// Exit status: 0 a smaller file was written, 1 the decoder does not fail on it, 2 wrong usage.
#[derive(Args)]
#[command(
    after_help = "Example:\n  ptm-conform minimise --view raw -o small.ptm large.ptm -- ./my-decoder"
)]
pub struct MinimiseArgs {
    /// raw, coef or rgb:LU,LV
    #[arg(long, default_value = "raw")]
    view: View,
    /// Where to write the small file; FILE with .small.ptm behind it unless told.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    call: CallArgs,
    /// A PTM file, or the id of a case.
    #[arg(value_name = "FILE|CASE")]
    file: String,
    /// The decoder and its arguments.
    #[arg(value_name = "DECODER", trailing_var_arg = true, required = true)]
    decoder: Vec<OsString>,
}

/// Minimises.
pub fn run_minimise(args: &MinimiseArgs) -> Result<u8, String> {
    let file = bytes_of(&args.file)?;
    let stop = stop_on_signals()?;
    let decoder = args.call.decoder(&args.decoder, &stop)?;
    let guarded = Guarded::new()?;
    let scratch = &guarded.scratch;
    let ask = |file: &[u8]| {
        let request = Request {
            name: "case",
            view: &args.view,
            file,
            largest_frame: 72 * (file.len() + (1 << 20)),
            patience: 1,
            alone: true,
        };
        decoder.ask(&request, scratch).answer
    };
    let Some(symptom) = symptom(&file, &args.view, &ask(&file)) else {
        print("the decoder answers as the reference does: there is nothing to make small\n");
        return Ok(1);
    };
    let bar = bar(0);
    let fails = |file: &[u8]| {
        bar.inc(1);
        symptom_is(&symptom, file, &args.view, &ask(file))
    };
    let small = reduce::reduce(&file, &stop, &fails);
    bar.finish_and_clear();
    let Some(small) = small else {
        print(
            "the failure depends on how the header is written: the file cannot be made smaller\n",
        );
        return Ok(EXIT_USAGE);
    };
    let out = args.out.clone().unwrap_or_else(|| beside(&args.file));
    std::fs::write(&out, &small).map_err(|error| format!("{}: {error}", out.display()))?;
    print(&format!(
        "{symptom}: {} bytes instead of {}, in {}\n",
        small.len(),
        file.len(),
        out.display()
    ));
    Ok(0)
}

fn bytes_of(name: &str) -> Result<Vec<u8>, String> {
    let suite = Suite::load()?;
    match suite.case(name) {
        Some(case) => Ok(case.build(TableSpelling::default()).file.clone()),
        None => super::files::read(Path::new(name)).map_err(|error| {
            format!("neither the id of a case nor a file that can be read: {error}")
        }),
    }
}

fn beside(name: &str) -> PathBuf {
    let stem = Path::new(name).file_stem().unwrap_or_default();
    PathBuf::from(format!("{}.small.ptm", stem.to_string_lossy()))
}

/// How an answer differs from the reference's, in words; nothing if it does not.
fn symptom(file: &[u8], view: &View, answer: &Answer) -> Option<String> {
    let expected = ptm_conform::decode(file)
        .ok()
        .map(|ptm| Frame::of(&ptm, view));
    match (expected, answer) {
        (Some(expected), Answer::Decoded(frame)) => {
            (!ptm_conform::harness::diagnose::alike(&expected, frame))
                .then(|| "another picture".to_owned())
        }
        (None, Answer::Decoded(_)) => Some("a picture of a malformed file".to_owned()),
        (Some(_), Answer::Rejected) => Some("a refusal of a legal file".to_owned()),
        (_, Answer::Rejected | Answer::Unsupported) => None,
        (_, other) => Some(other.name().to_owned()),
    }
}

fn symptom_is(known: &str, file: &[u8], view: &View, answer: &Answer) -> bool {
    symptom(file, view, answer).as_deref() == Some(known)
}
