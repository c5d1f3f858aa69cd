//! Output of `lint` in every format: a row for each file, in order, and the totals at the end.

use std::io::{self, Write};
use std::path::Path;

use clap::ValueEnum;
use ptm_files::lint::{Lint, csv, sarif};
use ptm_files::lint::{codes::Severity, status::Status, totals::Totals};
use ptm_files::readers::ReaderProfile;
use ptm_suite::kit::yaml::to_yaml;

use super::{links::add_links, output};

/// Output format of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RowFormat {
    /// Text for human readers
    Text,
    /// A list with a record for each file
    Json,
    /// A list in YAML
    Yaml,
    /// A row for each file
    Csv,
    /// SARIF 2.1.0, for code hosts and editors
    Sarif,
}

/// Printer of rows. If the run is killed, the output contains only complete rows.
pub struct Rows {
    format: RowFormat,
    /// Maximum number of findings that are printed per file.
    max_findings: usize,
    /// Number of readers whose results are predicted.
    reader_count: usize,
    /// True if an item of a JSON or SARIF list has been printed.
    has_output: bool,
    /// Counts of all findings, including those that are not printed.
    totals: Totals,
}

impl Rows {
    /// Creates a printer and prints the beginning of the document.
    pub fn new(
        format: RowFormat,
        readers: &[&ReaderProfile],
        max_findings: Option<usize>,
    ) -> io::Result<Rows> {
        match format {
            RowFormat::Text | RowFormat::Yaml => {}
            RowFormat::Json => emit("[\n")?,
            RowFormat::Csv => emit(&csv::head(readers.iter().map(|reader| &*reader.name)))?,
            RowFormat::Sarif => emit(&sarif::head())?,
        }
        Ok(Rows {
            format,
            max_findings: max_findings.unwrap_or(usize::MAX),
            reader_count: readers.len(),
            has_output: false,
            totals: Totals::default(),
        })
    }

    /// Prints and counts the result for a file. `failed` is true if the file could not be read.
    pub fn show(&mut self, path: &Path, mut lint: Lint, failed: bool) -> io::Result<()> {
        self.totals.add(&lint);
        // A CSV row contains every code. In other formats, each finding is a separate line.
        if self.format != RowFormat::Csv {
            lint.findings.truncate(self.max_findings);
        }
        match self.format {
            // Many files of a collection may not be PTMs, so print only one line for each.
            RowFormat::Text if lint.status == Status::NotAPtm => {
                let found = lint.findings.first().map(|finding| finding.found.as_str());
                let found = found.map_or(String::new(), |found| format!(": {found}"));
                emit(&format!("{}: {}{found}\n", lint.file, lint.status.label()))
            }
            RowFormat::Text => print_text(&lint),
            RowFormat::Json => {
                let record = serde_json::to_string(&lint).map_err(io::Error::other)?;
                self.print_list_items(&[record])
            }
            RowFormat::Yaml => emit(&to_yaml(&[lint]).map_err(io::Error::other)?),
            RowFormat::Csv => emit(&csv::row(&lint, self.reader_count)),
            RowFormat::Sarif => self.print_list_items(&sarif::results(path, &lint, failed)),
        }
    }

    /// Prints the end of the document.
    pub fn end(&self) -> io::Result<()> {
        match self.format {
            RowFormat::Json => emit("\n]\n")?,
            RowFormat::Sarif => emit(sarif::tail())?,
            RowFormat::Yaml if self.totals.files == 0 => emit("[]\n")?,
            _ => {}
        }
        if self.totals.files > 1 && !output::is_quiet() {
            let totals = self.totals.to_text();
            match self.format {
                RowFormat::Text => emit(&totals)?,
                // The totals are not part of the document.
                _ => output::print_error(totals.trim_end()),
            }
        }
        Ok(())
    }

    fn print_list_items(&mut self, records: &[String]) -> io::Result<()> {
        let mut out = String::new();
        for record in records {
            out += if self.has_output { ",\n" } else { "" };
            out += record;
            self.has_output = true;
        }
        emit(&out)
    }
}

fn print_text(lint: &Lint) -> io::Result<()> {
    let (least, summary) = match output::is_quiet() {
        // Without a finding, the summary is the only line about the file.
        true if lint.reason.is_none() => (Severity::Error, String::new()),
        _ => (Severity::Info, lint.summary()),
    };
    let text = add_links(&(lint.to_text(least) + &summary + &lint.predictions_text()));
    write_at_once(anstream::stdout().lock(), &text)
}

fn emit(text: &str) -> io::Result<()> {
    write_at_once(io::stdout().lock(), text)
}

/// Prints text in a single write, so that a killed run leaves only complete rows.
fn write_at_once(mut out: impl Write, text: &str) -> io::Result<()> {
    out.write_all(text.as_bytes())?;
    out.flush()
}
