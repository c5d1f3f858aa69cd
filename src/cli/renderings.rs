//! `check --html FILE --junit FILE --github`: the report in other forms, for people and for other programs.

use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::files::{can_be_written, write_whole};
use super::known_failures::KnownFailureArgs;
use super::output::print;
use ptm_conform::report::Report;
use ptm_conform::report::github;
use ptm_conform::report::html;
use ptm_conform::report::junit;
use ptm_conform::report::reported::Reported;
use ptm_conform::session::run::Run;
use ptm_conform::suite::cases::Suite;

/// Other forms of the report.
#[derive(Args)]
pub struct RenderingArgs {
    /// Also write the report as a page with pictures of every failure, for a browser; it needs no network.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Also write the report as `JUnit` XML.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write the report as JSON, too.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Print GitHub annotations, and append the job's summary to the file named by `GITHUB_STEP_SUMMARY`.
    #[arg(long)]
    github: bool,
}

impl RenderingArgs {
    /// Refuses before long work a file that cannot be written, or would be written twice.
    pub fn check_outputs(&self, report: &Path, known: &KnownFailureArgs) -> Result<(), String> {
        let renderings = [&self.html, &self.junit, &self.json].into_iter().flatten();
        let others = renderings.map(PathBuf::as_path).chain(known.written());
        let outputs: Vec<&Path> = std::iter::once(report).chain(others).collect();
        for (i, path) in outputs.iter().enumerate() {
            can_be_written(path)?;
            if outputs[..i].contains(path) {
                return Err(format!("{} is to be written twice", path.display()));
            }
        }
        Ok(())
    }

    /// Whether there is to be a page with pictures.
    pub fn has_page(&self) -> bool {
        self.html.is_some()
    }

    /// What may be printed of a decoder's own words: on GitHub, nothing that its runner takes for a command.
    pub fn printable(&self, text: String) -> String {
        if self.github {
            github::without_commands(&text)
        } else {
            text
        }
    }

    /// Writes those that are asked for.
    pub fn write<C: Reported>(
        &self,
        suite: &Suite<C>,
        report: &Report,
        run: &Run<C>,
    ) -> Result<(), String> {
        if let Some(path) = &self.html {
            write_whole(path, html::page(suite, report, Some(run))?)?;
            print(&format!("page: {}\n", path.display()));
        }
        if let Some(path) = &self.junit {
            write_whole(path, junit::junit(report)?)?;
        }
        if let Some(path) = &self.json {
            let json = serde_json::to_string(report).map_err(|error| error.to_string())?;
            write_whole(path, json)?;
        }
        if self.github {
            print(&github::annotations(report));
            let summary = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty());
            if let Some(path) = summary {
                append(&path, &github::summary(report, suite.cases.len()))?;
            }
        }
        Ok(())
    }
}

/// The steps of a job append to one file.
fn append(path: &OsStr, text: &str) -> Result<(), String> {
    let file = fs::OpenOptions::new().append(true).create(true).open(path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| format!("{}: {error}", Path::new(path).display()))
}
