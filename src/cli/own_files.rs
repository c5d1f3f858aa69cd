//! `check --files`: files of the user's own.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use ptm_conform::harness::files::{FilesReport, check_file};
use ptm_conform::harness::protocol::View;
use ptm_conform::harness::run::{Decoder, Request};
use ptm_conform::harness::scratch::Scratch;

use super::EXIT_NOTHING_SELECTED;
use super::check::CheckArgs;
use super::files::write_whole;
use super::output::{print, progress_bar, show_progress};

/// `check --files`: no suite, but the files of a directory.
pub fn check(
    args: &CheckArgs,
    directory: &Path,
    decoder: &Decoder,
    scratch: &Scratch,
) -> Result<u8, String> {
    let named = |error: io::Error| format!("{}: {error}", directory.display());
    let mut paths: Vec<PathBuf> = fs::read_dir(directory)
        .map_err(named)?
        .map(|entry| entry.map(|entry| entry.path()).map_err(named))
        .collect::<Result<_, _>>()?;
    paths.retain(|path| {
        path.extension()
            .is_some_and(|suffix| suffix.eq_ignore_ascii_case("ptm"))
    });
    paths.sort();
    if paths.is_empty() {
        super::output::complain(&format!(
            "ptm-conform: no .ptm file in {}",
            directory.display()
        ));
        return Ok(EXIT_NOTHING_SELECTED);
    }
    let views: Vec<View> = ["raw", "coef", View::ORDINARY_LIGHT]
        .iter()
        .map(|view| view.parse::<View>())
        .collect::<Result<_, _>>()?;
    let views: Vec<View> = views
        .into_iter()
        .filter(|view| args.views.is_empty() || args.views.iter().any(|asked| asked == view.name()))
        .collect();
    let bar = progress_bar();
    let mut results = Vec::new();
    for (i, path) in paths.iter().enumerate() {
        let file = super::files::read(path)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ask = |request: &Request<'_>| decoder.ask(request, scratch);
        results.push(check_file(&name, &file, &views, &ask));
        show_progress(&bar, i + 1, paths.len());
    }
    bar.finish_and_clear();
    let report = FilesReport::new(results);
    write_whole(&args.report, &report.to_yaml()?)?;
    print(&report.to_text());
    print(&format!("report: {}\n", args.report.display()));
    Ok(report.exit_status())
}
