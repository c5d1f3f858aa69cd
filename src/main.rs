//! The program: what it can be asked, and who answers; the commands stand in [`check`], [`commands`] and [`cli`].
//!
//! Commands that start somebody else's program need a Unix system; all others run everywhere.

mod cli;

mod reference;

#[cfg(unix)]
mod check;

#[cfg(unix)]
mod commands;

#[cfg(unix)]
mod texture_commands;

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

#[cfg(unix)]
use check::{
    CheckArgs, EXIT_NOTHING_SELECTED, Guarded, globs, parse_refusal, parse_size, positive_seconds,
    stop_on_signals,
};
use cli::completions::{CompletionsArgs, ManArgs};
use cli::convert::ConvertArgs;
use cli::diff::DiffArgs;
#[cfg(not(unix))]
use cli::elsewhere::CheckArgs;
use cli::export::ExportArgs;
#[cfg(unix)]
use cli::files::write_whole;
use cli::inspect::InspectArgs;
use cli::lint::LintArgs;
use cli::output::Global;
use cli::render::RenderArgs;
use ptm_conform::harness::cases::{self, Suite};
#[cfg(unix)]
use ptm_conform::harness::outputs;
use ptm_conform::harness::{corpus, misreadings};
use ptm_conform::tools::lint::codes::Code;
use ptm_conform::tools::profiles::Profile;

/// Wrong arguments, or a file that cannot be read or written.
const EXIT_USAGE: u8 = 2;

/// Conformance suite and reference decoder for Polynomial Texture Maps (PTM 1.2).
#[derive(Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Check(CheckArgs),
    Reference(reference::Args),
    Generate(GenerateArgs),
    Explain(ExplainArgs),
    #[cfg(unix)]
    Fuzz(cli::fuzz::FuzzArgs),
    #[cfg(unix)]
    Minimise(cli::fuzz::MinimiseArgs),
    Inspect(InspectArgs),
    Lint(LintArgs),
    Render(RenderArgs),
    Export(ExportArgs),
    Convert(ConvertArgs),
    Diff(DiffArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
    #[cfg(unix)]
    Texture(texture_commands::TextureArgs),
    #[cfg(unix)]
    Report(commands::report::ReportArgs),
    #[cfg(unix)]
    Probe(commands::probe::ProbeArgs),
    #[cfg(unix)]
    Coverage(commands::coverage::CoverageArgs),
    /// Waits until its standard input ends, then ends what still runs in DIRECTORIES and removes them.
    #[cfg(unix)]
    #[command(hide = true)]
    Watch {
        directories: Vec<PathBuf>,
    },
}

/// Write the corpus: every file of the suite, what a decoder finds in it, and a manifest with digests.
///
/// With a profile it is a corpus for other projects: right answers as NPY, PNG and EXR, a manifest in YAML and JSON, and a
/// README that says how to use them. minimal has small files for every clause, standard every file up to 64 KiB,
/// exhaustive everything. The same version writes the same bytes on every machine.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform generate --out corpus\n  ptm-conform generate --profile minimal --out tests/ptm"
)]
struct GenerateArgs {
    /// The directory to write to, corpus unless told, requests with --requests; with a profile, an empty or a new one.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write what somebody needs who has a viewer but no decoder that check could call: every file that VIEW (raw, coef or
    /// rgb, which is meant without it) can show, a list of requests, and a README.
    ///
    /// The answers are saved in outputs/ below DIR; check --outputs DIR judges them.
    #[cfg(unix)]
    #[arg(long, value_name = "VIEW", value_parser = ["raw", "coef", "rgb"], conflicts_with_all = ["all", "profile"], num_args = 0..=1, default_missing_value = "rgb")]
    requests: Option<String>,
    /// A corpus for other projects: minimal, standard or exhaustive.
    #[arg(long, value_name = "PROFILE", conflicts_with = "all")]
    profile: Option<Profile>,
    /// Write the files above 4 KiB too.
    #[arg(long)]
    all: bool,
    /// Files written at a time; the result does not depend on it.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Explain a case, a clause, a ruling, a misreading or a code of lint.
#[derive(Args)]
struct ExplainArgs {
    /// An id such as hand-rgb-blocks, 2.4/8, lut-count, rows-top-down or PTM-W102.
    id: String,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    cli.global.apply();
    let outcome = match cli.command {
        #[cfg(unix)]
        Command::Check(args) => check::run(&args),
        #[cfg(not(unix))]
        Command::Check(args) => cli::elsewhere::run(&args),
        Command::Reference(args) => Ok(reference::run(&args)),
        Command::Generate(args) => run_generate(&args),
        Command::Explain(args) => run_explain(&args),
        #[cfg(unix)]
        Command::Fuzz(args) => cli::fuzz::run_fuzz(&args),
        #[cfg(unix)]
        Command::Minimise(args) => cli::fuzz::run_minimise(&args),
        Command::Inspect(args) => cli::inspect::run(&args),
        Command::Lint(args) => cli::lint::run(&args),
        Command::Render(args) => cli::render::run(&args),
        Command::Export(args) => cli::export::run(&args),
        Command::Convert(args) => cli::convert::run(&args),
        Command::Diff(args) => cli::diff::run(&args),
        Command::Completions(args) => cli::completions::run(&args, Cli::command()),
        Command::Man(args) => cli::completions::run_man(&args, &Cli::command()),
        #[cfg(unix)]
        Command::Texture(args) => texture_commands::run(&args),
        #[cfg(unix)]
        Command::Report(args) => commands::report::run(&args),
        #[cfg(unix)]
        Command::Probe(args) => commands::probe::run(&args),
        #[cfg(unix)]
        Command::Coverage(args) => commands::coverage::run(&args),
        #[cfg(unix)]
        Command::Watch { directories } => Ok(check::watch(&directories)),
    };
    outcome.map_or_else(
        |error| {
            eprintln!("ptm-conform: {error}");
            ExitCode::from(EXIT_USAGE)
        },
        ExitCode::from,
    )
}

fn run_generate(args: &GenerateArgs) -> Result<u8, String> {
    let suite = Suite::load()?;
    #[cfg(unix)]
    if let Some(view) = &args.requests {
        let out = args.out.as_deref().unwrap_or(Path::new("requests"));
        return export_requests(&suite, view, out);
    }
    let out = args.out.as_deref().unwrap_or(Path::new("corpus"));
    if let Some(profile) = args.profile {
        return cli::profile::write(&suite, profile, out, jobs(args.jobs)?);
    }
    let largest = if args.all {
        usize::MAX
    } else {
        corpus::COMMITTED
    };
    let bar = progress_bar();
    let entries = corpus::write(&suite, out, largest, jobs(args.jobs)?, &|done, all| {
        show_progress(&bar, done, all);
    });
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
        out.display(),
        if args.all {
            ""
        } else {
            "; larger files are only listed, --all writes them"
        }
    ));
    Ok(0)
}

#[cfg(unix)]
fn export_requests(suite: &Suite, view: &str, out: &Path) -> Result<u8, String> {
    let bar = progress_bar();
    let count = outputs::export(suite, view, out, &|done, all| {
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    let count = count.map_err(|error| error.to_string())?;
    let out = out.display();
    print(&format!(
        "{count} requests for {view} in {out}; how to go on: {out}/README.txt\n"
    ));
    Ok(0)
}

fn run_explain(args: &ExplainArgs) -> Result<u8, String> {
    let Some(text) = explain(&args.id)? else {
        return Err(cli::explain::unknown(&args.id, &Suite::load()?)?);
    };
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
    if let Some(code) = Code::named(&id.to_uppercase()) {
        text += &cli::explain::code(code, &suite);
    }
    #[cfg(unix)]
    text.push_str(&texture_commands::explain(id)?);
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
    if cli::output::quiet() {
        return ProgressBar::hidden();
    }
    ProgressBar::new(0).with_style(style)
}

fn show_progress(bar: &ProgressBar, done: usize, all: usize) {
    bar.set_length(all as u64);
    bar.set_position(done as u64);
}
