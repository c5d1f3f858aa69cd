//! The program: check, reference, generate, explain.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitCode, Stdio};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::{SIGINT, SIGTERM};

use ptm_conform::error::Class;
use ptm_conform::harness::cases::{self, Suite};
use ptm_conform::harness::check::{Plan, check};
use ptm_conform::harness::diagnose::diagnose;
use ptm_conform::harness::judge::Finding;
use ptm_conform::harness::protocol::{EXIT_MALFORMED, EXIT_UNSUPPORTED, Frame, View};
use ptm_conform::harness::report::Report;
use ptm_conform::harness::run::{Decoder, Request};
use ptm_conform::harness::{corpus, misreadings, processes};

/// Wrong arguments, or a file that cannot be read or written.
const EXIT_USAGE: u8 = 2;
/// No case matches what was asked for.
const EXIT_NOTHING_SELECTED: u8 = 5;

/// Conformance suite and reference decoder for Polynomial Texture Maps (PTM 1.2).
#[derive(Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Check(CheckArgs),
    Reference(ReferenceArgs),
    Generate(GenerateArgs),
    Explain(ExplainArgs),
    /// Waits until its standard input ends, then ends what still runs in SCRATCH and removes it.
    #[command(hide = true)]
    Watch {
        scratch: PathBuf,
    },
}

/// Run every case against a decoder and say which clauses it misreads.
///
/// The decoder is called as `DECODER [ARG…] VIEW FILE` once for each case, where VIEW is raw, coef or rgb:LU,LV. It
/// prints one line, "PTM1 VIEW WIDTH HEIGHT CHANNELS u8" (f32 for coef), then the samples, texel after texel, top row
/// first; and exits with 0, with 65 if the file is malformed, or with 69 if it does not read such files or views.
///
/// Exit status: 0 the decoder passes, 1 it fails, 2 wrong usage, 3 it is not a decoder, 5 no case was selected.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform check ./my-decoder\n  ptm-conform check -- python3 decode.py --strict\n  ptm-conform check --case '*lut*' --jobs 1 ./my-decoder"
)]
struct CheckArgs {
    /// Where to write the report.
    #[arg(long, value_name = "FILE", default_value = "ptm-conform-report.yaml")]
    report: PathBuf,
    /// Calls at a time; as many as there are processors unless told.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Wall-clock limit of a call; the first one gets three times as much.
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    timeout: f64,
    /// Memory that a call may hold, all its processes together: bytes, or with K, M or G.
    #[arg(long, value_name = "SIZE", default_value = "2G", value_parser = parse_size)]
    memory: u64,
    /// Only cases whose id matches; * and ? are wild cards. May be given more than once.
    #[arg(long = "case", value_name = "GLOB")]
    cases: Vec<String>,
    /// Only cases about this clause or section: 2.4/8, or 2.4. May be given more than once.
    #[arg(long = "clause", value_name = "ID")]
    clauses: Vec<String>,
    /// Ask in this view only. May be given more than once.
    #[arg(long = "view", value_name = "VIEW", value_parser = ["raw", "coef", "rgb"])]
    views: Vec<String>,
    /// An exit status that means "malformed" besides 65.
    #[arg(long, value_name = "N", value_parser = parse_refusal)]
    reject_exit: Option<i32>,
    /// Failures to print in full; the report has all of them.
    #[arg(long, value_name = "N", default_value_t = 10)]
    show: usize,
    /// The decoder and its arguments; the reference itself if there is none.
    #[arg(value_name = "DECODER", trailing_var_arg = true)]
    decoder: Vec<OsString>,
}

/// Decode FILE as the reference does and print the frame: the reference speaking the decoder protocol.
///
/// Exit status: 0, 65 if the file is malformed, 69 if it is not read.
#[derive(Args)]
struct ReferenceArgs {
    /// raw, coef or rgb:LU,LV
    view: View,
    /// A PTM file.
    file: PathBuf,
}

/// Write the corpus: every file of the suite, what a decoder finds in it, and a manifest with digests.
#[derive(Args)]
struct GenerateArgs {
    /// The directory to write to.
    #[arg(long, value_name = "DIR", default_value = "corpus")]
    out: PathBuf,
    /// Write the files above 4 KiB too.
    #[arg(long)]
    all: bool,
    /// Files written at a time; the result does not depend on it.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Explain a case, a clause, a ruling or a misreading.
#[derive(Args)]
struct ExplainArgs {
    /// An id such as hand-rgb-blocks, 2.4/8, lut-count or rows-top-down.
    id: String,
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Check(args) => run_check(&args),
        Command::Reference(args) => Ok(run_reference(&args)),
        Command::Generate(args) => run_generate(&args),
        Command::Explain(args) => run_explain(&args),
        Command::Watch { scratch } => Ok(watch(&scratch)),
    };
    outcome.map_or_else(
        |error| {
            eprintln!("ptm-conform: {error}");
            ExitCode::from(EXIT_USAGE)
        },
        ExitCode::from,
    )
}

fn run_check(args: &CheckArgs) -> Result<u8, String> {
    let suite = Suite::load()?;
    let selected = selection(&suite, args)?;
    if !selected.contains(&true) {
        eprintln!("ptm-conform: no case matches");
        return Ok(EXIT_NOTHING_SELECTED);
    }
    let command = if args.decoder.is_empty() {
        reference_command()?
    } else {
        args.decoder.clone()
    };
    let timeout = Duration::try_from_secs_f64(args.timeout)
        .map_err(|_| "a time limit is a positive number of seconds")?;
    if timeout.is_zero() {
        return Err("a time limit is a positive number of seconds".to_owned());
    }
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        signal_hook::flag::register(signal, Arc::clone(&stop))
            .map_err(|error| format!("no signals: {error}"))?;
    }
    processes::prepare();
    let mut decoder = Decoder::new(&command).map_err(|error| error.to_string())?;
    decoder.timeout = timeout;
    decoder.memory = args.memory;
    decoder.reject_exit = args.reject_exit;
    decoder.stop = Arc::clone(&stop);
    let scratch = Scratch::new()?;
    let plan = Plan {
        selected,
        jobs: jobs(args.jobs)?,
        views: ["raw", "coef", "rgb"]
            .into_iter()
            .filter(|view| args.views.iter().any(|asked| asked == view))
            .collect(),
        stop,
    };

    let partial = Partial::new(&args.report)?;
    let bar = progress_bar();
    let ask = |request: &Request<'_>, _: usize| decoder.ask(request, scratch.path());
    let run = check(&suite, &plan, &ask, &|case, finding, done, all| {
        partial.append(case, finding);
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();

    let diagnoses = diagnose(&suite, &run);
    let words: Vec<String> = command
        .iter()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let report = Report::new(&suite, &run, &diagnoses, &words, limits(args));
    write_whole(&args.report, &report.to_yaml()?)?;
    partial.remove();
    print(&report.to_text(&suite, args.show));
    print(&format!("report: {}\n", args.report.display()));
    Ok(run.exit_status())
}

/// The limits in force, in words.
fn limits(args: &CheckArgs) -> Vec<String> {
    let memory = if processes::can_be_watched() {
        format!(
            "memory: {} MiB, the resident sets of a call's processes, sampled",
            args.memory >> 20
        )
    } else {
        "memory: not limited, because this system has no /proc".to_owned()
    };
    vec![
        format!(
            "wall clock: {} s a call, three times that for the first",
            args.timeout
        ),
        memory,
        "standard output: 4 times the largest frame of the file and 64 KiB".to_owned(),
        "processes: the group of a call is killed when the call is over".to_owned(),
    ]
}

/// A directory for inputs and working directories, and a process that clears it away should this one be killed.
struct Scratch {
    directory: tempfile::TempDir,
    watcher: Option<Child>,
}

impl Scratch {
    fn new() -> Result<Scratch, String> {
        let directory = tempfile::Builder::new()
            .prefix("ptm-conform-")
            .tempdir()
            .map_err(|error| format!("no scratch directory: {error}"))?;
        // A decoder that is at work when this process is killed would be nobody's; without a watcher it only stays.
        let watcher = std::env::current_exe().and_then(|program| {
            std::process::Command::new(program)
                .arg("watch")
                .arg(directory.path())
                .stdin(Stdio::piped())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .process_group(0)
                .spawn()
        });
        Ok(Scratch {
            directory,
            watcher: watcher.ok(),
        })
    }

    fn path(&self) -> &Path {
        self.directory.path()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        processes::kill_all(self.path());
        if let Some(watcher) = &mut self.watcher {
            drop(watcher.stdin.take());
            let _ = watcher.wait();
        }
    }
}

fn watch(scratch: &Path) -> u8 {
    let _ = io::copy(&mut io::stdin(), &mut io::sink());
    processes::kill_all(scratch);
    let _ = fs::remove_dir_all(scratch);
    0
}

/// What has been found so far, beside the report: a list in YAML, valid after every case.
struct Partial {
    path: PathBuf,
    file: Mutex<fs::File>,
}

impl Partial {
    fn new(report: &Path) -> Result<Partial, String> {
        let mut path = report.as_os_str().to_owned();
        path.push(".partial");
        let path = PathBuf::from(path);
        let file =
            fs::File::create(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Partial {
            path,
            file: Mutex::new(file),
        })
    }

    fn append(&self, case: &cases::Case, finding: &Finding) {
        let line = format!(
            "- {{ id: {}, view: \"{}\", answer: {} }}\n",
            case.id,
            finding.view,
            finding.shown.name()
        );
        // One write for a line; what cannot be written is still in the report.
        let _ = self
            .file
            .lock()
            .expect("no worker panics")
            .write_all(line.as_bytes());
    }

    fn remove(self) {
        let _ = fs::remove_file(self.path);
    }
}

/// An exit status that may mean a refusal: 0 and 69 mean something else.
fn parse_refusal(text: &str) -> Result<i32, String> {
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

/// Bytes, or with K, M or G.
fn parse_size(text: &str) -> Result<u64, String> {
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

/// Which cases match the globs and the clauses; all if there are none.
fn selection(suite: &Suite, args: &CheckArgs) -> Result<Vec<bool>, String> {
    let globs: Vec<glob::Pattern> = args
        .cases
        .iter()
        .map(|text| glob::Pattern::new(text).map_err(|error| format!("--case {text}: {error}")))
        .collect::<Result<_, _>>()?;
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
    Ok(suite.cases.iter().map(matches).collect())
}

/// This program, asked as any other decoder.
fn reference_command() -> Result<Vec<OsString>, String> {
    let program =
        std::env::current_exe().map_err(|error| format!("cannot find this program: {error}"))?;
    Ok(vec![program.into(), "reference".into()])
}

fn run_reference(args: &ReferenceArgs) -> u8 {
    let file = match fs::read(&args.file) {
        Ok(file) => file,
        Err(error) => {
            eprintln!("ptm-conform: {}: {error}", args.file.display());
            return EXIT_USAGE;
        }
    };
    match ptm_conform::decode(&file) {
        Ok(ptm) => {
            let mut out = io::BufWriter::new(io::stdout().lock());
            let written = Frame::of(&ptm, &args.view)
                .write(&mut out)
                .and_then(|()| out.flush());
            match written {
                Ok(()) => 0,
                // The reader has what it wanted.
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => 0,
                Err(error) => {
                    eprintln!("ptm-conform: standard output: {error}");
                    EXIT_USAGE
                }
            }
        }
        Err(error) => {
            eprintln!("{}: {error}", args.file.display());
            let status = if error.class() == Class::Malformed {
                EXIT_MALFORMED
            } else {
                EXIT_UNSUPPORTED
            };
            status as u8
        }
    }
}

fn run_generate(args: &GenerateArgs) -> Result<u8, String> {
    let suite = Suite::load()?;
    let largest = if args.all {
        usize::MAX
    } else {
        corpus::COMMITTED
    };
    let bar = progress_bar();
    let entries = corpus::write(
        &suite,
        &args.out,
        largest,
        jobs(args.jobs)?,
        &|done, all| show_progress(&bar, done, all),
    );
    bar.finish_and_clear();
    let entries = entries.map_err(|error| error.to_string())?;
    let bytes: usize = entries
        .iter()
        .map(|entry| entry.bytes)
        .filter(|&bytes| bytes <= largest)
        .sum();
    print(&format!(
        "{} cases, {bytes} bytes of PTM files in {}{}\n",
        entries.len(),
        args.out.display(),
        if args.all {
            ""
        } else {
            "; larger files are only listed, --all writes them"
        }
    ));
    Ok(0)
}

fn run_explain(args: &ExplainArgs) -> Result<u8, String> {
    let text = explain(&args.id)?.ok_or_else(|| {
        format!("no case, clause, ruling or misreading is called {:?}; a section such as 2.8 lists its clauses", args.id)
    })?;
    print(&text);
    Ok(0)
}

/// What is known under that id.
fn explain(id: &str) -> Result<Option<String>, String> {
    let suite = Suite::load()?;
    let clauses = cases::clauses()?;
    let mut text = String::new();
    if let Some(case) = suite.case(id) {
        explain_case(case, &mut text).map_err(|error| error.to_string())?;
    }
    for clause in clauses.iter().filter(|clause| {
        clause.id == id
            || clause.id.starts_with(&format!("{id}/"))
            || clause.id.starts_with(&format!("{id}."))
    }) {
        let cases: Vec<&str> = suite
            .cases
            .iter()
            .filter(|case| case.clauses.contains(&clause.id))
            .map(|case| case.id.as_str())
            .collect();
        let ruling = clause
            .ruling
            .as_ref()
            .map(|ruling| format!(" Ruling: {ruling}."))
            .unwrap_or_default();
        let why = clause
            .why
            .as_ref()
            .map(|why| format!(" Not tested: it {why}."))
            .unwrap_or_default();
        let _ = writeln!(
            text,
            "clause {}: {}{ruling}{why}\n  {} cases: {}",
            clause.id,
            clause.rule,
            cases.len(),
            abbreviated(&cases)
        );
    }
    for ruling in cases::rulings()?.iter().filter(|ruling| ruling.id == id) {
        let _ = writeln!(
            text,
            "ruling {} ({:?}), clauses {}",
            ruling.id,
            ruling.kind,
            ruling.clauses.join(", ")
        );
        let _ = writeln!(
            text,
            "  open: {}\n  the reference: {}",
            ruling.question.trim(),
            ruling.reading.trim()
        );
        for also in &ruling.also {
            let _ = writeln!(text, "  also right: {also}");
        }
        let _ = writeln!(text, "  evidence: {}", ruling.evidence.trim());
    }
    if let Some(misreading) = misreadings::named(id) {
        let _ = writeln!(
            text,
            "misreading {} of clause {}: the decoder {}.",
            misreading.slug, misreading.clause, misreading.effect
        );
        let _ = writeln!(text, "  To mend it: {}.", misreading.mend);
        if let Some(clause) = clauses.iter().find(|clause| clause.id == misreading.clause) {
            let _ = writeln!(text, "  The clause says: {}", clause.rule);
        }
    }
    Ok(Some(text).filter(|text| !text.is_empty()))
}

fn explain_case(case: &cases::Case, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "case {} (clauses {}): {}",
        case.id,
        case.clauses.join(", "),
        case.because
    )?;
    writeln!(out, "  expected: {}", case.expect.name())?;
    if let (Some(twin), Some(damage)) = (&case.twin_of, case.damage()) {
        writeln!(out, "  it is {twin}, in which {}", damage.effect)?;
    }
    let views: Vec<String> = case.views.iter().map(ToString::to_string).collect();
    writeln!(
        out,
        "  asked in the first of these views that the decoder offers: {}",
        views.join(", ")
    )?;
    if let Some(ruling) = &case.ruling {
        writeln!(out, "  ruling: {ruling}")?;
    }
    let built = case.build(cases::TableSpelling::default());
    writeln!(
        out,
        "  file: {} bytes, sha-256 {}",
        built.file.len(),
        corpus::sha256(&built.file)
    )?;
    for (is, bytes) in case.pieces() {
        writeln!(out, "    {is:<40} {}", bytes.escape_ascii())?;
    }
    for field in &built.fields {
        let bytes = &built.file[field.range.clone()];
        let shown = bytes[..bytes.len().min(24)].escape_ascii();
        let more = if bytes.len() > 24 { "…" } else { "" };
        writeln!(
            out,
            "    byte {:>5}  {:<22} {:<8} {shown}{more}",
            field.range.start, field.name, field.clause
        )?;
    }
    Ok(())
}

fn abbreviated(ids: &[&str]) -> String {
    let shown = ids[..ids.len().min(6)].join(", ");
    if ids.len() > 6 {
        format!("{shown}, …")
    } else {
        shown
    }
}

/// Writes a file beside its place and moves it there, so that nobody ever sees half of it.
fn write_whole(path: &Path, text: &str) -> Result<(), String> {
    let named = |error: io::Error| format!("{}: {error}", path.display());
    let directory = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    // As readable as any file that a program writes.
    let readable = fs::Permissions::from_mode(0o644);
    let mut file = tempfile::Builder::new()
        .permissions(readable)
        .tempfile_in(directory)
        .map_err(named)?;
    file.write_all(text.as_bytes()).map_err(named)?;
    file.persist(path).map_err(|error| named(error.error))?;
    Ok(())
}

/// Prints to standard output; a reader that has gone away is no error.
fn print(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes());
}

fn jobs(asked: Option<usize>) -> Result<usize, String> {
    match asked {
        Some(0) => Err("--jobs needs at least 1".to_owned()),
        Some(jobs) => Ok(jobs),
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
    }
}

/// A bar on standard error, where that is a terminal.
fn progress_bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} {elapsed}")
        .expect("the template is well-formed");
    ProgressBar::new(0).with_style(style)
}

fn show_progress(bar: &ProgressBar, done: usize, all: usize) {
    bar.set_length(all as u64);
    bar.set_position(done as u64);
}
