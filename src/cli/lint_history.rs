//! Rows of an earlier `lint`: for continuing an interrupted run, and for comparing two runs.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::Path;

use ptm_files::lint::csv::{cell_text, head};
use ptm_files::lint::status::Status;
use ptm_files::lint::{Lint, names::escape_name};

use super::files::with_path;
use super::lint_rows::RowFormat;

/// A row of an earlier run.
#[derive(Clone, Debug)]
pub struct EarlierRow {
    /// The row as it was printed, without its line feed.
    pub line: String,
    /// The file as it was printed.
    file: String,
    pub status: Status,
    pub format: String,
    pub codes: Vec<String>,
    pub errors: usize,
    pub warnings: usize,
    bytes: Option<u64>,
    modified: String,
    pub sha256: String,
    /// True if the file was seen again.
    is_seen: bool,
}

impl EarlierRow {
    /// Returns true if the file has the size and the time of its row.
    pub fn is_unchanged(&self, bytes: u64, modified: &str) -> bool {
        // A file that could not be read may be readable now.
        self.status != Status::Unreadable && self.bytes == Some(bytes) && self.modified == modified
    }
}

/// The rows of an earlier run, by file.
pub struct EarlierRows {
    format: RowFormat,
    /// The names of the columns; empty for records in JSON.
    columns: Vec<String>,
    rows: HashMap<String, EarlierRow>,
    /// The working directory, to which relative paths refer.
    directory: String,
}

impl EarlierRows {
    /// Reads the rows that `lint --format csv` or `--format jsonl` printed to a file. A last line without a line feed, which an
    /// interrupted run may leave, is ignored.
    pub fn read(path: &Path) -> Result<EarlierRows, String> {
        let text = fs::read(path).map_err(with_path(path))?;
        let text = String::from_utf8_lossy(&text);
        let mut lines = text
            .split_inclusive('\n')
            .enumerate()
            .filter_map(|(number, line)| {
                let line = line.strip_suffix('\n')?;
                (!line.trim().is_empty()).then_some((number + 1, line))
            });
        let is_json = text.starts_with('{');
        let columns: Vec<String> = match is_json {
            true => Vec::new(),
            false => lines
                .next()
                .map_or_else(Vec::new, |(_, line)| split_row(line)),
        };
        let expected = head(std::iter::empty());
        if !is_json && !columns.starts_with(&split_row(expected.trim_end())) && !text.is_empty() {
            let mut why = "not the rows of `lint --format csv` or `--format jsonl` of this version"
                .to_owned();
            let first = text.lines().next().unwrap_or_default();
            if first.starts_with('\u{feff}') || first.contains(';') || first.contains('\t') {
                why +=
                    "; a spreadsheet seems to have saved them, so use the file that `lint` wrote";
            }
            return Err(with_path(path)(why));
        }
        let directory = std::env::current_dir().unwrap_or_default();
        let directory = escape_name(directory.as_os_str());
        let mut rows = HashMap::new();
        for (number, line) in lines {
            let row = match is_json {
                true => row_of_json(line),
                false => row_of_cells(&columns, line),
            };
            let wrong = || with_path(path)(format!("line {number} is not a row"));
            let row = row.ok_or_else(wrong)?;
            rows.insert(row_key(&directory, &row.file, !is_json), row);
        }
        Ok(EarlierRows {
            format: if is_json {
                RowFormat::Jsonl
            } else {
                RowFormat::Csv
            },
            columns,
            rows,
            directory,
        })
    }

    /// Returns the format of the rows.
    pub fn format(&self) -> RowFormat {
        self.format
    }

    /// Returns true if there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns an error if rows in `format`, with the columns of these readers, cannot continue these.
    pub fn check_format<'a>(
        &self,
        format: RowFormat,
        readers: impl Iterator<Item = &'a str>,
    ) -> Result<(), String> {
        if self.rows.is_empty() {
            return Ok(());
        }
        if self.format != format {
            let name = if self.format == RowFormat::Csv {
                "csv"
            } else {
                "jsonl"
            };
            return Err(format!(
                "--resume needs the format of the earlier rows: --format {name}"
            ));
        }
        match format == RowFormat::Csv && self.columns != split_row(head(readers).trim_end()) {
            true => Err("--resume needs the same --for as the earlier rows".to_owned()),
            false => Ok(()),
        }
    }

    /// Returns the earlier row of a file, if it has the same spelling of the path.
    pub fn get(&self, path: &Path) -> Option<&EarlierRow> {
        let name = escape_name(path.as_os_str());
        let row = self.rows.get(&self.key(&name))?;
        let is_equal = row.file == name || row.file == cell_text(&name);
        is_equal.then_some(row)
    }

    fn key(&self, name: &str) -> String {
        row_key(&self.directory, name, self.format == RowFormat::Csv)
    }

    /// Compares the result for a file with its earlier row, and returns what has changed.
    pub fn compare(&mut self, lint: &Lint) -> Option<Change> {
        let key = self.key(&lint.file);
        let Entry::Occupied(mut row) = self.rows.entry(key) else {
            return Some(Change::New(lint.status));
        };
        let row = row.get_mut();
        row.is_seen = true;
        let has_changed = match (&lint.sha256, row.sha256.as_str()) {
            (Some(digest), before) if !before.is_empty() => digest != before,
            _ => lint.bytes != row.bytes,
        };
        match (row.status, lint.status) {
            (before, now) if before != now && now == Status::Damaged => Some(Change::Damaged),
            (Status::Damaged, Status::Sound) => Some(Change::Repaired),
            (before, now) if before != now => Some(Change::Status(before, now)),
            _ => has_changed.then_some(Change::Changed),
        }
    }

    /// Returns the files of the earlier run that were not seen again, in order.
    pub fn missing(&self) -> Vec<&str> {
        let missing = self.rows.values().filter(|row| !row.is_seen);
        let mut missing: Vec<&str> = missing.map(|row| row.file.as_str()).collect();
        missing.sort_unstable();
        missing
    }
}

/// What has changed about a file since an earlier run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The file is new, and has this status.
    New(Status),
    /// The content has changed, but not the status.
    Changed,
    /// The file was not damaged before.
    Damaged,
    /// The file was damaged before, and is sound now.
    Repaired,
    /// The status has changed in another way.
    Status(Status, Status),
}

impl Change {
    /// Returns true if somebody should look at the file.
    pub fn needs_attention(self) -> bool {
        match self {
            Change::New(status) | Change::Status(_, status) => status != Status::Sound,
            Change::Changed | Change::Damaged => true,
            Change::Repaired => false,
        }
    }

    /// Describes the change.
    pub fn describe(self) -> String {
        match self {
            Change::New(status) => format!("new, {}", status.label()),
            Change::Changed => "changed".to_owned(),
            Change::Damaged => "newly damaged".to_owned(),
            Change::Repaired => "repaired".to_owned(),
            Change::Status(before, now) => format!("was {}, is {}", before.label(), now.label()),
        }
    }
}

/// Returns the absolute path of a file in a row, without repeated separators and `.`, so that `v`, `./v` and `/archive/v` are the
/// same file.
fn row_key(directory: &str, file: &str, is_cell: bool) -> String {
    let unquoted = file
        .strip_prefix('\'')
        .filter(|rest| is_cell && cell_text(rest) != *rest);
    let file = unquoted.unwrap_or(file);
    let start = if Path::new(file).is_absolute() {
        ""
    } else {
        directory
    };
    let parts = start.split('/').chain(file.split('/'));
    let parts: Vec<&str> = parts.filter(|part| !matches!(*part, "" | ".")).collect();
    parts.join("/")
}

fn row_of_cells(columns: &[String], line: &str) -> Option<EarlierRow> {
    let cells = split_row(line);
    if cells.len() != columns.len() {
        return None;
    }
    let cell = |name: &str| {
        let column = columns.iter().position(|column| column == name)?;
        Some(cells[column].clone())
    };
    Some(EarlierRow {
        line: line.to_owned(),
        file: cell("file")?,
        status: Status::from_name(&cell("status")?)?,
        format: cell("format")?,
        codes: cell("codes")?
            .split_whitespace()
            .map(str::to_owned)
            .collect(),
        errors: cell("errors")?.parse().ok()?,
        warnings: cell("warnings")?.parse().ok()?,
        bytes: cell("bytes")?.parse().ok(),
        modified: cell("modified")?,
        sha256: cell("sha256")?,
        is_seen: false,
    })
}

fn row_of_json(line: &str) -> Option<EarlierRow> {
    let record: serde_json::Value = serde_json::from_str(line).ok()?;
    let text = |name: &str| record[name].as_str().unwrap_or_default().to_owned();
    let count = |name: &str| record[name].as_u64().map(|count| count as usize);
    let codes = record["findings"].as_array()?.iter();
    Some(EarlierRow {
        line: line.to_owned(),
        file: record["file"].as_str()?.to_owned(),
        status: Status::from_name(record["status"].as_str()?)?,
        format: text("format"),
        codes: codes
            .filter_map(|finding| finding["code"].as_str().map(str::to_owned))
            .collect(),
        errors: count("errors")?,
        warnings: count("warnings")?,
        bytes: record["bytes"].as_u64(),
        modified: text("modified"),
        sha256: text("sha256"),
        is_seen: false,
    })
}

/// Splits a row of comma-separated cells, which may be quoted. No cell contains a line feed.
fn split_row(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut is_quoted = false;
    let mut characters = line.trim_end_matches('\r').chars().peekable();
    while let Some(character) = characters.next() {
        let cell = cells.last_mut().expect("there is always a cell");
        match character {
            '"' if is_quoted && characters.next_if_eq(&'"').is_some() => cell.push('"'),
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(String::new()),
            _ => cell.push(character),
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_of_a_file_have_one_key() {
        let key = |file| row_key("/archive", file, true);
        for file in ["./v/a.ptm", "v//a.ptm", "/archive/v/./a.ptm"] {
            assert_eq!(key(file), key("v/a.ptm"));
        }
        assert_eq!(key("'=1.ptm"), key("=1.ptm"));
        assert_ne!(key("w/a.ptm"), key("v/a.ptm"));
    }

    #[test]
    fn quoted_cells_are_split() {
        let cells = split_row("a,\"b, \"\"c\"\"\",,d");
        assert_eq!(cells, ["a", "b, \"c\"", "", "d"]);
        assert_eq!(split_row(""), [""]);
    }
}
