//! Faults of written files.

use std::fmt;

/// Fault of a written file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WriterFault {
    /// Clause that the file violates.
    pub clause: String,
    /// Description of the difference.
    pub message: String,
    /// True if the reference refuses the file.
    pub is_refusal: bool,
}

impl WriterFault {
    pub(super) fn new(clause: &str, message: impl Into<String>) -> WriterFault {
        WriterFault {
            clause: clause.to_owned(),
            message: message.into(),
            is_refusal: false,
        }
    }
}

impl fmt::Display for WriterFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}
