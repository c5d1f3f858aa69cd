//! `ptm-conform check`, and what every command needs that starts somebody else's program.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use clap::Args;

use super::arguments::{globs, parse_refusal, parse_size, positive_seconds};
use super::files::{can_be_written, write_whole};
use super::guard::{Guarded, stop_on_signals};
use super::known_failures::{self, KnownFailureArgs};
use super::output::{jobs, print, progress_bar, show_progress, spinner};
use super::own_files;
use super::partial::Partial;
use super::renderings::RenderingArgs;
use super::subject::{self, Answers, Subject};
use super::{EXIT_NOTHING_SELECTED, texture};
use ptm_conform::harness::baseline::Baseline;
use ptm_conform::harness::capabilities::Capabilities;
use ptm_conform::harness::cases::{self, Suite};
use ptm_conform::harness::check::{Plan, Remark, Repeat, Run, SAMPLE, check};
use ptm_conform::harness::merge::{self, conclude};
use ptm_conform::harness::report::Report;
use ptm_conform::harness::run::{Decoder, Request};
use ptm_conform::harness::scratch::Scratch;
use ptm_conform::harness::serve::Servers;
use ptm_conform::harness::shards::{Circumstances, End, Keeper, Part, beside};
use ptm_conform::harness::{locale, processes, smoke};

/// Run every case against a decoder and say which clauses it misreads.
///
/// The decoder is called as `DECODER [ARG…] VIEW FILE` once for each case, where VIEW is raw, coef or rgb:LU,LV. It
/// prints one line, "PTM1 VIEW WIDTH HEIGHT CHANNELS u8" (f32 for coef), then the samples, texel after texel, top row
/// first; and exits with 0, with 65 if the file is malformed, or with 69 if it does not read such files or views.
///
/// Exit status: 0 the decoder passes, 1 it fails, 2 wrong usage, 3 it is not a decoder, 4 known failures
/// were mended and should be taken off the list, 5 no case was selected.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform check ./my-decoder\n  ptm-conform check -- python3 decode.py --strict\n  ptm-conform check --case '*lut*' --jobs 1 ./my-decoder\n  ptm-conform check --cmd 'viewer -u {lu} -v {lv} {in} -o {out}.png' --reject-exit 1\n  ptm-conform check --baseline known-failures.yaml ./my-decoder"
)]
pub struct CheckArgs {
    /// Where to write the report.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    pub report: PathBuf,
    /// Calls at a time; as many as there are processors unless told.
    #[arg(long, value_name = "N")]
    pub jobs: Option<usize>,
    /// Wall-clock limit of a call; the first one gets three times as much.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    pub timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    pub memory: u64,
    /// Only cases whose id matches; * and ? are wild cards. May be given more than once.
    #[arg(long = "case", value_name = "GLOB")]
    pub cases: Vec<String>,
    /// Only cases about this clause or section: 2.4/8, or 2.4. May be given more than once.
    #[arg(long = "clause", value_name = "ID")]
    pub clauses: Vec<String>,
    /// Which cases: those of PTM files, or those of the texture mapping table, asked as `DECODER texture FILE`.
    #[arg(long, value_name = "SUITE", default_value = "ptm", value_parser = ["ptm", "texture"])]
    pub suite: String,
    /// Ask in this view only. May be given more than once.
    #[arg(long = "view", value_name = "VIEW", value_parser = ["raw", "coef", "rgb"])]
    pub views: Vec<String>,
    /// Only one part of so many of the suite, 3/8 for example; keeps all answers in FILE.answers for `report merge`.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Part>,
    /// Ask processes that stay (`DECODER serve`); without this or --one-shot if the decoder's capabilities say so.
    #[arg(long, conflicts_with = "one_shot")]
    pub serve: bool,
    /// Ask a process of its own each time.
    #[arg(long)]
    pub one_shot: bool,
    /// An exit status that means "malformed" besides 65.
    ///
    /// Uncaught exceptions end many languages with 1, so a refusal through another status than 65 is marked weak in the
    /// report: a decoder that breaks down on every malformed file would pass such cases too.
    #[arg(long, value_name = "N", value_parser = parse_refusal)]
    pub reject_exit: Option<i32>,
    /// Instead of the suite, check every .ptm file in DIR: against the reference, and against other encodings of the
    /// same values.
    #[arg(long, value_name = "DIR")]
    pub files: Option<PathBuf>,
    /// Only the smoke subset: few cases that still catch every misreading of the catalogue.
    #[arg(long)]
    pub smoke: bool,
    /// Take this misreading as given and judge the rest; its name is in the diagnosis. May be given more than once.
    #[arg(long = "assume", value_name = "SLUG")]
    pub assumed: Vec<String>,
    /// Check a program that does not speak the protocol, by a line that calls it.
    ///
    /// The line is split as a shell splits it, but no shell runs. {in} is the PTM file; {out} the file to write, which may
    /// have a suffix ({out}.png), without it the answer is read from standard output; {lu} and {lv} are the light; {view}
    /// is raw, coef or rgb:LU,LV. {{ and }} are braces. The answer is a PNG or PPM picture, a NumPy array or a PTM1 frame.
    /// Asked in rgb alone unless {view} is there or --view names one view. Unless --reject-exit tells a refusal from
    /// a breakdown, files that must or may be refused are not judged.
    #[arg(long, value_name = "TEMPLATE", conflicts_with_all = ["decoder", "serve"])]
    pub cmd: Option<String>,
    /// Judge answers that were made elsewhere: by hand in a viewer, in a browser, on another system.
    ///
    /// DIR is a directory that `generate --requests` has written, to whose outputs/ the answers have come: for each
    /// case a file named after it, PNG, PPM, NumPy array or PTM1 frame, or its line in rejected.txt or unsupported.txt. What
    /// has no answer is not judged.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["decoder", "cmd", "serve", "reject_exit", "views", "files", "shard"])]
    pub outputs: Option<PathBuf>,
    #[command(flatten)]
    pub renderings: RenderingArgs,
    #[command(flatten)]
    pub known: KnownFailureArgs,
    /// Failures to print in full; the report has all of them.
    #[arg(long, value_name = "N", default_value_t = 10)]
    pub show: usize,
    /// The decoder and its arguments; the reference itself if there is none.
    #[arg(value_name = "DECODER", trailing_var_arg = true)]
    pub decoder: Vec<OsString>,
}

impl CheckArgs {
    /// The files that a run is to write.
    fn outputs_written(&self) -> Vec<&Path> {
        let report = [self.report.as_path()].into_iter();
        report
            .chain(self.renderings.files())
            .chain(self.known.written())
            .collect()
    }
}

/// Runs the suite.
pub fn run(args: &CheckArgs) -> Result<u8, String> {
    let timeout = positive_seconds(args.timeout)?;
    let stop = stop_on_signals()?;
    processes::prepare();
    let outputs = args.outputs_written();
    for (i, path) in outputs.iter().enumerate() {
        can_be_written(path)?;
        if outputs[..i].contains(path) {
            return Err(format!("{} is to be written twice", path.display()));
        }
    }
    if args.suite == "texture" {
        if args.smoke {
            return Err("--smoke is for the suite of PTM files".to_owned());
        }
        if args.renderings.any() {
            return Err("--html, --junit and --github are for the suite of PTM files".to_owned());
        }
        let (mut decoder, words) = subject::program(&args.decoder)?;
        decoder.timeout = timeout;
        decoder.memory = args.memory;
        decoder.stop = stop;
        return run_check_of_textures(args, &decoder, &words);
    }
    let suite = Suite::load()?;
    let mut selected = selection(&suite, args)?;
    if let Some(part) = args.shard {
        let cases = suite.cases.iter().zip(&mut selected);
        cases.for_each(|(case, selected)| *selected &= part.holds(&case.id));
    }
    if !selected.contains(&true) {
        super::output::complain(
            "ptm-conform: no case matches what --case, --clause and --shard ask for; ptm-conform explain 2.5 lists clauses and cases",
        );
        return Ok(EXIT_NOTHING_SELECTED);
    }
    merge::named(&args.assumed)?;
    let known = args.known.read(&suite)?;
    let mut subject = Subject::of(args, &suite)?;
    let guarded = Guarded::new()?;
    let scratch = &guarded.scratch;
    let (capabilities, notes) = match &mut subject.answers {
        Answers::Made(_) => (Capabilities::default(), Vec::new()),
        Answers::Program(decoder) => {
            decoder.timeout = timeout;
            decoder.memory = args.memory;
            decoder.stop = Arc::clone(&stop);
            let (capabilities, notes) = capabilities(decoder, scratch);
            decoder.reject_exit = args.reject_exit.or(capabilities.reject_exit);
            (capabilities, notes)
        }
    };
    if let (Some(directory), Some(decoder)) = (&args.files, subject.program()) {
        return own_files::check(args, directory, decoder, scratch);
    }
    let made_before = matches!(subject.answers, Answers::Made(_));
    let serves = args.serve || capabilities.serves && !args.one_shot;
    let plan = Plan {
        selected,
        jobs: jobs(args.jobs)?,
        views: subject.views.clone(),
        withheld: subject.withheld.clone(),
        made_before,
        declared: capabilities.clone(),
        repeat: match (made_before, serves) {
            (true, _) => Repeat::Nothing,
            (false, true) => Repeat::FailuresAndSample,
            (false, false) => Repeat::Failures,
        },
        stop,
    };

    let partial = Partial::new(&args.report)?;
    let bar = progress_bar();
    let keeper = args.shard.map(|_| keeper(&args.report)).transpose()?;
    let servers = subject
        .program()
        .filter(|_| serves)
        .map(|decoder| Servers::new(decoder, scratch, plan.jobs));
    let ask = |request: &Request<'_>, job: usize| {
        let reply = match (&subject.answers, &servers) {
            (Answers::Made(outputs), _) => outputs.ask(request),
            (Answers::Program(_), Some(servers)) => servers.ask(request, job),
            (Answers::Program(decoder), None) => decoder.ask(request, scratch),
        };
        let reply = subject.understand(&suite, request, reply);
        if let Some(keeper) = &keeper {
            keeper.answered(request, &reply);
        }
        reply
    };
    let mut run = check(&suite, &plan, &ask, &|case, finding, done, all| {
        partial.append(&case.id, &finding.view.to_string(), finding.shown.name());
        if let Some(keeper) = &keeper {
            keeper.found(case, finding);
        }
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    // One signal ends the calls, another one the search for causes.
    plan.stop.store(false, Ordering::Relaxed);
    let mut remarks = (Vec::new(), notes);
    if servers.as_ref().is_some_and(Servers::have_given_up) {
        remarks.0.push(Remark::failure(NOT_SERVED.to_owned()));
    }
    drop(servers);
    let locale =
        locale::with_comma().filter(|_| run.not_a_decoder.is_none() && run.ended_early.is_none());
    if let (Some(locale), Some(decoder)) = (&locale, subject.program()) {
        let differs = locale::difference(&suite, &run, decoder, locale, scratch);
        remarks.1.extend(differs.map(Remark::failure));
    }
    let circumstances = Circumstances {
        name: capabilities.name.clone(),
        version: capabilities.version.clone(),
        serves,
        limits: limits(args, serves),
        ..Circumstances::of(&suite, &plan, &subject.words, &args.assumed)
    };
    let spinner = spinner("looking for causes");
    let mut report = conclude(&suite, &mut run, &circumstances, &remarks, plan.jobs)?;
    spinner.finish_and_clear();
    if made_before {
        "outputs".clone_into(&mut report.decoder.mode);
    }
    if let (Some(keeper), Some(part)) = (keeper, args.shard) {
        let end = End::of(
            &suite,
            &plan,
            &run,
            &report.tool,
            part,
            circumstances,
            remarks,
        );
        let kept = keeper.finish(end);
        kept.map_err(|error| format!("{}: {error}", beside(&args.report).display()))?;
    }
    let status = finish(
        &suite,
        &run,
        report,
        &args.report,
        args.show,
        (&args.known, known.as_ref()),
        &args.renderings,
    )?;
    partial.remove();
    Ok(status)
}

/// Writes and prints a report, with what is known and what is new; the exit status.
pub fn finish(
    suite: &Suite,
    run: &Run,
    mut report: Report,
    path: &Path,
    show: usize,
    (args, known): (&KnownFailureArgs, Option<&Baseline>),
    renderings: &RenderingArgs,
) -> Result<u8, String> {
    let news = known.map(|known| known.news(suite, &run.judgement.cases));
    report.baseline.clone_from(&news);
    write_whole(path, &report.to_yaml()?)?;
    print(&renderings.printable(report.to_text(suite, show)));
    print(&format!("report: {}\n", path.display()));
    renderings.write(suite, &report, run)?;
    args.write(suite, run, known)?;
    let Some(news) = news else {
        return Ok(run.exit_status());
    };
    print(&known_failures::told(&news));
    Ok(run.exit_status_with(&news))
}

/// What keeps the answers of a part of a run.
fn keeper(report: &Path) -> Result<Keeper, String> {
    let path = beside(report);
    Keeper::new(&path).map_err(|error| format!("{}: {error}", path.display()))
}

/// What is said of a decoder whose processes never answered.
const NOT_SERVED: &str = "serve mode does not work: its first requests went unanswered, and all others were asked of a process of their own";

/// What the decoder says of itself, and what there is to note about that.
fn capabilities(decoder: &Decoder, scratch: &Scratch) -> (Capabilities, Vec<Remark>) {
    match decoder.capabilities(scratch) {
        Ok(capabilities) => {
            let notes = capabilities.remarks.iter();
            let notes = notes.map(|says| Remark::note(format!("capabilities: {says}")));
            (capabilities.clone(), notes.collect())
        }
        // Most decoders have none.
        Err(_) => (Capabilities::default(), Vec::new()),
    }
}

fn run_check_of_textures(
    args: &CheckArgs,
    decoder: &Decoder,
    command: &[String],
) -> Result<u8, String> {
    if !args.views.is_empty() {
        return Err("--view is about PTM files; texture questions have one view".to_owned());
    }
    let globs = globs(&args.cases)?;
    let about = |clause: &String| {
        let mut asked = args.clauses.iter();
        asked.any(|asked| clause == asked || clause.starts_with(&format!("{asked}-")))
    };
    let guarded = Guarded::new()?;
    let partial = Partial::new(&args.report)?;
    let bar = progress_bar();
    let status = texture::run_check(
        texture::Check {
            decoder,
            command,
            scratch: &guarded.scratch,
            jobs: jobs(args.jobs)?,
            report: &args.report,
            limits: limits(args, false),
            show: args.show,
            selects: &|id, clauses| {
                (globs.is_empty() || globs.iter().any(|glob| glob.matches(id)))
                    && (args.clauses.is_empty() || clauses.iter().any(about))
            },
        },
        &|id, finding, done, all| {
            partial.append(id, "texture", finding.shown.name());
            show_progress(&bar, done, all);
        },
    )?;
    bar.finish_and_clear();
    partial.remove();
    Ok(status)
}

/// The limits in force, in words.
fn limits(args: &CheckArgs, serves: bool) -> Vec<String> {
    if args.outputs.is_some() {
        return vec!["none: the outputs were made elsewhere".to_owned()];
    }
    let watched = processes::can_be_watched();
    let memory = if watched {
        format!(
            "memory: {} MiB, the resident sets of a call's processes, sampled",
            args.memory >> 20
        )
    } else {
        "memory: not limited, because this system has no /proc".to_owned()
    };
    let left = if watched {
        "processes: the group of a call, and what has left it, are killed when the call is over"
    } else {
        "processes: the group of a call is killed when the call is over"
    };
    let mut limits = vec![
        format!(
            "wall clock: {} s a call, three times that for the first",
            args.timeout
        ),
        memory,
        "standard output: 4 times the largest frame of the file and 64 KiB".to_owned(),
        "files: 4 GiB each, no core dumps".to_owned(),
        left.to_owned(),
        "input: each file is held against its bytes after the call".to_owned(),
        "locale: C; the first files once more in one with a decimal comma, where there is one"
            .to_owned(),
    ];
    if serves {
        limits.push(format!("serve mode: one process a job; failures and one in {SAMPLE} of the rest are asked again one-shot"));
    }
    limits
}

/// Which cases match the globs and the clauses; all if there are none.
fn selection(suite: &Suite, args: &CheckArgs) -> Result<Vec<bool>, String> {
    let globs = globs(&args.cases)?;
    let about = |clause: &String| {
        args.clauses.iter().any(|asked| {
            clause == asked
                || clause.starts_with(&format!("{asked}/"))
                || clause.starts_with(&format!("{asked}."))
        })
    };
    let matches = |case: &cases::Case| {
        (globs.is_empty() || globs.iter().any(|glob| glob.matches(&case.id)))
            && (args.clauses.is_empty() || case.clauses.iter().any(about))
    };
    let smoke = if args.smoke {
        smoke::selection(suite)?
    } else {
        vec![true; suite.cases.len()]
    };
    let cases = suite.cases.iter().zip(smoke);
    Ok(cases.map(|(case, smoke)| smoke && matches(case)).collect())
}
