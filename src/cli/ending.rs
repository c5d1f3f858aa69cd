//! The end of a run, of one machine or of many: the report is written and printed in all its forms.

use std::path::Path;

use super::files::write_whole;
use super::known_failures::{self, KnownFailureArgs};
use super::output::{complain, print};
use super::renderings::RenderingArgs;
use super::terminal::show;
use ptm_conform::report::Report;
use ptm_conform::report::baseline::Baseline;
use ptm_conform::report::reported::Reported;
use ptm_conform::session::run::Run;
use ptm_conform::suite::cases::Suite;
use ptm_conform::suite::test_case::TestCase;

/// Where a report goes, and in which forms.
pub struct Ending<'a> {
    /// The report.
    pub path: &'a Path,
    /// How many failures are printed in full.
    show: usize,
    renderings: &'a RenderingArgs,
    args: &'a KnownFailureArgs,
    known: Option<Baseline>,
}

impl<'a> Ending<'a> {
    /// Reads the list of known failures, if one is given.
    pub fn new<C: TestCase>(
        suite: &Suite<C>,
        path: &'a Path,
        show: usize,
        renderings: &'a RenderingArgs,
        args: &'a KnownFailureArgs,
    ) -> Result<Ending<'a>, String> {
        let known = args.read(suite)?;
        Ok(Ending {
            path,
            show,
            renderings,
            args,
            known,
        })
    }

    /// Writes the report as it stands, whole or not at all, with what is known and what is new.
    pub fn write<C: Reported>(
        &self,
        suite: &Suite<C>,
        run: &Run<C>,
        report: &mut Report,
    ) -> Result<(), String> {
        let known = self.known.as_ref();
        report.baseline = known.map(|known| known.news(suite, &run.judgement.cases));
        write_whole(self.path, report.to_yaml()?)
    }

    /// Writes and prints the report in all its forms; the exit status.
    pub fn finish<C: Reported>(
        &self,
        suite: &Suite<C>,
        run: &Run<C>,
        mut report: Report,
    ) -> Result<u8, String> {
        self.write(suite, run, &mut report)?;
        if let Some(why) = run.ended_early {
            complain(&format!("ptm-conform: {why}"));
        }
        show(&self.renderings.printable(report.to_text(suite, self.show)));
        print(&format!("report: {}\n", self.path.display()));
        self.renderings.write(suite, &report, run)?;
        self.args.write(suite, run, self.known.as_ref())?;
        let Some(news) = report.baseline else {
            return Ok(run.exit_status());
        };
        print(&known_failures::in_words(&news));
        Ok(news.exit_status(run))
    }
}
