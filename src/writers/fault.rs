//! The fault of a written file.

use std::fmt;

/// The fault of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WriterFault {
    /// The clause that it is about.
    pub clause: String,
    /// The difference, in words.
    pub says: String,
}

impl WriterFault {
    pub(super) fn new(clause: &str, says: impl Into<String>) -> WriterFault {
        WriterFault {
            clause: clause.to_owned(),
            says: says.into(),
        }
    }
}

impl fmt::Display for WriterFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.says)
    }
}
