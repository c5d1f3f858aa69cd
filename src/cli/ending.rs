//! Output at the end of a run or a merge: the report in all requested formats, and its comparison with the baseline.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::files::{check_writable, with_path, write_atomically};
use super::output::{print, print_error};
use super::terminal::print_styled;
use crate::report::html::{self, Evidence};
use crate::report::{github, junit, text};
use ptm_harness::pipeline::times::Times;
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_harness::report::{Report, baseline::Baseline, document::BaselineComparison};
use ptm_harness::session::run::Ending;
use ptm_suite::{cases::Suite, test_case::Listed};

/// Options for other output formats and for lists of known failures.
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
    /// Omit the passing cases from the report and add a digest of all results, for reports that are kept in a repository.
    #[arg(long)]
    short: bool,
    /// Print GitHub annotations, and append the job summary to the file named by GITHUB_STEP_SUMMARY.
    #[arg(long)]
    github: bool,
    /// A list of known failures; only new failures make the run fail.
    ///
    /// A YAML list of "- id: CASE" with an optional "reason:". A listed case that fails does not fail the run. A failing case
    /// that is not listed is new: exit status 1. If there are no new failures but a listed case passes, the list is out of date:
    /// exit status 4, and the cases are named. Listed cases that are unsupported, inconclusive, not judged or not selected are
    /// ignored. An unknown or repeated id is a usage error. The verdicts in the report do not change.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Write a list of all failures of this run, for --baseline.
    ///
    /// It contains the failing cases, with their reasons from --baseline, and the cases of --baseline that neither failed nor
    /// passed. FILE may be the --baseline file. The exit status does not change. Nothing is written if the run ended early or the
    /// program is not a decoder.
    #[arg(long, value_name = "FILE")]
    write_baseline: Option<PathBuf>,
    /// Number of failures without a cause to print in full; below a cause, one or two are printed. The report contains all of them.
    #[arg(long, value_name = "N", default_value_t = 10)]
    show: usize,
    /// List the N slowest cases, with the wall-clock time of all requests for each.
    #[arg(long, value_name = "N", default_value_t = 0)]
    durations: usize,
}

impl OutputArgs {
    /// Returns an error if an output file cannot be written or is given twice. Called before any lengthy work begins.
    pub fn check(&self, report: &Path) -> Result<(), String> {
        let others = [&self.html, &self.junit, &self.json, &self.write_baseline];
        let others = others.into_iter().flatten().map(PathBuf::as_path);
        let outputs: Vec<&Path> = [report].into_iter().chain(others).collect();
        for (i, path) in outputs.iter().enumerate() {
            check_writable(path)?;
            if outputs[..i].contains(path) {
                let path = path.display();
                return Err(format!("{path} is the output file of two options"));
            }
        }
        Ok(())
    }
}

/// Writes a report in every requested format.
pub struct ReportWriter<'a> {
    /// Path of the YAML report.
    pub path: &'a Path,
    texts: SuiteTexts,
    args: &'a OutputArgs,
    known: Option<Baseline>,
}

impl<'a> ReportWriter<'a> {
    /// Creates a writer and reads the baseline, if one is given.
    pub fn new<C: Listed>(
        suite: &Suite<C>,
        path: &'a Path,
        args: &'a OutputArgs,
    ) -> Result<ReportWriter<'a>, String> {
        let texts = SuiteTexts::new(suite)?;
        let known = args.baseline.as_ref();
        let known = known.map(|path| Baseline::read(path, &texts)).transpose()?;
        Ok(ReportWriter {
            path,
            texts,
            args,
            known,
        })
    }

    /// Compares the report with the baseline, and writes the report atomically as YAML.
    pub fn write(&self, report: &mut Report) -> Result<(), String> {
        report.speak_of_functions();
        let known = self.known.as_ref();
        report.baseline = known.map(|known| known.compare(report));
        let text = match self.args.short {
            true => report.clone().without_passing_cases()?.to_yaml(),
            false => report.to_yaml(),
        };
        write_atomically(self.path, text?)
    }

    /// Writes and prints the report on a run in all requested formats. Returns the exit status.
    pub fn finish(
        &self,
        ending: Ending,
        mut report: Report,
        evidence: &Evidence,
        times: Option<&Times>,
    ) -> Result<u8, String> {
        self.write(&mut report)?;
        if let Some(why) = &ending.ended_early {
            print_error(&format!("ptm-conform: {why}"));
        }
        let text = text::report_to_text(&report, &self.texts, self.args.show);
        let text = report.in_words_for_decoder(&text);
        // A GitHub runner would interpret some output of a decoder as commands.
        print_styled(&match self.args.github {
            true => github::quote_commands(&text),
            false => text,
        });
        if let Some(times) = times {
            print(&slowest_to_text(times, self.args.durations));
        }
        print(&format!("report: {}\n", self.path.display()));
        if let Some(path) = &self.args.html {
            write_atomically(path, html::page(&self.texts, &report, evidence))?;
            print(&format!("page: {}\n", path.display()));
        }
        self.write_other_formats(&report, times)?;
        self.write_baseline(&report, ending.is_complete())?;
        let Some(comparison) = &report.baseline else {
            return Ok(ending.exit_status());
        };
        let ending = ending.with_failing_case(!comparison.new.is_empty());
        let status = match ending.exit_status() {
            0 if !comparison.stale.is_empty() => 4,
            status => status,
        };
        print_comparison(comparison, status);
        Ok(status)
    }

    /// Writes all formats except YAML, text and HTML.
    fn write_other_formats(&self, report: &Report, times: Option<&Times>) -> Result<(), String> {
        if let Some(path) = &self.args.junit {
            write_atomically(path, junit::junit(report, times))?;
        }
        if let Some(path) = &self.args.json {
            let json = serde_json::to_string(report).map_err(|error| error.to_string())?;
            write_atomically(path, json)?;
        }
        if self.args.github {
            print(&github::annotations(report));
            let summary = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty());
            if let Some(path) = summary.as_deref().map(Path::new) {
                // All steps of a job append to the same file.
                let file = fs::OpenOptions::new().append(true).create(true).open(path);
                let text = github::summary(report, self.texts.cases.len());
                file.and_then(|mut file| file.write_all(text.as_bytes()))
                    .map_err(with_path(path))?;
            }
        }
        Ok(())
    }

    fn write_baseline(&self, report: &Report, is_complete: bool) -> Result<(), String> {
        let Some(path) = &self.args.write_baseline else {
            return Ok(());
        };
        if !is_complete {
            let says = "ptm-conform: the run is incomplete, so";
            print_error(&format!("{says} {} is not written", path.display()));
            return Ok(());
        }
        let list = self.known.clone().unwrap_or_default();
        write_atomically(path, list.to_updated_yaml(&self.texts, report))?;
        print(&format!("known failures: {}\n", path.display()));
        Ok(())
    }
}

/// Lists the slowest cases.
fn slowest_to_text(times: &Times, count: usize) -> String {
    let row = |(id, time): (&str, Duration)| format!("  {:8.3} s  {id}\n", time.as_secs_f64());
    let rows: String = times.slowest(count).into_iter().map(row).collect();
    match rows.is_empty() {
        true => rows,
        false => format!("slowest cases, all requests for each:\n{rows}"),
    }
}

/// Lists the new failures and the listed cases that pass. The last line has the verdict.
fn print_comparison(comparison: &BaselineComparison, status: u8) {
    let list = |title: &str, ids: &[String]| match ids.len() {
        0 => String::new(),
        count => format!("{title}: {count}\n  {}\n", ids.join("\n  ")),
    };
    let new = list("new failures (not in the baseline)", &comparison.new);
    let stale = list("stale, listed but passing", &comparison.stale);
    let (verdict, advice) = match status {
        0 => ("ok", ""),
        4 => ("out of date", "; remove the listed cases that pass"),
        _ => ("fail", ""),
    };
    let (known, new_count) = (comparison.known.len(), comparison.new.len());
    print(&format!(
        "{new}{stale}{verdict}: {known} known failures, {new_count} new{advice}\n"
    ));
}
