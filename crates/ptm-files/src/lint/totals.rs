//! Totals of a collection: number of files by status, format and code.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::{Lint, codes::Code, status::Status};

/// Counts of all files in a run.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Number of files.
    pub files: usize,
    statuses: BTreeMap<Status, usize>,
    formats: BTreeMap<&'static str, usize>,
    /// Number of files with each lint code.
    codes: BTreeMap<&'static str, usize>,
}

impl Totals {
    /// Counts a file.
    pub fn add(&mut self, lint: &Lint) {
        self.files += 1;
        *self.statuses.entry(lint.status).or_default() += 1;
        if let Some(format) = lint.format {
            *self.formats.entry(format).or_default() += 1;
        }
        let codes = lint.findings.iter().map(|finding| finding.code);
        for code in codes.collect::<BTreeSet<&str>>() {
            *self.codes.entry(code).or_default() += 1;
        }
    }

    /// Returns the number of files with the given status.
    #[must_use]
    pub fn count(&self, status: Status) -> usize {
        self.statuses.get(&status).copied().unwrap_or_default()
    }

    /// Formats the totals for a terminal: one line for all files, then one line per format and per code.
    #[must_use]
    pub fn to_text(&self) -> String {
        let statuses =
            Status::ALL.map(|status| format!("{} {}", self.count(status), status.label()));
        let mut out = format!("{} files: {}\n", self.files, statuses.join(", "));
        let width = self.files.to_string().len();
        for (format, count) in &self.formats {
            let _ = writeln!(out, "  {count:width$}  {format}");
        }
        for (id, count) in &self.codes {
            let says = Code::find(id).map_or("", |code| code.message);
            let _ = writeln!(out, "  {count:width$}  {id}  {says}");
        }
        out
    }
}
