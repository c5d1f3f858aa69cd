//! `ptm-conform check` on systems where it cannot be.

use std::ffi::OsString;

use clap::Args;

use super::Outcome;

/// Run every case against a decoder: on Unix systems only.
#[derive(Args)]
pub struct CheckArgs {
    /// Whatever was asked.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    words: Vec<OsString>,
}

pub fn run(args: &CheckArgs) -> Outcome {
    let words: Vec<String> = args
        .words
        .iter()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    Err(format!(
        "`check {}` bounds the decoder that it runs by means that this system lacks; under Linux, macOS or WSL it works. For tests of your own, `ptm-conform generate --profile standard` writes files and right answers here too",
        words.join(" ")
    ))
}
