//! Subcommands `ptm-conform completions` and `ptm-conform man`.

use std::fs;
use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use super::files::with_path;
use super::{CommandResult, output};

/// Print completions for a shell.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform completions bash > ~/.local/share/bash-completion/completions/ptm-conform\n  ptm-conform completions zsh > \"${fpath[1]}/_ptm-conform\"\n  ptm-conform completions fish > ~/.config/fish/completions/ptm-conform.fish"
)]
pub struct CompletionsArgs {
    /// bash, elvish, fish, powershell or zsh.
    shell: Shell,
}

/// Write man pages, one for each command.
#[derive(Args)]
#[command(after_help = "Example:\n  ptm-conform man ~/.local/share/man/man1 && man ptm-conform")]
pub struct ManArgs {
    /// The directory to write to; created if it does not exist.
    directory: PathBuf,
}

pub fn run(args: &CompletionsArgs, mut program: Command) -> u8 {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, "ptm-conform", &mut text);
    output::print(&String::from_utf8_lossy(&text));
    0
}

pub fn run_man(args: &ManArgs, program: &Command) -> CommandResult {
    let directory = &args.directory;
    fs::create_dir_all(directory).map_err(with_path(directory))?;
    clap_mangen::generate_to(program.clone(), directory).map_err(with_path(directory))?;
    output::print_note(&format!("man pages in {}\n", directory.display()));
    Ok(0)
}
