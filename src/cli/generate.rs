//! `ptm-conform generate`: the corpus, requests for programs that nobody can call, corpora for other projects.

use std::path::{Path, PathBuf};

use clap::Args;

use super::Outcome;
use super::output::{jobs, note, progress_bar, show_progress};
use ptm_conform::harness::cases::Suite;
use ptm_conform::harness::corpus;
#[cfg(unix)]
use ptm_conform::harness::outputs;
use ptm_conform::tools::profiles::{self, Profile};

/// Write the corpus: every file of the suite, what a decoder finds in it, and a manifest with digests.
///
/// With a profile it is a corpus for other projects: right answers as NPY, PNG and EXR, a manifest in YAML and JSON, and a
/// README that says how to use them. minimal has small files for every clause, standard every file up to 64 KiB,
/// exhaustive everything. The same version writes the same bytes on every machine.
#[derive(Args)]
#[command(
    after_help = "Examples:\n  ptm-conform generate --out corpus\n  ptm-conform generate --profile minimal --out tests/ptm"
)]
pub struct GenerateArgs {
    /// The directory to write to, corpus unless told, requests with --requests; with a profile, an empty or a new one.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write what somebody needs who has a viewer but no decoder that check could call: every file that VIEW (raw, coef or
    /// rgb, which is meant without it) can show, a list of requests, and a README.
    ///
    /// The answers are saved in outputs/ below DIR; check --outputs DIR judges them.
    #[cfg(unix)]
    #[arg(long, value_name = "VIEW", value_parser = ["raw", "coef", "rgb"], conflicts_with_all = ["all", "profile"], num_args = 0..=1, default_missing_value = "rgb")]
    requests: Option<String>,
    /// A corpus for other projects: minimal, standard or exhaustive.
    #[arg(long, value_name = "PROFILE", conflicts_with = "all")]
    profile: Option<Profile>,
    /// Write the files above 4 KiB too.
    #[arg(long)]
    all: bool,
    /// Files written at a time; the result does not depend on it.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

/// Writes what was asked for.
pub fn run(args: &GenerateArgs) -> Outcome {
    let suite = Suite::load()?;
    #[cfg(unix)]
    if let Some(view) = &args.requests {
        let out = args.out.as_deref().unwrap_or(Path::new("requests"));
        return export_requests(&suite, view, out);
    }
    let out = args.out.as_deref().unwrap_or(Path::new("corpus"));
    if let Some(profile) = args.profile {
        return write_profile(&suite, profile, out, jobs(args.jobs)?);
    }
    let largest = if args.all {
        usize::MAX
    } else {
        corpus::COMMITTED
    };
    let bar = progress_bar();
    let entries = corpus::write(&suite, out, largest, jobs(args.jobs)?, &|done, all| {
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    let entries = entries.map_err(|error| error.to_string())?;
    let bytes: usize = entries
        .iter()
        .map(|entry| entry.bytes)
        .filter(|&bytes| bytes <= largest)
        .sum();
    note(&format!(
        "{} cases, {bytes} bytes of PTM files in {}{}\n",
        entries.len(),
        out.display(),
        if args.all {
            ""
        } else {
            "; larger files are only listed, --all writes them"
        }
    ));
    Ok(0)
}

#[cfg(unix)]
fn export_requests(suite: &Suite, view: &str, out: &Path) -> Outcome {
    let bar = progress_bar();
    let count = outputs::export(suite, view, out, &|done, all| {
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    let count = count.map_err(|error| error.to_string())?;
    let out = out.display();
    note(&format!(
        "{count} requests for {view} in {out}; how to go on: {out}/README.txt\n"
    ));
    Ok(0)
}

fn write_profile(suite: &Suite, profile: Profile, out: &Path, jobs: usize) -> Outcome {
    let bar = progress_bar();
    let manifest = profiles::write(suite, out, profile, jobs, &|done, all| {
        show_progress(&bar, done, all);
    });
    bar.finish_and_clear();
    let manifest = manifest.map_err(|error| error.to_string())?;
    let answers: usize = manifest.cases.iter().map(|case| case.expected.len()).sum();
    note(&format!(
        "{} files and {answers} right answers in {}; its README.md says how to use them\n",
        manifest.cases.len(),
        out.display()
    ));
    Ok(0)
}
