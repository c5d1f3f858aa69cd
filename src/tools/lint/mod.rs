//! Errors of a file, problems that other readers may have with it, and fixes for its writer.
//!
//! Errors are those of the reference, classified into stable [`codes`], and those of every plane if a plane is wrong. Warnings
//! and infos come from the file's spelling, its values, its streams, and from all readings of the open points.

mod choices;
pub mod codes;
pub mod csv;
pub mod diagnostic;
mod errors;
mod header;
pub mod names;
mod planes;
pub mod sarif;
pub mod settings;
pub mod status;
pub mod totals;
mod values;

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use self::codes::Severity;
use self::diagnostic::{Diagnostic, Findings};
use self::status::Status;
use crate::ptm::Format;
use crate::readers::ReaderPrediction;
use crate::tools::dissection::Dissection;

/// All findings about a file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Lint {
    /// The file's name, as it was given, with terminal control characters escaped.
    pub file: String,
    /// Its status.
    pub status: Status,
    /// Its format, if it could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<&'static str>,
    /// Number of texels in a row, if it could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Number of rows, if it could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// Number of its bytes, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// The reason why it was not read, if it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Number of errors.
    pub errors: usize,
    /// Number of warnings.
    pub warnings: usize,
    /// Number of findings for information.
    pub infos: usize,
    /// Predicted results of readers, if requested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readers: Vec<ReaderPrediction>,
    /// The findings, errors first, then by position.
    pub findings: Vec<Diagnostic>,
}

/// Returns all findings about `file`, errors first, then by position.
#[must_use]
pub fn lint(file: &[u8]) -> Vec<Diagnostic> {
    Lint::new("", file).findings
}

impl Lint {
    /// Returns the findings of a file, with its name.
    #[must_use]
    pub fn new(name: &str, file: &[u8]) -> Lint {
        let (dissection, streams) = Dissection::with_streams(file);
        let mut findings = Findings::new(&dissection);
        errors::diagnose(&mut findings);
        header::diagnose(&mut findings);
        values::diagnose(&mut findings);
        planes::diagnose(&mut findings, streams.as_ref());
        choices::diagnose(&mut findings, streams.as_ref());
        let mut lint = Lint {
            status: Status::new(&dissection),
            format: dissection.format.map(Format::name),
            width: dissection.size.map(|size| size.width),
            height: dissection.size.map(|size| size.height),
            bytes: Some(file.len() as u64),
            findings: findings.list,
            ..Lint::unread(name, None, None)
        };
        lint.sort_and_count();
        lint
    }

    /// Returns the result for a file that was not read, with the reason.
    #[must_use]
    pub fn unread(name: &str, bytes: Option<u64>, reason: Option<String>) -> Lint {
        Lint {
            file: name.to_owned(),
            bytes,
            reason,
            ..Lint::default()
        }
    }

    fn sort_and_count(&mut self) {
        self.findings
            .sort_by_key(|one| (one.severity, one.offset, one.code));
        let count = |severity| {
            let of_it = self.findings.iter();
            of_it.filter(|one| one.severity == severity).count()
        };
        self.errors = count(Severity::Error);
        self.warnings = count(Severity::Warning);
        self.infos = count(Severity::Info);
    }

    /// Returns lines for a terminal, in color, for findings of severity `least` and above.
    #[must_use]
    pub fn to_text(&self, least: Severity) -> String {
        let mut out = String::new();
        let shown = |finding: &&Diagnostic| finding.severity <= least;
        for finding in self.findings.iter().filter(shown) {
            let style = match finding.severity {
                Severity::Error => AnsiColor::Red.on_default().bold(),
                Severity::Warning => AnsiColor::Yellow.on_default().bold(),
                Severity::Info => Style::new().bold(),
            };
            let _ = writeln!(
                out,
                "{}: byte {}: {style}{} {}{style:#} ({}): {}",
                self.file,
                finding.offset,
                finding.severity.name(),
                finding.code,
                finding.clause,
                finding.says
            );
            for (word, text) in [("found", finding.found.as_str()), ("fix", finding.fix)] {
                if !text.is_empty() {
                    let _ = writeln!(out, "    {word}: {text}");
                }
            }
        }
        out
    }

    /// Describes its status, and the numbers of errors, warnings and infos.
    #[must_use]
    pub fn summary(&self) -> String {
        let counted = |count: usize, word: &str| {
            format!("{count} {word}{}", if count == 1 { "" } else { "s" })
        };
        let counts = [
            counted(self.errors, "error"),
            counted(self.warnings, "warning"),
            counted(self.infos, "info"),
        ];
        let said = self.reason.clone().unwrap_or_else(|| counts.join(", "));
        format!("{}: {}: {said}\n", self.file, self.status.words())
    }

    /// Returns the predicted results of readers, a line each.
    #[must_use]
    pub fn shown(&self) -> String {
        let mut out = String::new();
        for reader in &self.readers {
            let _ = write!(out, "    in {}: {}", reader.reader, reader.shows.name());
            let more = [("", Some(&reader.how)), ("fix: ", reader.fix.as_ref())];
            for (word, text) in more {
                if let Some(text) = text.filter(|text| !text.is_empty()) {
                    let _ = write!(out, "; {word}{text}");
                }
            }
            out.push('\n');
        }
        out
    }
}
