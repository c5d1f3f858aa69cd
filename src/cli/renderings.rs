//! `check --html FILE --junit FILE --github`: the report in other forms, for people and for other programs.

use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

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
    /// The files that are asked for.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.html
            .iter()
            .chain(&self.junit)
            .chain(&self.json)
            .map(PathBuf::as_path)
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
            super::files::write_whole(path, &html::page(suite, report, Some(run))?)?;
            super::output::print(&format!("page: {}\n", path.display()));
        }
        if let Some(path) = &self.junit {
            super::files::write_whole(path, &junit::junit(report)?)?;
        }
        if let Some(path) = &self.json {
            super::files::write_whole(
                path,
                serde_json::to_string(report).map_err(|error| error.to_string())?,
            )?;
        }
        if self.github {
            super::output::print(&github::annotations(report));
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
