//! The command line: all subcommands with their arguments.

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

#[cfg(not(unix))]
use crate::cli::elsewhere;
#[cfg(unix)]
use crate::cli::{
    check, check_args, check_writer, coverage, fuzz, guard, minimize, probe, report, site, texture,
};
use crate::cli::{
    completions, convert, diff, example, explain, export, generate, inspect, lint, output,
    reference, render,
};

/// Conformance suite and reference decoder for Polynomial Texture Maps (PTM 1.2).
#[derive(Parser)]
#[command(
    version,
    about,
    max_term_width = 100,
    after_help = "Examples:\n  ptm-conform probe ./my-decoder             test a new wrapper step by step\n  ptm-conform check ./my-decoder             run the suite\n  ptm-conform lint -r archive/               check a collection of files\n  ptm-conform generate --profile minimal --out tests/ptm\n\nDocumentation: https://ptm-conform.github.io/ptm-conform/"
)]
struct Cli {
    #[command(flatten)]
    global: output::GlobalArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    #[cfg(unix)]
    Probe(probe::ProbeArgs),
    #[cfg(unix)]
    Check(check_args::CheckArgs),
    #[cfg(not(unix))]
    Check(elsewhere::UnsupportedArgs),
    #[cfg(unix)]
    CheckWriter(check_writer::CheckWriterArgs),
    Reference(reference::Args),
    Example(example::ExampleArgs),
    Generate(generate::GenerateArgs),
    Explain(explain::ExplainArgs),
    #[cfg(unix)]
    Fuzz(fuzz::FuzzArgs),
    #[cfg(unix)]
    #[command(name = "minimize", alias = "minimise")]
    Minimize(minimize::MinimizeArgs),
    Inspect(inspect::InspectArgs),
    Lint(lint::LintArgs),
    Render(render::RenderArgs),
    Export(export::ExportArgs),
    Convert(convert::ConvertArgs),
    Diff(diff::DiffArgs),
    Completions(completions::CompletionsArgs),
    Man(completions::ManArgs),
    #[cfg(unix)]
    Texture(texture::TextureArgs),
    #[cfg(unix)]
    Site(site::SiteArgs),
    #[cfg(unix)]
    Report(report::ReportArgs),
    #[cfg(unix)]
    Coverage(coverage::CoverageArgs),
    /// When standard input ends, kills all processes that RUN left or that run in DIRECTORIES, and removes the
    /// directories.
    #[cfg(unix)]
    #[command(hide = true)]
    Watch {
        run: u32,
        directories: Vec<std::path::PathBuf>,
    },
}

/// Runs the subcommand on the command line of this process, and returns its exit status.
#[must_use]
pub fn run() -> ExitCode {
    #[cfg(unix)]
    guard::override_signal_dispositions();
    let cli = Cli::parse();
    cli.global.apply();
    let outcome = match cli.command {
        #[cfg(unix)]
        Command::Check(args) => check::run(&args),
        #[cfg(not(unix))]
        Command::Check(args) => elsewhere::run(&args),
        #[cfg(unix)]
        Command::CheckWriter(args) => check_writer::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Example(args) => Ok(example::run(&args)),
        Command::Generate(args) => generate::run(&args),
        Command::Explain(args) => explain::run(&args),
        #[cfg(unix)]
        Command::Fuzz(args) => fuzz::run(&args),
        #[cfg(unix)]
        Command::Minimize(args) => minimize::run(&args),
        Command::Inspect(args) => inspect::run(&args),
        Command::Lint(args) => lint::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Diff(args) => diff::run(&args),
        Command::Completions(args) => Ok(completions::run(&args, Cli::command())),
        Command::Man(args) => completions::run_man(&args, &Cli::command()),
        #[cfg(unix)]
        Command::Texture(args) => texture::run(&args),
        #[cfg(unix)]
        Command::Site(args) => site::run(&args),
        #[cfg(unix)]
        Command::Report(args) => report::run(&args),
        #[cfg(unix)]
        Command::Probe(args) => probe::run(&args),
        #[cfg(unix)]
        Command::Coverage(args) => coverage::run(&args),
        #[cfg(unix)]
        Command::Watch { run, directories } => Ok(guard::watch(run, &directories)),
    };
    outcome.map_or_else(
        |failed| {
            output::print_error(&failed.message);
            ExitCode::from(failed.status)
        },
        ExitCode::from,
    )
}
