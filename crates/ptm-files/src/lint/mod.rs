//! Lint for PTM files: reports errors, problems that some readers may have with a file, and suggested fixes for the program that
//! wrote the file.
//!
//! Errors reported by the reference are mapped to stable [`codes`]. If a compressed plane is malformed, the errors of all planes are
//! reported. Warnings and informational findings concern the spelling, the values and the streams of a file, and alternative
//! readings of open questions.

mod choices;
pub mod codes;
pub mod csv;
pub(crate) mod damage;
pub mod diagnostic;
pub(crate) mod errors;
mod fits;
mod foreign;
mod header;
mod lights;
pub mod metadata;
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
use self::metadata::Metadata;
use self::status::Status;
use crate::dissection::Dissection;
use crate::readers::ReaderPrediction;
use crate::repair::repair;
use ptm::Format;
use ptm::decode::Streams;

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
    /// SHA-256 digest of the file in hexadecimal, if the whole file was read and the digest was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// Time of the last change to the file, in UTC (RFC 3339), if it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modified: Option<String>,
    /// Facts from the header.
    #[serde(flatten)]
    pub metadata: Metadata,
    /// For a damaged file: `yes` if `convert --repair` repairs it, or the reason why it does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repairable: Option<String>,
    /// Number of errors.
    pub errors: usize,
    /// Number of warnings.
    pub warnings: usize,
    /// Number of informational findings.
    pub infos: usize,
    /// Number of errors that the settings hide. A damaged file stays damaged.
    #[serde(skip_serializing_if = "is_zero")]
    pub hidden_errors: usize,
    /// Predicted results of readers, if requested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readers: Vec<ReaderPrediction>,
    /// Findings, sorted by severity and offset.
    pub findings: Vec<Diagnostic>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// Returns all findings about `file`, sorted by severity and offset.
#[must_use]
pub fn lint(file: &[u8]) -> Vec<Diagnostic> {
    let (dissection, streams) = Dissection::with_streams(file);
    let mut findings = find(&dissection, streams.as_ref());
    findings.sort_by_key(Diagnostic::rank);
    findings
}

/// Returns all findings about a dissected file. `streams` are its decoded streams, if all of them can be decoded.
fn find(dissection: &Dissection, streams: Option<&Streams>) -> Vec<Diagnostic> {
    let mut findings = Findings::new(dissection);
    errors::diagnose(&mut findings);
    header::diagnose(&mut findings);
    values::diagnose(&mut findings);
    planes::diagnose(&mut findings, streams);
    choices::diagnose(&mut findings, streams);
    damage::diagnose(&mut findings);
    lights::diagnose(&mut findings);
    findings.list
}

/// Returns the reason why a file was not judged.
fn not_judged_reason(error: &Diagnostic) -> String {
    match error.found.as_str() {
        "" => error.message.to_owned(),
        found => format!("{}; {found}", error.message),
    }
}

impl Lint {
    /// Lints the file with the given name and content.
    #[must_use]
    pub fn new(name: &str, file: &[u8]) -> Lint {
        let (dissection, streams) = Dissection::with_streams(file);
        let mut findings = find(&dissection, streams.as_ref());
        let is_error = |finding: &Diagnostic| finding.severity == Severity::Error;
        let status = match Status::new(name, &dissection) {
            // The decoder does not notice every damage.
            Status::Sound if findings.iter().any(is_error) => Status::Damaged,
            status => status,
        };
        let mut reason = None;
        let error = findings.iter().find(|finding| is_error(finding));
        match status {
            // A file of another version or beyond a limit of the reference breaks no rule.
            Status::NotJudged => reason = error.map(not_judged_reason),
            Status::Foreign => {
                reason = foreign::kind(file).or_else(|| error.map(|error| error.found.clone()));
            }
            _ => {}
        }
        if reason.is_some() {
            findings.retain(|finding| !is_error(finding));
        }
        let mut lint = Lint {
            status,
            reason,
            metadata: match status {
                Status::Foreign => Metadata::default(),
                _ => Metadata::new(&dissection),
            },
            format: dissection.format.map(Format::name),
            width: dissection.size.map(|size| size.width),
            height: dissection.size.map(|size| size.height),
            bytes: Some(file.len() as u64),
            findings,
            file: name.to_owned(),
            ..Lint::default()
        };
        if status == Status::Damaged {
            lint.repairable = Some(match repair(file) {
                Ok(_) => "yes".to_owned(),
                Err(why) => format!("no: {why}"),
            });
        }
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
        self.findings.sort_by_key(Diagnostic::rank);
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
        let mut details = self.reason.clone().unwrap_or_else(|| counts.join(", "));
        if self.hidden_errors > 0 {
            let _ = write!(
                details,
                " ({} not shown)",
                count(self.hidden_errors, "error")
            );
        }
        if self.repairable.as_deref() == Some("yes") {
            details += "; repairable with `ptm-conform convert --repair`";
        }
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
