//! The end of a run, on one machine or many: the report is written and printed in all its forms, and compared with the
//! baseline.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::files::{can_be_written, with_path, write_whole};
use super::output::{complain, print};
use super::terminal::show;
use ptm_conform::report::Report;
use ptm_conform::report::baseline::{Baseline, BaselineNews};
use ptm_conform::report::github;
use ptm_conform::report::html;
use ptm_conform::report::junit;
use ptm_conform::report::reported::Reported;
use ptm_conform::session::run::Run;
use ptm_conform::suite::cases::Suite;
use ptm_conform::suite::test_case::TestCase;

/// Other forms of the report, and lists of known failures.
#[derive(Args)]
pub struct OutputArgs {
    /// Also write the report as an HTML page with images of the failures.
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Also write the report as JUnit XML.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Also write the report as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Leave the passing cases out of the report, and add a digest of all results: to keep the report in a repository.
    #[arg(long)]
    short: bool,
    /// Print GitHub annotations, and append the job summary to the file named by GITHUB_STEP_SUMMARY.
    #[arg(long)]
    github: bool,
    /// A list of known failures; only new failures fail the run.
    ///
    /// A YAML list of "- id: CASE" with an optional "reason:". A listed case that fails does not fail the run. A failing case that
    /// is not listed is new: exit status 1. If there are no new failures but a listed case passes, the list is out of date: exit
    /// status 4, with the names. Listed cases that are not selected, unsupported, inconclusive or not judged are ignored. An
    /// unknown or repeated id is a usage error. The verdicts in the report do not change.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Write a list of all failures of this run, for --baseline.
    ///
    /// It contains the failing cases, with their reasons in --baseline, and the cases of --baseline that neither failed nor
    /// passed. FILE may be the same. The exit status does not change. Nothing is written if the run ended early or the program
    /// is not a decoder.
    #[arg(long, value_name = "FILE")]
    write_baseline: Option<PathBuf>,
    /// Number of failures to print in full; the report has all of them.
    #[arg(long, value_name = "N", default_value_t = 10)]
    show: usize,
}

impl OutputArgs {
    /// Refuses an output file that cannot be written, or would be written twice, before long work begins.
    pub fn check(&self, report: &Path) -> Result<(), String> {
        let others = [&self.html, &self.junit, &self.json, &self.write_baseline];
        let others = others.into_iter().flatten().map(PathBuf::as_path);
        let outputs: Vec<&Path> = [report].into_iter().chain(others).collect();
        for (i, path) in outputs.iter().enumerate() {
            can_be_written(path)?;
            if outputs[..i].contains(path) {
                return Err(format!(
                    "{} is the output file of two options",
                    path.display()
                ));
            }
        }
        Ok(())
    }
}

/// The destinations and forms of a report.
pub struct Ending<'a> {
    /// The report.
    pub path: &'a Path,
    args: &'a OutputArgs,
    known: Option<Baseline>,
}

impl<'a> Ending<'a> {
    /// Reads the baseline, if one is given.
    pub fn new<C: TestCase>(
        suite: &Suite<C>,
        path: &'a Path,
        args: &'a OutputArgs,
    ) -> Result<Ending<'a>, String> {
        let known = args.baseline.as_ref();
        let known = known.map(|path| Baseline::read(path, suite)).transpose()?;
        Ok(Ending { path, args, known })
    }

    /// Writes the report in its current state, atomically, with known and new failures.
    pub fn write<C: Reported>(
        &self,
        suite: &Suite<C>,
        run: &Run<C>,
        report: &mut Report,
    ) -> Result<(), String> {
        let known = self.known.as_ref();
        report.baseline = known.map(|known| known.news(suite, &run.judgement.cases));
        let text = match self.args.short {
            true => report.clone().shortened()?.to_yaml(),
            false => report.to_yaml(),
        };
        write_whole(self.path, text?)
    }

    /// Writes and prints the report in all its forms; returns the exit status.
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
        let text = report.to_text(suite, self.args.show);
        // A GitHub runner would interpret some output of a decoder as commands.
        show(&match self.args.github {
            true => github::without_commands(&text),
            false => text,
        });
        print(&format!("report: {}\n", self.path.display()));
        self.write_renderings(suite, run, &report)?;
        self.write_baseline(suite, run)?;
        let Some(news) = report.baseline else {
            return Ok(run.exit_status());
        };
        print(&news_to_text(&news));
        Ok(news.exit_status(run))
    }

    /// Writes the other requested forms of the report.
    fn write_renderings<C: Reported>(
        &self,
        suite: &Suite<C>,
        run: &Run<C>,
        report: &Report,
    ) -> Result<(), String> {
        if let Some(path) = &self.args.html {
            write_whole(path, html::page(suite, report, Some(run))?)?;
            print(&format!("page: {}\n", path.display()));
        }
        if let Some(path) = &self.args.junit {
            write_whole(path, junit::junit(report))?;
        }
        if let Some(path) = &self.args.json {
            let json = serde_json::to_string(report).map_err(|error| error.to_string())?;
            write_whole(path, json)?;
        }
        if self.args.github {
            print(&github::annotations(report));
            let summary = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty());
            if let Some(path) = summary.as_deref().map(Path::new) {
                // The steps of a job append to one file.
                let file = fs::OpenOptions::new().append(true).create(true).open(path);
                let text = github::summary(report, suite.cases.len());
                file.and_then(|mut file| file.write_all(text.as_bytes()))
                    .map_err(with_path(path))?;
            }
        }
        Ok(())
    }

    /// Writes the baseline again if requested.
    fn write_baseline<C: TestCase>(&self, suite: &Suite<C>, run: &Run<C>) -> Result<(), String> {
        let Some(path) = &self.args.write_baseline else {
            return Ok(());
        };
        if run.ended_early.is_some() || run.not_a_decoder.is_some() {
            let path = path.display();
            let says = format!("ptm-conform: the run is incomplete, so {path} is not written");
            complain(&says);
            return Ok(());
        }
        let list = self.known.clone().unwrap_or_default();
        write_whole(path, list.renewed(suite, &run.judgement.cases))?;
        print(&format!("known failures: {}\n", path.display()));
        Ok(())
    }
}

/// Describes the failures that are not known, and the known ones that no longer fail.
fn news_to_text(news: &BaselineNews) -> String {
    let list = |what: &str, ids: &[String]| match ids.len() {
        0 => String::new(),
        count => format!("{what}: {count}\n  {}\n", ids.join("\n  ")),
    };
    let new = list("new failures, not in the list", &news.new);
    let stale = list("stale, listed but passing", &news.stale);
    format!("known failures: {}\n{new}{stale}", news.known.len())
}
