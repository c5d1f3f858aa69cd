//! A decoder with mistakes of the catalog, for `ptm-conform check`:
//!
//! ```text
//! cargo build --release --example misread
//! ptm-conform check --serve -- target/release/examples/misread rows-top-down,no-128
//! ```

use std::env;
use std::io::{self, BufRead, Write};
use std::process::ExitCode;

use ptm::Reading;
use ptm_mistakes::Misreading;
use ptm_suite::protocol::frame::{Answer, EXIT_MALFORMED, EXIT_UNSUPPORTED, View};

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let result = match words[..] {
        [slugs, "serve"] => serve(slugs),
        [slugs, view, file] => respond(slugs, view, file),
        _ => Err("usage: misread SLUG[,SLUG] VIEW FILE, misread SLUG[,SLUG] serve".to_owned()),
    };
    result.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::from(2)
    })
}

/// Answers one request.
fn respond(slugs: &str, view: &str, file: &str) -> Result<ExitCode, String> {
    Ok(match answer(&find_misreadings(slugs)?, view, file)? {
        Answer::Decoded(frame) => {
            print(&frame.to_bytes())?;
            ExitCode::SUCCESS
        }
        Answer::Rejected => ExitCode::from(EXIT_MALFORMED as u8),
        _ => ExitCode::from(EXIT_UNSUPPORTED as u8),
    })
}

/// Answers the requests on standard input, in serve mode.
fn serve(slugs: &str) -> Result<ExitCode, String> {
    let mistakes = find_misreadings(slugs)?;
    for line in io::stdin().lock().lines() {
        let line = line.map_err(|error| format!("standard input: {error}"))?;
        let words: Vec<&str> = line.splitn(3, ' ').collect();
        let [number, view, file] = words[..] else {
            return Err(format!("expected SEQ VIEW PATH, found {line:?}"));
        };
        print(&match answer(&mistakes, view, file)? {
            Answer::Decoded(frame) => {
                let frame = frame.to_bytes();
                let first_line = format!("{number} ok {}\n", frame.len());
                [first_line.as_bytes(), &frame].concat()
            }
            Answer::Rejected => format!("{number} reject {EXIT_MALFORMED}\n").into_bytes(),
            _ => format!("{number} unsupported this\n").into_bytes(),
        })?;
    }
    Ok(ExitCode::SUCCESS)
}

fn find_misreadings(slugs: &str) -> Result<Vec<&'static Misreading>, String> {
    slugs
        .split(',')
        .filter(|slug| !slug.is_empty())
        .map(|slug| ptm_mistakes::find(slug).ok_or_else(|| format!("no misreading {slug}")))
        .collect()
}

fn answer(mistakes: &[&Misreading], view: &str, file: &str) -> Result<Answer, String> {
    let view: View = view.parse()?;
    let file = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
    Ok(ptm_mistakes::answer(mistakes, Reading::SPEC, &file, &view))
}

fn print(bytes: &[u8]) -> Result<(), String> {
    let mut out = io::stdout().lock();
    out.write_all(bytes)
        .and_then(|()| out.flush())
        .map_err(|error| format!("standard output: {error}"))
}
