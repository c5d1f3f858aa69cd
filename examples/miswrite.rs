//! A writer with a mistake of the catalog, for `ptm-conform check-writer`:
//!
//! ```text
//! cargo build --release --example miswrite
//! ptm-conform check-writer -- target/release/examples/miswrite rows-top-down
//! ```

use std::env;
use std::path::Path;
use std::process::ExitCode;

use ptm_writers::reference::{NotWritten, write_requested_file};
use ptm_writers::request::RequestHeader;
use ptm_writers::wrong_files::write_with_mistake;

fn main() -> ExitCode {
    let words: Vec<String> = env::args().collect();
    let [_, slug, _, request, out] = &words[..] else {
        eprintln!("usage: miswrite SLUG write REQUEST OUT");
        return ExitCode::from(2);
    };
    match write(slug, request, Path::new(out)) {
        Ok(status) => ExitCode::from(status),
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(2)
        }
    }
}

/// Writes the file of a writer with this mistake, or the correct file if the mistake does not affect it.
fn write(slug: &str, request: &str, out: &Path) -> Result<u8, String> {
    let mistake = ptm_mistakes::find(slug).ok_or_else(|| format!("no misreading {slug}"))?;
    let read = |path: &str| std::fs::read(path).map_err(|error| format!("{path}: {error}"));
    let header = RequestHeader::read(&read(request)?)?;
    let array = read(&header.planes)?;
    let request = header.with_planes(&array)?;
    let file =
        write_with_mistake(&request, mistake).map_or_else(|| write_requested_file(&request), Ok);
    match file {
        Ok(file) => {
            let message = |error| format!("{}: {error}", out.display());
            std::fs::write(out, file).map_err(message)?;
            Ok(0)
        }
        Err(NotWritten::Impossible(_)) => Ok(65),
        Err(NotWritten::Unsupported(_)) => Ok(69),
    }
}
