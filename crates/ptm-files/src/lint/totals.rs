//! Totals of a collection: number of files by status, format and code.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::{Lint, codes::Code, status::Status};
use crate::readers::Rendering;

/// Counts of all files in a run.
#[derive(Clone, Debug, Default)]
pub struct Totals {
    /// Number of files.
    pub files: usize,
    statuses: BTreeMap<Status, usize>,
    formats: BTreeMap<String, usize>,
    /// Number of files with each lint code.
    codes: BTreeMap<String, usize>,
    /// Number of files with each predicted result of each reader, in the order of the readers.
    predictions: Vec<(String, BTreeMap<Rendering, usize>)>,
    /// Number of files in folders that are neither named `.ptm` nor begin like a PTM.
    pub others: usize,
}

impl Totals {
    /// Counts a file.
    pub fn add(&mut self, lint: &Lint) {
        let codes = lint.findings.iter().map(|finding| finding.code);
        self.add_row(lint.status, lint.format.unwrap_or_default(), codes);
        for prediction in &lint.readers {
            let place = self
                .predictions
                .iter()
                .position(|(reader, _)| *reader == prediction.reader);
            let place = place.unwrap_or_else(|| {
                let reader = prediction.reader.clone();
                self.predictions.push((reader, BTreeMap::new()));
                self.predictions.len() - 1
            });
            let counts = &mut self.predictions[place].1;
            *counts.entry(prediction.result).or_default() += 1;
        }
    }

    /// Counts a file with this status, format (empty if unknown) and these lint codes.
    pub fn add_row<'a>(
        &mut self,
        status: Status,
        format: &str,
        codes: impl Iterator<Item = &'a str>,
    ) {
        self.files += 1;
        *self.statuses.entry(status).or_default() += 1;
        if !format.is_empty() {
            *self.formats.entry(format.to_owned()).or_default() += 1;
        }
        for code in codes.collect::<BTreeSet<&str>>() {
            *self.codes.entry(code.to_owned()).or_default() += 1;
        }
    }

    /// Returns the number of files with the given status.
    #[must_use]
    pub fn count(&self, status: Status) -> usize {
        self.statuses.get(&status).copied().unwrap_or_default()
    }

    /// Returns the number of files in each format.
    pub fn formats(&self) -> impl Iterator<Item = (&str, usize)> {
        self.formats
            .iter()
            .map(|(format, &count)| (format.as_str(), count))
    }

    /// Formats the totals for a terminal: one line for all files, then one line per format and per code.
    #[must_use]
    pub fn to_text(&self) -> String {
        let statuses =
            Status::ALL.map(|status| format!("{} {}", self.count(status), status.label()));
        let mut out = format!("{} files: {}\n", self.files, statuses.join(", "));
        if self.others > 0 {
            let others = self.others;
            let _ = writeln!(
                out,
                "not checked: {others} in folders, neither named .ptm nor beginning with PTM_"
            );
        }
        let width = self.files.to_string().len();
        for (format, count) in &self.formats {
            let _ = writeln!(out, "  {count:width$}  {format}");
        }
        for (id, count) in &self.codes {
            let says = Code::find(id).map_or("", |code| code.message);
            let _ = writeln!(out, "  {count:width$}  {id}  {says}");
        }
        for (reader, counts) in &self.predictions {
            let counts = counts.iter();
            let counts = counts.map(|(result, count)| format!("{count} {}", result.label()));
            let _ = writeln!(
                out,
                "  in {reader}: {}",
                counts.collect::<Vec<_>>().join(", ")
            );
        }
        out
    }
}
