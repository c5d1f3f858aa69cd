//! `check --baseline FILE --write-baseline FILE`: what is known, new and stale.

use std::path::{Path, PathBuf};

use clap::Args;

use ptm_conform::harness::baseline::{Baseline, News};
use ptm_conform::harness::cases::Suite;
use ptm_conform::harness::check::Run;

/// Lists of known failures.
#[derive(Args)]
pub struct KnownFailureArgs {
    /// Cases that are known to fail, so that only news fails the run.
    ///
    /// A YAML list of "- id: CASE", with a "reason:" below it where there is one. A listed case that fails is known and no
    /// failure of the run. A failing case that is not listed is new: exit status 1. If nothing is new, but a listed case
    /// passes, the list is stale: exit status 4, with the names; take them out, or write the list anew. Listed cases that
    /// are not selected, or are unsupported, inconclusive or not judged, are left alone. A name that no case has, or
    /// twice the same, is wrong usage. The verdict in the report stays what it is: a known failure is a failure.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Write the list that makes all failures of this run known.
    ///
    /// It holds the cases that failed, with the reasons that --baseline gives them, and the cases of --baseline that were
    /// neither seen to fail nor to pass. It may be the same FILE. The exit status is the same with and without it. A run
    /// that ended early, or of a program that is no decoder, writes none.
    #[arg(long, value_name = "FILE")]
    write_baseline: Option<PathBuf>,
}

impl KnownFailureArgs {
    /// The list that is to be written.
    pub fn written(&self) -> Option<&Path> {
        self.write_baseline.as_deref()
    }

    /// Reads the list, if there is one.
    pub fn read(&self, suite: &Suite) -> Result<Option<Baseline>, String> {
        self.baseline
            .as_ref()
            .map(|path| Baseline::read(path, suite))
            .transpose()
    }

    /// Writes the list anew where that is asked for.
    pub fn write(&self, suite: &Suite, run: &Run, known: Option<&Baseline>) -> Result<(), String> {
        let Some(path) = &self.write_baseline else {
            return Ok(());
        };
        if run.ended_early.is_some() || run.not_a_decoder.is_some() {
            super::output::complain(&format!(
                "ptm-conform: the run is not whole, so {} is not written",
                path.display()
            ));
            return Ok(());
        }
        let list = known.cloned().unwrap_or_default();
        let list = list.renewed(suite, &run.judgement.cases);
        super::files::write_whole(path, &list)?;
        super::output::print(&format!("known failures: {}\n", path.display()));
        Ok(())
    }
}

/// What a run brings that was not known.
pub fn told(news: &News) -> String {
    let mut text = format!("known failures: {}", news.known.len());
    for (what, ids) in [
        ("new, not in the list", &news.new),
        ("stale, listed but passing", &news.stale),
    ] {
        if !ids.is_empty() {
            text += &format!("; {what}: {}\n  {}", ids.len(), ids.join("\n  "));
        }
    }
    text + "\n"
}
