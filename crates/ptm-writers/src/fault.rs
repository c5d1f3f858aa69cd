//! Faults of written files.

use std::fmt;

/// Fault of a written file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WriterFault {
    /// Clause that the file violates.
    pub clause: String,
    /// Description of the difference.
    pub message: String,
    /// What is wrong with the file.
    pub kind: FaultKind,
    /// Suggested fix; empty if the kind and the clause suggest one.
    pub fix: &'static str,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FaultKind {
    /// The reference refuses the file.
    Refused,
    /// The file has the requested values, but `lint` finds an error.
    LintError,
    /// The file has other values than requested.
    Different,
}

impl WriterFault {
    pub(super) fn new(clause: &str, message: impl Into<String>) -> WriterFault {
        WriterFault {
            clause: clause.to_owned(),
            message: message.into(),
            kind: FaultKind::Different,
            fix: "",
        }
    }
}

impl fmt::Display for WriterFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}
