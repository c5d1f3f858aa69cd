//! A decoder with mistakes of the catalog, for `ptm-conform check`:
//!
//! ```text
//! cargo build --release --example misread
//! ptm-conform check -- target/release/examples/misread rows-top-down,no-128
//! ```

use std::env;
use std::io::{self, Write};
use std::process::ExitCode;

use ptm::Reading;
use ptm_mistakes::Misreading;
use ptm_suite::protocol::frame::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, View};

fn main() -> ExitCode {
    let words: Vec<String> = env::args().collect();
    let [_, slugs, view, file] = &words[..] else {
        eprintln!("usage: misread SLUG[,SLUG] VIEW FILE");
        return ExitCode::from(2);
    };
    match answer(slugs, view, file) {
        Ok(Answer::Decoded(frame)) => {
            let mut out = io::BufWriter::new(io::stdout().lock());
            match frame.write(&mut out).and_then(|()| out.flush()) {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => {
                    eprintln!("standard output: {error}");
                    ExitCode::from(2)
                }
            }
        }
        Ok(Answer::Rejected) => ExitCode::from(EXIT_MALFORMED as u8),
        Ok(_) => ExitCode::from(EXIT_UNSUPPORTED as u8),
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(2)
        }
    }
}

fn answer(slugs: &str, view: &str, file: &str) -> Result<Answer, String> {
    let mistakes: Vec<&Misreading> = slugs
        .split(',')
        .filter(|slug| !slug.is_empty())
        .map(|slug| ptm_mistakes::find(slug).ok_or_else(|| format!("no misreading {slug}")))
        .collect::<Result<_, _>>()?;
    let view: View = view.parse()?;
    let file = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
    Ok(ptm_mistakes::answer(&mistakes, Reading::SPEC, &file, &view))
}
