//! `check --baseline FILE --write-baseline FILE`: known, new and stale failures.

use std::path::{Path, PathBuf};

use clap::Args;

use ptm_conform::report::baseline::{Baseline, BaselineNews};
use ptm_conform::session::run::Run;
use ptm_conform::suite::cases::Suite;
use ptm_conform::suite::test_case::TestCase;

/// Lists of known failures.
#[derive(Args)]
pub struct KnownFailureArgs {
    /// Cases that are known to fail, so that only new failures fail the run.
    ///
    /// A YAML list of "- id: CASE", with a "reason:" below it where there is one. A listed case that fails is known and no
    /// failure of the run. A failing case that is not listed is new: exit status 1. If nothing is new, but a listed case
    /// passes, the list is stale: exit status 4, with the names; remove them, or write the list again. Listed cases that
    /// are not selected, or are unsupported, inconclusive or not judged, are left alone. An unknown or
    /// repeated name is a usage error. The verdicts in the report do not change: a known failure is a failure.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Write the list that makes all failures of this run known.
    ///
    /// It holds the cases that failed, with the reasons that --baseline gives them, and the cases of --baseline that
    /// neither failed nor passed. It may be the same FILE. The exit status is the same with and without it. A run that ended
    /// early, or of a program that is not a decoder, writes none.
    #[arg(long, value_name = "FILE")]
    write_baseline: Option<PathBuf>,
}

impl KnownFailureArgs {
    /// The list that is to be written.
    pub fn written(&self) -> Option<&Path> {
        self.write_baseline.as_deref()
    }

    /// Reads the list, if there is one.
    pub fn read<C: TestCase>(&self, suite: &Suite<C>) -> Result<Option<Baseline>, String> {
        self.baseline
            .as_ref()
            .map(|path| Baseline::read(path, suite))
            .transpose()
    }

    /// Writes the list again if that was asked for.
    pub fn write<C: TestCase>(
        &self,
        suite: &Suite<C>,
        run: &Run<C>,
        known: Option<&Baseline>,
    ) -> Result<(), String> {
        let Some(path) = &self.write_baseline else {
            return Ok(());
        };
        if run.ended_early.is_some() || run.not_a_decoder.is_some() {
            super::output::complain(&format!(
                "ptm-conform: the run is incomplete, so {} is not written",
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

/// What a run showed that was not known, in words.
#[expect(
    clippy::format_push_string,
    reason = "texts are short where they are put together"
)]
pub fn in_words(news: &BaselineNews) -> String {
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
