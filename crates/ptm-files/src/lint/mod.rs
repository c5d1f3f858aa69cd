//! Lint for PTM files: reports errors, problems that some readers may have with a file, and suggested fixes for the program that
//! wrote the file.
//!
//! Errors reported by the reference are mapped to stable [`codes`]. If a compressed plane is malformed, the errors of all planes are
//! reported. Warnings and informational findings concern the spelling, the values and the streams of a file, and alternative
//! readings of open questions.

mod choices;
pub mod codes;
pub mod csv;
mod damage;
pub mod diagnostic;
mod errors;
mod fits;
mod header;
mod lights;
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
use crate::dissection::Dissection;
use crate::readers::ReaderPrediction;
use ptm::Format;

/// Lint results for a file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Lint {
    /// Name of the file as given, with control characters escaped.
    pub file: String,
    /// Status of the file.
    pub status: Status,
    /// Format of the file, if it could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub format: Option<&'static str>,
    /// Number of texels per row, if the size could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Number of rows, if the size could be read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// Size of the file in bytes, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u64>,
    /// Reason why the file was not read; `None` if it was read or if no reason is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Number of errors.
    pub errors: usize,
    /// Number of warnings.
    pub warnings: usize,
    /// Number of informational findings.
    pub infos: usize,
    /// Predicted results of readers, if requested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readers: Vec<ReaderPrediction>,
    /// Findings, sorted by severity and offset.
    pub findings: Vec<Diagnostic>,
}

/// Returns all findings about `file`, sorted by severity and offset.
#[must_use]
pub fn lint(file: &[u8]) -> Vec<Diagnostic> {
    Lint::new("", file).findings
}

impl Lint {
    /// Lints the file with the given name and content.
    #[must_use]
    pub fn new(name: &str, file: &[u8]) -> Lint {
        let (dissection, streams) = Dissection::with_streams(file);
        let mut findings = Findings::new(&dissection);
        errors::diagnose(&mut findings);
        header::diagnose(&mut findings);
        values::diagnose(&mut findings);
        planes::diagnose(&mut findings, streams.as_ref());
        choices::diagnose(&mut findings, streams.as_ref());
        damage::diagnose(&mut findings);
        lights::diagnose(&mut findings);
        let mut errors = findings.list.iter();
        let has_error = errors.any(|finding| finding.severity == Severity::Error);
        let status = match Status::new(&dissection) {
            // The decoder does not notice every damage.
            Status::Sound if has_error => Status::Damaged,
            status => status,
        };
        let mut lint = Lint {
            status,
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

    /// Creates the result for a file that was not read, with the reason.
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
            .sort_by_key(|finding| (finding.severity, finding.offset, finding.code));
        let count = |severity| {
            let findings = self.findings.iter();
            findings.filter(|f| f.severity == severity).count()
        };
        self.errors = count(Severity::Error);
        self.warnings = count(Severity::Warning);
        self.infos = count(Severity::Info);
    }

    /// Formats the findings of severity `minimum` and above as colored text for a terminal.
    #[must_use]
    pub fn to_text(&self, minimum: Severity) -> String {
        let mut out = String::new();
        let is_shown = |finding: &&Diagnostic| finding.severity <= minimum;
        for finding in self.findings.iter().filter(is_shown) {
            let style = match finding.severity {
                Severity::Error => AnsiColor::Red.on_default().bold(),
                Severity::Warning => AnsiColor::Yellow.on_default().bold(),
                Severity::Info => Style::new().bold(),
            };
            let position = format!("{}: byte {}", self.file, finding.offset);
            let code = format!("{} {}", finding.severity.name(), finding.code);
            let says = format!("({}): {}", finding.clause, finding.message);
            let _ = writeln!(out, "{position}: {style}{code}{style:#} {says}");
            for (label, text) in [("found", finding.found.as_str()), ("fix", finding.fix)] {
                if !text.is_empty() {
                    let _ = writeln!(out, "    {label}: {text}");
                }
            }
        }
        out
    }

    /// Describes the status and counts the errors, warnings and infos.
    #[must_use]
    pub fn summary(&self) -> String {
        let count = |count: usize, noun: &str| {
            format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
        };
        let counts = [
            count(self.errors, "error"),
            count(self.warnings, "warning"),
            count(self.infos, "info"),
        ];
        let details = self.reason.clone().unwrap_or_else(|| counts.join(", "));
        format!("{}: {}: {details}\n", self.file, self.status.label())
    }

    /// Formats the predicted results of readers, one per line.
    #[must_use]
    pub fn predictions_text(&self) -> String {
        let mut out = String::new();
        for reader in &self.readers {
            let _ = write!(out, "    in {}: {}", reader.reader, reader.result.label());
            if let (Some(largest), Some(share)) = (reader.largest_difference, reader.visible_share)
                && share > 0.0
            {
                let percent = 100.0 * share;
                let _ = write!(
                    out,
                    ", up to {largest} of 255 in {percent:.1} % of the texels"
                );
            }
            if let Some(evidence) = reader.evidence {
                let _ = write!(out, " ({})", evidence.label());
            }
            let details = [("", Some(&reader.fault)), ("fix: ", reader.fix.as_ref())];
            for (label, text) in details {
                if let Some(text) = text.filter(|text| !text.is_empty()) {
                    // A missing fix needs no label.
                    let label = if text.starts_with("no fix") {
                        ""
                    } else {
                        label
                    };
                    let _ = write!(out, "; {label}{text}");
                }
            }
            out.push('\n');
        }
        out
    }
}
