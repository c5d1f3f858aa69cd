//! Entry point of the program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ptm_conform::cli::commands::run()
}
