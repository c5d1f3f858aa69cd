//! Lint findings for a file.

use serde::Serialize;

use super::codes::{Code, Problem, Severity};
use crate::dissection::{Dissection, Role};

/// Finding about a file, in the form that is written to YAML and JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Id of the [`Code`], such as `PTM-E001`.
    pub code: &'static str,
    /// Severity of the finding.
    pub severity: Severity,
    /// Offset in the file.
    pub offset: usize,
    /// Violated clause, or else the clause that the code is about.
    pub clause: &'static str,
    /// Description of the code, which is the same for every file.
    #[serde(rename = "says")]
    pub message: &'static str,
    /// Details that are specific to this file.
    pub found: String,
    /// Suggested fix for a writer; empty if there is nothing to do.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub fix: &'static str,
}

impl Diagnostic {
    /// Returns the place of the finding in a report: the most severe ones first, then in file order.
    pub(super) fn rank(&self) -> (Severity, usize, &'static str) {
        (self.severity, self.offset, self.code)
    }

    /// Returns the description of the code, followed by the details for this file.
    #[must_use]
    pub fn text(&self) -> String {
        match self.found.as_str() {
            "" => self.message.to_owned(),
            found => format!("{}: {found}", self.message),
        }
    }
}

pub(super) struct Findings<'a> {
    pub dissection: &'a Dissection<'a>,
    pub list: Vec<Diagnostic>,
}

impl<'a> Findings<'a> {
    pub fn new(dissection: &'a Dissection<'a>) -> Findings<'a> {
        let list = Vec::new();
        Findings { dissection, list }
    }

    /// Adds a problem at the first part with the given role.
    pub fn add(&mut self, problem: Problem, role: Role, found: impl Into<String>) {
        self.add_at(problem, self.dissection.start(role), found);
    }

    /// Adds a problem at a byte offset.
    pub fn add_at(&mut self, problem: Problem, offset: usize, found: impl Into<String>) {
        self.add_code(problem.code(), offset, found.into());
    }

    pub fn add_code(&mut self, code: &'static Code, offset: usize, found: String) {
        self.list.push(Diagnostic {
            code: code.id,
            severity: code.severity,
            offset,
            clause: code.clause,
            message: code.message,
            found,
            fix: code.fix,
        });
    }
}
