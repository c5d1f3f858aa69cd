//! Lint findings for a file.

use serde::Serialize;

use super::codes::{Problem, Severity};
use crate::tools::dissection::{Dissection, Role};

/// One finding about a file, as it is written to YAML and JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// The id of its [`Code`](super::codes::Code), such as `PTM-E001`.
    pub code: &'static str,
    /// Its severity.
    pub severity: Severity,
    /// The byte of the file at which it was found.
    pub offset: usize,
    /// The clause that it is about: that of the code, or the exact one that is broken.
    pub clause: &'static str,
    /// The code's sentence: the same text for every file.
    pub says: &'static str,
    /// Details of this file.
    pub found: String,
    /// The suggested fix for a writer; empty if there is nothing to do.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub fix: &'static str,
}

impl Diagnostic {
    /// Returns the sentence of its code, with the details of this file.
    #[must_use]
    pub fn text(&self) -> String {
        match self.found.as_str() {
            "" => self.says.to_owned(),
            found => format!("{}: {found}", self.says),
        }
    }
}

/// The findings about a file, as they are collected.
pub(super) struct Findings<'a> {
    pub dissection: &'a Dissection<'a>,
    pub list: Vec<Diagnostic>,
}

impl<'a> Findings<'a> {
    pub fn new(dissection: &'a Dissection<'a>) -> Findings<'a> {
        let list = Vec::new();
        Findings { dissection, list }
    }

    /// Adds a problem at the first part of a role.
    pub fn add(&mut self, problem: Problem, role: Role, found: impl Into<String>) {
        self.add_at(problem, self.dissection.start(role), found);
    }

    /// Adds a problem at a byte.
    pub fn add_at(&mut self, problem: Problem, offset: usize, found: impl Into<String>) {
        let code = problem.code();
        self.list.push(Diagnostic {
            code: code.id,
            severity: code.severity,
            offset,
            clause: code.clause,
            says: code.says,
            found: found.into(),
            fix: code.fix,
        });
    }
}
