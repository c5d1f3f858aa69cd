//! Subcommand `ptm-conform example`.

use clap::Args;

use super::output;

/// Print a minimal decoder to start from: one-shot mode, serve mode, and one function to fill in.
///
/// The function decodes the stored values of PTM_FORMAT_LRGB; everything else is refused with exit status 69 (unsupported). The
/// first line of the program says how to build and run it.
#[derive(Args)]
#[command(
    after_help = "Example:\n  ptm-conform example python > decoder.py\n  ptm-conform check -- python3 decoder.py"
)]
pub struct ExampleArgs {
    /// The programming language.
    #[arg(value_parser = DECODERS.map(|(language, _)| language))]
    language: String,
}

/// Source code of the example decoders, by language.
const DECODERS: [(&str, &str); 5] = [
    ("python", include_str!("../../examples/starters/decoder.py")),
    ("c", include_str!("../../examples/starters/decoder.c")),
    ("java", include_str!("../../examples/starters/Decoder.java")),
    (
        "javascript",
        include_str!("../../examples/starters/decoder.js"),
    ),
    ("rust", include_str!("../../examples/starters/decoder.rs")),
];

pub fn run(args: &ExampleArgs) -> u8 {
    let is_asked = |(language, _): &&(&str, &str)| args.language == *language;
    output::print(DECODERS.iter().find(is_asked).map_or("", |(_, text)| text));
    0
}
