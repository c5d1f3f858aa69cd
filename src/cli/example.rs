//! `ptm-conform example`

use clap::{Args, ValueEnum};

use super::output;

/// Print a minimal decoder to start from: one-shot mode, serve mode, and one function to fill in.
///
/// The function decodes the stored values of PTM_FORMAT_LRGB; everything else is refused with exit status 69 (unsupported).
/// The first line of the program says how it is built and run.
#[derive(Args)]
#[command(
    after_help = "Example:\n  ptm-conform example python > decoder.py\n  ptm-conform check -- python3 decoder.py"
)]
pub struct ExampleArgs {
    /// The programming language.
    language: Language,
}

#[derive(Clone, Copy, ValueEnum)]
enum Language {
    Python,
    C,
    Java,
    #[value(name = "javascript")]
    JavaScript,
    Rust,
}

pub fn run(args: &ExampleArgs) -> u8 {
    output::print(match args.language {
        Language::Python => include_str!("../../examples/starters/decoder.py"),
        Language::C => include_str!("../../examples/starters/decoder.c"),
        Language::Java => include_str!("../../examples/starters/Decoder.java"),
        Language::JavaScript => include_str!("../../examples/starters/decoder.js"),
        Language::Rust => include_str!("../../examples/starters/decoder.rs"),
    });
    0
}
