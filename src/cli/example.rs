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
    /// The programming language: python, c, java, javascript or rust.
    #[arg(value_parser = parse_language)]
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

fn parse_language(text: &str) -> Result<String, String> {
    let languages = DECODERS.map(|(language, _)| language);
    match languages.contains(&text) {
        true => Ok(text.to_owned()),
        false => Err(format!(
            "there are starters in {}. A decoder may be in any language: it prints one line and the samples, and exits with 0, 65 or 69; start from `ptm-conform example python` and docs/protocol.md",
            languages.join(", ")
        )),
    }
}

pub fn run(args: &ExampleArgs) -> u8 {
    let is_asked = |(language, _): &&(&str, &str)| args.language == *language;
    output::print(DECODERS.iter().find(is_asked).map_or("", |(_, text)| text));
    0
}
