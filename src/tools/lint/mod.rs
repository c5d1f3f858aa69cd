//! What is wrong with a file, what other readers may make of it, and what its writer can mend.
//!
//! Errors are the reference's own, sorted into stable [`codes`], and those of every plane where the planes are at fault;
//! warnings and infos come of the file's spelling, of its values, of its streams, and of reading it in every way that the
//! open points allow.

pub mod codes;

mod errors;

mod header;

mod values;

mod planes;

mod choices;

use std::fmt::Write as _;

use anstyle::{AnsiColor, Style};
use serde::Serialize;

use crate::tools::anatomy::Anatomy;
use codes::{Code, Severity};

/// One thing said of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Which thing.
    pub code: &'static Code,
    /// The byte at which it shows.
    pub offset: usize,
    /// The clause it is about: the code's, or the very one that is broken.
    pub clause: &'static str,
    /// What was found there, in words.
    pub what: String,
}

/// Everything said of a file.
#[derive(Clone, Debug, Serialize)]
pub struct Lint {
    /// The file's name, as it was given.
    pub file: String,
    /// How many errors there are.
    pub errors: usize,
    /// How many warnings.
    pub warnings: usize,
    /// What was found, errors first, then by place.
    pub findings: Vec<Told>,
}

/// A finding as it is written.
#[derive(Clone, Debug, Serialize)]
pub struct Told {
    /// `PTM-E001`
    pub code: &'static str,
    /// `error`, `warning` or `info`.
    pub severity: Severity,
    /// The byte at which it shows.
    pub offset: usize,
    /// The clause it is about.
    pub clause: &'static str,
    /// What is so.
    pub says: &'static str,
    /// What was found.
    pub found: String,
    /// What to do about it.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub mend: &'static str,
}

impl Finding {
    pub(crate) fn new(code: &'static Code, offset: usize, what: impl Into<String>) -> Finding {
        Finding {
            code,
            offset,
            clause: code.clause,
            what: what.into(),
        }
    }
}

/// Everything that can be said of `file`, errors first, then by place.
#[must_use]
pub fn lint(file: &[u8]) -> Vec<Finding> {
    let anatomy = Anatomy::of(file);
    let mut findings = errors::find(&anatomy);
    findings.extend(header::find(&anatomy));
    findings.extend(values::find(&anatomy));
    findings.extend(planes::find(&anatomy));
    findings.extend(choices::find(&anatomy));
    findings.sort_by_key(|finding| (finding.code.severity, finding.offset, finding.code.id));
    findings
}

impl Lint {
    /// The findings of a file, with its name.
    #[must_use]
    pub fn of(name: &str, file: &[u8]) -> Lint {
        let findings = lint(file);
        let count = |severity| {
            findings
                .iter()
                .filter(|finding| finding.code.severity == severity)
                .count()
        };
        Lint {
            file: name.to_owned(),
            errors: count(Severity::Error),
            warnings: count(Severity::Warning),
            findings: findings.into_iter().map(told).collect(),
        }
    }

    /// Without the findings of some codes.
    #[must_use]
    pub fn without(mut self, codes: &[String]) -> Lint {
        self.findings
            .retain(|finding| !codes.iter().any(|code| code == finding.code));
        let count = |severity| {
            self.findings
                .iter()
                .filter(|finding| finding.severity == severity)
                .count()
        };
        (self.errors, self.warnings) = (count(Severity::Error), count(Severity::Warning));
        self
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
            for (word, text) in [
                ("found", finding.found.as_str()),
                ("to mend it", finding.mend),
            ] {
                if !text.is_empty() {
                    let _ = writeln!(out, "    {word}: {text}");
                }
            }
        }
        out
    }

    /// How many errors, warnings and infos, in words.
    #[must_use]
    pub fn summary(&self) -> String {
        let infos = self.findings.len() - self.errors - self.warnings;
        let counted = |count: usize, word: &str| {
            format!("{count} {word}{}", if count == 1 { "" } else { "s" })
        };
        format!(
            "{}: {}, {}, {}\n",
            self.file,
            counted(self.errors, "error"),
            counted(self.warnings, "warning"),
            counted(infos, "info")
        )
    }
}

fn told(finding: Finding) -> Told {
    Told {
        code: finding.code.id,
        severity: finding.code.severity,
        offset: finding.offset,
        clause: finding.clause,
        says: finding.code.says,
        found: finding.what,
        mend: finding.code.mend,
    }
}
