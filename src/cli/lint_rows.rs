//! Output of `lint` in every format: a row for each file, in order, and the totals at the end.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::lint_page;
use clap::ValueEnum;
use ptm_files::lint::{Lint, csv, sarif};
use ptm_files::lint::{codes::Severity, status::Status, totals::Totals};
use ptm_files::readers::ReaderProfile;
use ptm_suite::kit::yaml::to_yaml;

use super::{
    files,
    links::add_links,
    lint_history::{Change, EarlierRow},
    output,
};

/// Output format of the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum RowFormat {
    /// Text for human readers
    Text,
    /// A list with a record for each file
    Json,
    /// A JSON record for each file, one per line
    Jsonl,
    /// A list in YAML
    Yaml,
    /// A row for each file
    Csv,
    /// A page for people, with thumbnails
    Html,
    /// SARIF 2.1.0, for code hosts and editors
    Sarif,
}

impl RowFormat {
    /// Returns true if the format has the time and the digest of each file.
    pub fn has_columns(self) -> bool {
        !matches!(self, RowFormat::Text | RowFormat::Sarif | RowFormat::Html)
    }
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
        has_header: bool,
        folders: &[String],
    ) -> io::Result<Rows> {
        match format {
            RowFormat::Text | RowFormat::Yaml | RowFormat::Jsonl => {}
            RowFormat::Json => emit("[\n")?,
            RowFormat::Html => emit(&lint_page::head(folders))?,
            RowFormat::Csv if !has_header => {}
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

    /// Prints and counts a row of an earlier run.
    pub fn show_earlier(&mut self, row: &EarlierRow) -> io::Result<()> {
        let codes = row.codes.iter().map(String::as_str);
        self.totals.add_row(row.status, &row.format, codes);
        emit(&(row.line.clone() + "\n"))
    }

    /// Counts a file in a folder that is not checked.
    pub fn count_other(&mut self) {
        self.totals.others += 1;
    }

    /// Returns the number of checked files, and that of other files in folders.
    pub fn counts(&self) -> [usize; 2] {
        [self.totals.files, self.totals.others]
    }

    /// Prints and counts the result for a file. `thumbnail` is a PNG in base64.
    pub fn show(
        &mut self,
        path: &Path,
        mut lint: Lint,
        thumbnail: Option<&String>,
    ) -> io::Result<()> {
        self.totals.add(&lint);
        let failed = lint.status == Status::Unreadable;
        // A CSV row contains every code. In other formats, each finding is a separate line.
        if self.format != RowFormat::Csv {
            lint.findings.truncate(self.max_findings);
        }
        match self.format {
            RowFormat::Text if lint.status == Status::Foreign => {
                let reason = lint.reason.as_deref().unwrap_or_default();
                emit(&format!(
                    "{}: {}: {reason}\n",
                    lint.file,
                    lint.status.label()
                ))
            }
            RowFormat::Text => print_text(&lint),
            RowFormat::Json => {
                let record = serde_json::to_string(&lint).map_err(io::Error::other)?;
                self.print_list_items(&[record])
            }
            RowFormat::Html => emit(&lint_page::article(&lint, thumbnail).into_string()),
            RowFormat::Jsonl => {
                let record = serde_json::to_string(&lint).map_err(io::Error::other)?;
                emit(&(record + "\n"))
            }
            RowFormat::Yaml => emit(&to_yaml(&[lint]).map_err(io::Error::other)?),
            RowFormat::Csv => emit(&csv::row(&lint, self.reader_count)),
            RowFormat::Sarif => self.print_list_items(&sarif::results(path, &lint, failed)),
        }
    }

    /// Prints what has changed about a file since an earlier run, and counts the file.
    pub fn show_change(&mut self, lint: &Lint, change: Option<Change>) -> io::Result<()> {
        self.totals.add(lint);
        let Some(change) = change else {
            return Ok(());
        };
        let details = match change.needs_attention() {
            true => lint.to_text(Severity::Error),
            false => String::new(),
        };
        let text = format!("{}: {}\n{details}", lint.file, change.describe());
        write_at_once(anstream::stdout().lock(), &add_links(&text))
    }

    /// Prints that a file of an earlier run is missing.
    pub fn show_missing(file: &str) -> io::Result<()> {
        emit(&format!("{file}: missing\n"))
    }

    /// Prints the end of the document.
    pub fn end(&self) -> io::Result<()> {
        match self.format {
            RowFormat::Json => emit("\n]\n")?,
            RowFormat::Html => emit(&lint_page::tail(&self.totals).into_string())?,
            RowFormat::Sarif => emit(sarif::tail())?,
            RowFormat::Yaml if self.totals.files == 0 => emit("[]\n")?,
            _ => {}
        }
        if self.totals.files + self.totals.others > 1 && !output::is_quiet() {
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

/// Rows that replace those of an earlier run when the run is complete. They are in memory until then, as the earlier rows are.
pub struct Renewal {
    path: PathBuf,
    format: RowFormat,
    reader_count: usize,
    rows: Vec<u8>,
}

impl Renewal {
    /// Begins rows in `format`, CSV or JSON lines, for the file at `path`.
    pub fn new(
        path: &Path,
        format: RowFormat,
        readers: &[&ReaderProfile],
    ) -> Result<Renewal, String> {
        files::check_writable(path)?;
        let head = match format {
            RowFormat::Csv => csv::head(readers.iter().map(|reader| &*reader.name)),
            _ => String::new(),
        };
        Ok(Renewal {
            path: path.to_owned(),
            format,
            reader_count: readers.len(),
            rows: head.into_bytes(),
        })
    }

    pub fn add(&mut self, lint: &Lint) -> io::Result<()> {
        if self.format == RowFormat::Csv {
            self.rows.extend(csv::row(lint, self.reader_count).bytes());
        } else {
            serde_json::to_writer(&mut self.rows, lint).map_err(io::Error::other)?;
            self.rows.push(b'\n');
        }
        Ok(())
    }

    /// Replaces the earlier rows.
    pub fn finish(self) -> Result<(), String> {
        files::write_atomically(&self.path, self.rows)
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
