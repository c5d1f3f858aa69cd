//! `ptm-conform generate`: writes the corpus, requests for programs that cannot be called, and corpora for other projects.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{jobs, print_note, with_progress};
use super::{CommandResult, files};
use super::{arguments::id_filter, names::did_you_mean};
use ptm::Format;
use ptm_files::profiles::{self, Profile};
#[cfg(unix)]
use ptm_harness::session::outputs;
#[cfg(unix)]
use ptm_harness::strength::smoke;
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::corpus;
#[cfg(unix)]
use ptm_suite::protocol::frame::ViewKind;

/// Write test files: every file of the suite, the expected frame, and a manifest with digests.
///
/// A profile writes a corpus for other projects: expected images as arrays and image files, a manifest in YAML and JSON, and a
/// README. minimal has small files for every clause, and NPY arrays; standard adds every file up to 64 KiB, and PNG images;
/// exhaustive has every file and adds EXR images. Each version of ptm-conform writes the same bytes on every machine.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform generate --out corpus\n  ptm-conform generate --profile minimal --ptm-format LRGB --out tests/ptm\n  ptm-conform generate --case hand-lum -o lum.ptm"
)]
pub struct GenerateArgs {
    /// The output directory. The default is corpus, or requests if --requests is given. With a profile, the directory must be new
    /// or empty. If --case matches one case, --out is the output file (by default ID.ptm), or a directory that exists or ends in
    /// /.
    #[arg(short, long, alias = "output", value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write requests for a viewer that check cannot call: files, a list of requests, and a README. VIEW is raw, coef or rgb
    /// (default).
    ///
    /// Save the images in DIR/outputs/; `check --outputs DIR` judges them.
    #[cfg(unix)]
    #[arg(long, value_name = "VIEW", value_parser = ViewKind::NAMES, conflicts_with_all = ["all", "case", "profile"], num_args = 0..=1, default_missing_value = "rgb")]
    requests: Option<String>,
    /// Write only the files of cases whose id matches, each as ID.ptm; * and ? are wildcards. Repeatable.
    #[arg(long = "case", id = "case", value_name = "GLOB", conflicts_with_all = ["all", "profile"])]
    cases: Vec<String>,
    /// Write a corpus for other projects: minimal, standard or exhaustive.
    #[arg(long, value_name = "PROFILE", conflicts_with = "all")]
    profile: Option<Profile>,
    /// With --requests, write only those of the smoke subset.
    #[cfg(unix)]
    #[arg(long, requires = "requests")]
    smoke: bool,
    /// With a profile or --requests, write only files of this format, such as LRGB or JPEG_RGB. Repeatable.
    #[arg(long = "ptm-format", value_name = "FORMAT", value_parser = super::arguments::parse_format)]
    formats: Vec<Format>,
    /// Also write files over 4 KiB.
    #[arg(long)]
    all: bool,
    /// Number of files written in parallel; does not affect the result.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Writes the corpus, the requests or the profile.
pub fn run(args: &GenerateArgs) -> CommandResult {
    let (mut suite, formats) = (Suite::load()?, &args.formats);
    let selects_formats = args.profile.is_some() || !args.cases.is_empty();
    #[cfg(unix)]
    let selects_formats = selects_formats || args.requests.is_some();
    if !formats.is_empty() && !selects_formats {
        return Err("--ptm-format needs --profile, --requests or --case"
            .to_owned()
            .into());
    }
    #[cfg(unix)]
    if args.smoke {
        let smoke = smoke::ids(formats)?;
        suite.cases.retain(|case| smoke.contains(&case.id));
    }
    suite
        .cases
        .retain(|case| formats.is_empty() || formats.contains(&case.format()));
    if !args.cases.is_empty() {
        return write_cases(&suite, &args.cases, args.out.as_deref());
    }
    #[cfg(unix)]
    if let Some(view) = &args.requests {
        let out = args.out.as_deref().unwrap_or(Path::new("requests"));
        let count = with_progress(|progress| outputs::export(&suite, view, out, &progress))
            .map_err(|error| error.to_string())?;
        let out = out.display();
        print_note(&format!(
            "{count} requests for {view} in {out}; next steps: {out}/README.txt\n"
        ));
        return Ok(0);
    }
    let out = args.out.as_deref().unwrap_or(Path::new("corpus"));
    if let Some(profile) = args.profile {
        let jobs = jobs(args.jobs)?;
        let made = with_progress(|bar| profiles::write(&suite, out, profile, jobs, &bar));
        let cases = made.map_err(|error| error.to_string())?.cases;
        let answers: usize = cases.iter().map(|case| case.expected.len()).sum();
        let (files, out) = (cases.len(), out.display());
        print_note(&format!(
            "{files} files and {answers} correct answers in {out}; README.md explains how to use them\n"
        ));
        return Ok(0);
    }
    let (largest, hint) = match args.all {
        true => (usize::MAX, ""),
        false => (
            corpus::MAX_COMMITTED_SIZE,
            "; larger files are only listed (--all writes them)",
        ),
    };
    let jobs = jobs(args.jobs)?;
    let entries = with_progress(|progress| corpus::write(&suite, out, largest, jobs, &progress))
        .map_err(|error| error.to_string())?;
    let bytes = entries.iter().map(|entry| entry.bytes);
    let bytes: usize = bytes.filter(|&bytes| bytes <= largest).sum();
    let (count, out) = (entries.len(), out.display());
    print_note(&format!(
        "{count} cases, {bytes} bytes of PTM files in {out}{hint}\n"
    ));
    Ok(0)
}

/// Writes the files of the cases whose ids match one of `globs`.
fn write_cases(suite: &Suite, globs: &[String], out: Option<&Path>) -> CommandResult {
    let ids = || suite.cases.iter().map(|case| case.id.as_str());
    for glob in globs {
        let is_named = id_filter("--case", std::slice::from_ref(glob))?;
        if !ids().any(is_named) {
            let hint = did_you_mean(glob, ids());
            return Err(format!("no case id matches {glob:?}{hint}").into());
        }
    }
    let is_named = id_filter("--case", globs)?;
    let cases = suite.cases.iter().filter(|case| is_named(&case.id));
    let cases: Vec<&Case> = cases.collect();
    let is_directory =
        |path: &&Path| path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/");
    let directory = out.filter(|path| cases.len() > 1 || is_directory(path));
    if let Some(directory) = directory {
        fs::create_dir_all(directory).map_err(files::with_path(directory))?;
    }
    for case in &cases {
        let id = &case.id;
        let path = match (directory, out) {
            (None, Some(file)) => file.to_path_buf(),
            (directory, _) => directory.unwrap_or(Path::new("")).join(format!("{id}.ptm")),
        };
        let file = &case.build(TableSpelling::default()).file;
        files::write_atomically(&path, file)?;
        let (path, size, expected) = (path.display(), file.len(), case.expect.name());
        print_note(&format!(
            "{path}: {size} bytes; expected outcome: {expected}. More: ptm-conform explain {id}\n"
        ));
    }
    Ok(0)
}
