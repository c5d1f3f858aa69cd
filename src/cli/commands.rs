//! The command line: all subcommands with their arguments.

use std::process::ExitCode;

use clap::error::ContextKind;
use clap::{CommandFactory, Parser, Subcommand};

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
    global: super::output::GlobalArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    #[cfg(unix)]
    Probe(super::probe::ProbeArgs),
    #[cfg(unix)]
    Check(super::check_args::CheckArgs),
    #[cfg(not(unix))]
    Check(super::elsewhere::UnsupportedArgs),
    #[cfg(unix)]
    CheckWriter(super::check_writer::CheckWriterArgs),
    Reference(super::reference::Args),
    Example(super::example::ExampleArgs),
    Generate(super::generate::GenerateArgs),
    Explain(super::explain::ExplainArgs),
    #[cfg(unix)]
    Fuzz(super::fuzz::FuzzArgs),
    #[cfg(unix)]
    #[command(name = "minimize", alias = "minimise")]
    Minimize(super::minimize::MinimizeArgs),
    Inspect(super::inspect::InspectArgs),
    Lint(super::lint::LintArgs),
    Render(super::render::RenderArgs),
    Export(super::export::ExportArgs),
    Convert(super::convert::ConvertArgs),
    Diff(super::diff::DiffArgs),
    Completions(super::completions::CompletionsArgs),
    Man(super::completions::ManArgs),
    #[cfg(unix)]
    Texture(super::texture::TextureArgs),
    #[cfg(unix)]
    Site(super::site::SiteArgs),
    #[cfg(unix)]
    Report(super::report::ReportArgs),
    #[cfg(unix)]
    Coverage(super::coverage::CoverageArgs),
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
pub fn run() -> ExitCode {
    #[cfg(unix)]
    super::guard::override_signal_dispositions();
    let cli = Cli::try_parse().unwrap_or_else(|mut error| {
        // The tip to write `-- --option` is never the answer: the option would be passed to the decoder.
        error.remove(ContextKind::Suggested);
        error.exit()
    });
    cli.global.apply();
    let outcome = match cli.command {
        #[cfg(unix)]
        Command::Check(args) => super::check::run(&args),
        #[cfg(not(unix))]
        Command::Check(args) => super::elsewhere::run(&args),
        #[cfg(unix)]
        Command::CheckWriter(args) => super::check_writer::run(&args),
        Command::Reference(args) => super::reference::run(&args),
        Command::Example(args) => Ok(super::example::run(&args)),
        Command::Generate(args) => super::generate::run(&args),
        Command::Explain(args) => super::explain::run(&args),
        #[cfg(unix)]
        Command::Fuzz(args) => super::fuzz::run(&args),
        #[cfg(unix)]
        Command::Minimize(args) => super::minimize::run(&args),
        Command::Inspect(args) => super::inspect::run(&args),
        Command::Lint(args) => super::lint::run(&args),
        Command::Render(args) => super::render::run(&args),
        Command::Export(args) => super::export::run(&args),
        Command::Convert(args) => super::convert::run(&args),
        Command::Diff(args) => super::diff::run(&args),
        Command::Completions(args) => Ok(super::completions::run(&args, Cli::command())),
        Command::Man(args) => super::completions::run_man(&args, &Cli::command()),
        #[cfg(unix)]
        Command::Texture(args) => super::texture::run(&args),
        #[cfg(unix)]
        Command::Site(args) => super::site::run(&args),
        #[cfg(unix)]
        Command::Report(args) => super::report::run(&args),
        #[cfg(unix)]
        Command::Probe(args) => super::probe::run(&args),
        #[cfg(unix)]
        Command::Coverage(args) => super::coverage::run(&args),
        #[cfg(unix)]
        Command::Watch { run, directories } => Ok(super::guard::watch(run, &directories)),
    };
    outcome.map_or_else(
        |failed| {
            super::output::print_error(&failed.message);
            ExitCode::from(failed.status)
        },
        ExitCode::from,
    )
}
