//! `ptm-conform generate`: the corpus, requests for programs that cannot be called, corpora for other projects.

use std::path::{Path, PathBuf};

use clap::Args;

use super::names::did_you_mean;
use super::output::{jobs, note, with_progress};
use super::{CommandResult, files};
#[cfg(unix)]
use ptm_conform::protocol::frame::ViewKind;
#[cfg(unix)]
use ptm_conform::session::outputs;
use ptm_conform::suite::cases::{Suite, TableSpelling};
use ptm_conform::suite::corpus;
use ptm_conform::tools::profiles::{self, Profile};

/// Write test files: every file of the suite, the expected frame, and a manifest with digests.
///
/// A profile writes a corpus for other projects: expected images as arrays and image files, a manifest in YAML and JSON, and a README.
/// minimal has small files for every clause and NPY; standard adds every file up to 64 KiB and PNG; exhaustive has every
/// file and adds EXR. A version writes the same bytes on every machine.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform generate --out corpus\n  ptm-conform generate --profile minimal --out tests/ptm\n  ptm-conform generate --case hand-lum -o lum.ptm"
)]
pub struct GenerateArgs {
    /// The output directory; by default corpus, or requests with --requests. With a profile, it must be new or empty.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write requests for a viewer that check cannot call: the files, a list of requests, and a README. VIEW is raw, coef or rgb
    /// (default).
    ///
    /// Save the images in DIR/outputs/; `check --outputs DIR` judges them.
    #[cfg(unix)]
    #[arg(long, value_name = "VIEW", value_parser = ViewKind::NAMES, conflicts_with_all = ["all", "profile"], num_args = 0..=1, default_missing_value = "rgb")]
    requests: Option<String>,
    /// Write only the file of one case, to FILE (-o) or CASE.ptm.
    #[arg(long, value_name = "ID", conflicts_with_all = ["all", "profile", "out"])]
    case: Option<String>,
    /// The output file of --case.
    #[arg(short, long, value_name = "FILE", requires = "case")]
    output: Option<PathBuf>,
    /// Write a corpus for other projects: minimal, standard or exhaustive.
    #[arg(long, value_name = "PROFILE", conflicts_with = "all")]
    profile: Option<Profile>,
    /// Write the files over 4 KiB, too.
    #[arg(long)]
    all: bool,
    /// Files written in parallel; the result does not depend on it.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Writes the corpus, the requests or the profile.
pub fn run(args: &GenerateArgs) -> CommandResult {
    let suite = Suite::load()?;
    if let Some(id) = &args.case {
        return write_case(&suite, id, args.output.as_deref());
    }
    #[cfg(unix)]
    if let Some(view) = &args.requests {
        let out = args.out.as_deref().unwrap_or(Path::new("requests"));
        return export_requests(&suite, view, out);
    }
    let out = args.out.as_deref().unwrap_or(Path::new("corpus"));
    if let Some(profile) = args.profile {
        return write_profile(&suite, profile, out, jobs(args.jobs)?);
    }
    let (largest, hint) = match args.all {
        true => (usize::MAX, ""),
        false => (
            corpus::COMMITTED,
            "; larger files are only listed, --all writes them",
        ),
    };
    let jobs = jobs(args.jobs)?;
    let entries = with_progress(|progress| corpus::write(&suite, out, largest, jobs, &progress))
        .map_err(|error| error.to_string())?;
    let bytes = entries.iter().map(|entry| entry.bytes);
    let bytes: usize = bytes.filter(|&bytes| bytes <= largest).sum();
    let (count, out) = (entries.len(), out.display());
    note(&format!(
        "{count} cases, {bytes} bytes of PTM files in {out}{hint}\n"
    ));
    Ok(0)
}

/// Writes the file of one case.
fn write_case(suite: &Suite, id: &str, path: Option<&Path>) -> CommandResult {
    let case = suite.case(id).ok_or_else(|| {
        let ids = suite.cases.iter().map(|case| case.id.as_str());
        format!("no case is called {id:?}{}", did_you_mean(id, ids))
    })?;
    let path = path.map_or_else(|| PathBuf::from(format!("{id}.ptm")), Path::to_path_buf);
    let file = &case.build(TableSpelling::default()).file;
    files::write_whole(&path, file)?;
    let (path, size, expected) = (path.display(), file.len(), case.expect.name());
    note(&format!(
        "{path}: {size} bytes; expected: {expected}. More: ptm-conform explain {id}\n"
    ));
    Ok(0)
}

#[cfg(unix)]
fn export_requests(suite: &Suite, view: &str, out: &Path) -> CommandResult {
    let count = with_progress(|progress| outputs::export(suite, view, out, &progress))
        .map_err(|error| error.to_string())?;
    let out = out.display();
    note(&format!(
        "{count} requests for {view} in {out}; next steps: {out}/README.txt\n"
    ));
    Ok(0)
}

fn write_profile(suite: &Suite, profile: Profile, out: &Path, jobs: usize) -> CommandResult {
    let manifest = with_progress(|progress| profiles::write(suite, out, profile, jobs, &progress))
        .map_err(|error| error.to_string())?;
    let answers: usize = manifest.cases.iter().map(|case| case.expected.len()).sum();
    let (files, out) = (manifest.cases.len(), out.display());
    note(&format!(
        "{files} files and {answers} correct answers in {out}; README.md explains how to use them\n"
    ));
    Ok(0)
}
