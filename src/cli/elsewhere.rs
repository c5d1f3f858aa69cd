//! Replacement for `ptm-conform check` on systems where it is not available.

use std::ffi::OsString;

use clap::Args;

use super::CommandResult;

/// Run every case against a decoder (on Unix systems only).
#[derive(Args)]
pub struct UnsupportedArgs {
    /// Any arguments.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    words: Vec<OsString>,
}

pub fn run(args: &UnsupportedArgs) -> CommandResult {
    let words = args.words.iter().map(|word| word.to_string_lossy());
    let words = words.collect::<Vec<_>>().join(" ");
    let says = format!(
        "`check {words}` needs Linux, macOS or WSL: this system cannot limit the decoder as required. For your own tests, `ptm-conform generate --profile standard` writes files and correct answers on this system, too"
    );
    Err(says.into())
}
