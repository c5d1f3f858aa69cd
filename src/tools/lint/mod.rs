//! What is wrong with a file, what other readers may make of it, and what its writer can fix.
//!
//! Errors are the reference's own, sorted into stable [`codes`], and those of every plane where the planes are at fault;
//! warnings and infos come from the file's spelling, from its values, from its streams, and from reading it in every way that
//! the open points allow.

pub mod codes;

pub mod diagnostic;

pub mod status;

pub mod names;

pub mod settings;

pub mod totals;

pub mod csv;

pub mod sarif;

mod errors;

mod header;

mod values;

mod planes;

mod choices;

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use self::codes::Severity;
use self::diagnostic::{Diagnostic, Findings};
use self::status::Status;
use crate::ptm::Format;
use crate::readers::ReaderPrediction;
use crate::tools::dissection::Dissection;

/// Everything said of a file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Lint {
    /// The file's name, as it was given, with what a terminal would obey as escapes.
    pub file: String,
    /// What it is.
    pub status: Status,
    /// Its format, if that was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<&'static str>,
    /// Texels of a row, if that was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Rows, if that was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// How many bytes it has, where that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Why it was not read, if it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// How many errors there are.
    pub errors: usize,
    /// How many warnings.
    pub warnings: usize,
    /// How many findings for information.
    pub infos: usize,
    /// What readers will show, where that was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readers: Vec<ReaderPrediction>,
    /// What was found, errors first, then by place.
    pub findings: Vec<Diagnostic>,
}

/// Everything that can be said of `file`, errors first, then by place.
#[must_use]
pub fn lint(file: &[u8]) -> Vec<Diagnostic> {
    Lint::of("", file).findings
}

impl Lint {
    /// Returns the findings of a file, with its name.
    #[must_use]
    pub fn of(name: &str, file: &[u8]) -> Lint {
        let (dissection, streams) = Dissection::with_streams(file);
        let mut findings = Findings::new(&dissection);
        errors::diagnose(&mut findings);
        header::diagnose(&mut findings);
        values::diagnose(&mut findings);
        planes::diagnose(&mut findings, streams.as_ref());
        choices::diagnose(&mut findings, streams.as_ref());
        let mut lint = Lint {
            status: Status::of(&dissection),
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

    /// What is said of a file of which only the beginning was read, because it is none of a PTM.
    #[must_use]
    pub fn of_other(name: &str, beginning: &[u8], bytes: u64) -> Lint {
        Lint {
            bytes: Some(bytes),
            ..Lint::of(name, beginning)
        }
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

    /// As lines for a terminal, with its colors; those from `least` on.
    #[must_use]
    pub fn to_text(&self, least: Severity) -> String {
        let mut out = String::new();
        for finding in self
            .findings
            .iter()
            .filter(|finding| finding.severity <= least)
        {
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

    /// What it is, and how many errors, warnings and infos there are, in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let counted = |count: usize, word: &str| {
            format!("{count} {word}{}", if count == 1 { "" } else { "s" })
        };
        let counts = || {
            let counts = [
                counted(self.errors, "error"),
                counted(self.warnings, "warning"),
                counted(self.infos, "info"),
            ];
            counts.join(", ")
        };
        let said = self.reason.clone().unwrap_or_else(counts);
        format!("{}: {}: {said}\n", self.file, self.status.words())
    }

    /// What readers will show, a line each.
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
