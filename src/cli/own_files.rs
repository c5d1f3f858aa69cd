//! `ptm-conform check --files`: checks the user's own files.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{fs, io};

use ptm_harness::runner::run::Decoder;
use ptm_harness::runner::scratch::Scratch;
use ptm_harness::session::files::{FileResult, FilesReport, check_file};
use ptm_suite::kit::yaml::to_yaml;
use ptm_suite::protocol::frame::{View, ViewKind};
use ptm_suite::protocol::request::Request;

use super::files::{read, with_path, write_atomically};
use super::guard::check_for_trouble;
use super::output::{print, with_progress};
use super::{CommandError, CommandResult, EXIT_NOTHING_SELECTED};

/// Checks the PTM files in `directory` and writes `report`. Requests the views in `requested`, or all views if there are none.
pub fn check(
    directory: &Path,
    requested: &[ViewKind],
    report: &Path,
    decoder: &Decoder,
    scratch: &Scratch,
) -> CommandResult {
    let entries = fs::read_dir(directory).map_err(with_path(directory))?;
    let paths: io::Result<Vec<PathBuf>> = entries.map(|entry| Ok(entry?.path())).collect();
    let mut paths = paths.map_err(with_path(directory))?;
    let is_ptm = |suffix: &OsStr| suffix.eq_ignore_ascii_case("ptm");
    paths.retain(|path| path.extension().is_some_and(is_ptm));
    paths.sort();
    if paths.is_empty() {
        let says = format!("no .ptm files in {}", directory.display());
        return Err(CommandError::new(EXIT_NOTHING_SELECTED, &says));
    }
    let views = ["raw", "coef", View::DEFAULT_RGB].map(|view| view.parse().expect("a view"));
    let mut views: Vec<View> = views.into();
    views.retain(|view| requested.is_empty() || requested.contains(&view.kind()));
    let ask = |request: &Request<'_>| decoder.ask(request, scratch);
    let results: Result<Vec<_>, String> = with_progress(|progress| {
        let results = paths.iter().enumerate().map(|(i, path)| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let result = match read(path) {
                Ok(file) => check_file(&name, &file, &views, &ask),
                Err(why) => FileResult::not_run(&name, Some(why)),
            };
            check_for_trouble(decoder)?;
            progress(i + 1, paths.len());
            Ok(result)
        });
        results.collect()
    });
    let results = FilesReport::new(results?);
    write_atomically(report, to_yaml(&results)?)?;
    print(&results.to_text());
    print(&format!("report: {}\n", report.display()));
    Ok(results.exit_status())
}
