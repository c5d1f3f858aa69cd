//! Settings that select findings: codes to ignore, codes to report exclusively, severities, and a maximum number.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::Lint;
use super::codes::{Code, Severity};
use super::diagnostic::Diagnostic;
use crate::error::{Error, Result};

/// Selection of findings, from options and configuration files.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Codes that are not reported.
    pub allow: Vec<String>,
    /// The only codes that are reported; empty to report all codes.
    pub only: Vec<String>,
    /// Severities that replace the defaults of the codes.
    pub severity: BTreeMap<String, Severity>,
    /// Maximum number of findings that are printed per file, worst first. All findings are counted.
    pub max: Option<usize>,
    /// True if a warning makes the run fail.
    pub deny_warnings: bool,
}

impl Settings {
    /// Merges two sets of settings. Lists are combined, and single values in `other` take precedence.
    #[must_use]
    pub fn merge(mut self, other: Settings) -> Settings {
        self.allow.extend(other.allow);
        self.only.extend(other.only);
        self.severity.extend(other.severity);
        Settings {
            max: other.max.or(self.max),
            deny_warnings: self.deny_warnings || other.deny_warnings,
            ..self
        }
    }

    /// Checks that every code exists.
    ///
    /// # Errors
    /// Returns a message that names the first unknown code.
    pub fn check(&self) -> Result<()> {
        let codes = self.allow.iter().chain(&self.only);
        let mut codes = codes.chain(self.severity.keys());
        let unknown = codes.find(|code| Code::find(code).is_none());
        let hint = "`ptm-conform lint --codes` lists all codes";
        unknown.map_or(Ok(()), |code| {
            Error::impossible(format!("unknown code {code:?}; {hint}"))
        })
    }

    /// Removes findings that should not be reported and applies the severities.
    #[must_use]
    pub fn apply(&self, mut lint: Lint) -> Lint {
        let errors = lint.errors;
        let contains = |codes: &[String], code: &str| codes.iter().any(|other| other == code);
        lint.findings.retain(|finding| {
            !contains(&self.allow, finding.code)
                && (self.only.is_empty() || contains(&self.only, finding.code))
        });
        let is_error = |finding: &&Diagnostic| finding.severity == Severity::Error;
        lint.hidden_errors = errors - lint.findings.iter().filter(is_error).count();
        for finding in &mut lint.findings {
            if let Some(&severity) = self.severity.get(finding.code) {
                finding.severity = severity;
            }
        }
        lint.sort_and_count();
        lint
    }
}
