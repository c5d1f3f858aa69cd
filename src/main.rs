//! Entry point of the program. Each command is implemented in a module of [`cli`].

mod cli;

use std::process::ExitCode;

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
    global: cli::output::GlobalArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    #[cfg(unix)]
    Probe(cli::probe::ProbeArgs),
    #[cfg(unix)]
    Check(cli::check_args::CheckArgs),
    #[cfg(not(unix))]
    Check(cli::elsewhere::UnsupportedArgs),
    #[cfg(unix)]
    CheckWriter(cli::check_writer::CheckWriterArgs),
    Reference(cli::reference::Args),
    Example(cli::example::ExampleArgs),
    Generate(cli::generate::GenerateArgs),
    Explain(cli::explain::ExplainArgs),
    #[cfg(unix)]
    Fuzz(cli::fuzz::FuzzArgs),
    #[cfg(unix)]
    #[command(name = "minimize", alias = "minimise")]
    Minimize(cli::minimize::MinimizeArgs),
    Inspect(cli::inspect::InspectArgs),
    Lint(cli::lint::LintArgs),
    Render(cli::render::RenderArgs),
    Export(cli::export::ExportArgs),
    Convert(cli::convert::ConvertArgs),
    Diff(cli::diff::DiffArgs),
    Completions(cli::completions::CompletionsArgs),
    Man(cli::completions::ManArgs),
    #[cfg(unix)]
    Texture(cli::texture::TextureArgs),
    #[cfg(unix)]
    Site(cli::site::SiteArgs),
    #[cfg(unix)]
    Report(cli::report::ReportArgs),
    #[cfg(unix)]
    Coverage(cli::coverage::CoverageArgs),
    /// When standard input ends, kills all processes that RUN left or that run in DIRECTORIES, and removes the
    /// directories.
    #[cfg(unix)]
    #[command(hide = true)]
    Watch {
        run: u32,
        directories: Vec<std::path::PathBuf>,
    },
}

fn main() -> ExitCode {
    #[cfg(unix)]
    cli::guard::override_signal_dispositions();
    let cli = Cli::parse();
    cli.global.apply();
    let outcome = match cli.command {
        #[cfg(unix)]
        Command::Check(args) => cli::check::run(&args),
        #[cfg(not(unix))]
        Command::Check(args) => cli::elsewhere::run(&args),
        #[cfg(unix)]
        Command::CheckWriter(args) => cli::check_writer::run(&args),
        Command::Reference(args) => cli::reference::run(&args),
        Command::Example(args) => Ok(cli::example::run(&args)),
        Command::Generate(args) => cli::generate::run(&args),
        Command::Explain(args) => cli::explain::run(&args),
        #[cfg(unix)]
        Command::Fuzz(args) => cli::fuzz::run(&args),
        #[cfg(unix)]
        Command::Minimize(args) => cli::minimize::run(&args),
        Command::Inspect(args) => cli::inspect::run(&args),
        Command::Lint(args) => cli::lint::run(&args),
        Command::Render(args) => cli::render::run(&args),
        Command::Export(args) => cli::export::run(&args),
        Command::Convert(args) => cli::convert::run(&args),
        Command::Diff(args) => cli::diff::run(&args),
        Command::Completions(args) => Ok(cli::completions::run(&args, Cli::command())),
        Command::Man(args) => cli::completions::run_man(&args, &Cli::command()),
        #[cfg(unix)]
        Command::Texture(args) => cli::texture::run(&args),
        #[cfg(unix)]
        Command::Site(args) => cli::site::run(&args),
        #[cfg(unix)]
        Command::Report(args) => cli::report::run(&args),
        #[cfg(unix)]
        Command::Probe(args) => cli::probe::run(&args),
        #[cfg(unix)]
        Command::Coverage(args) => cli::coverage::run(&args),
        #[cfg(unix)]
        Command::Watch { run, directories } => Ok(cli::guard::watch(run, &directories)),
    };
    outcome.map_or_else(
        |failed| {
            cli::output::print_error(&failed.message);
            ExitCode::from(failed.status)
        },
        ExitCode::from,
    )
}
