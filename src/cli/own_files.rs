//! `check --files`: the user's files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use ptm_conform::kit::yaml::to_yaml;
use ptm_conform::protocol::frame::View;
use ptm_conform::runner::run::{Decoder, Request};
use ptm_conform::runner::scratch::Scratch;
use ptm_conform::session::files::{FilesReport, check_file};

use super::files::write_whole;
use super::guard::check_trouble;
use super::output::{print, with_progress};
use super::{CommandResult, EXIT_NOTHING_SELECTED, Failed};

/// Checks the PTM files of `directory` in the views `asked`, or in all, and writes the `report`.
pub fn check(
    directory: &Path,
    asked: &[String],
    report: &Path,
    decoder: &Decoder,
    scratch: &Scratch,
) -> CommandResult {
    let paths = maps_in(directory)?;
    if paths.is_empty() {
        let says = format!("no .ptm file in {}", directory.display());
        return Err(Failed::new(EXIT_NOTHING_SELECTED, &says));
    }
    let views: Vec<View> = ["raw", "coef", View::ORDINARY_LIGHT]
        .iter()
        .map(|view| view.parse::<View>().expect("a view"))
        .filter(|view| asked.is_empty() || asked.iter().any(|asked| asked == view.name()))
        .collect();
    let ask = |request: &Request<'_>| decoder.ask(request, scratch);
    let results: Result<Vec<_>, String> = with_progress(|progress| {
        let results = paths.iter().enumerate().map(|(i, path)| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let result = check_file(&name, &super::files::read(path)?, &views, &ask);
            check_trouble(decoder)?;
            progress(i + 1, paths.len());
            Ok(result)
        });
        results.collect()
    });
    let results = FilesReport::new(results?);
    write_whole(report, to_yaml(&results)?)?;
    print(&results.to_text());
    print(&format!("report: {}\n", report.display()));
    Ok(results.exit_status())
}

/// Returns the PTM files of a directory, by name.
fn maps_in(directory: &Path) -> Result<Vec<PathBuf>, String> {
    let named = |error: io::Error| format!("{}: {error}", directory.display());
    let mut paths: Vec<PathBuf> = fs::read_dir(directory)
        .map_err(named)?
        .map(|entry| entry.map(|entry| entry.path()).map_err(named))
        .collect::<Result<_, _>>()?;
    let is_ptm = |path: &PathBuf| {
        let suffix = path.extension();
        suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("ptm"))
    };
    paths.retain(is_ptm);
    paths.sort();
    Ok(paths)
}
