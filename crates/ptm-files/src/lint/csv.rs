//! CSV output for spreadsheets and scripts, one row per file.
//!
//! Cells that a spreadsheet would interpret as a formula are prefixed with an apostrophe. No cell contains a line feed;
//! file names are already escaped (see [`escape_name`](super::names::escape_name)).

use super::{Lint, diagnostic::Diagnostic};
use crate::join_texts;
use crate::readers::ReaderPrediction;

/// Returns the header row, with the columns of each reader.
#[must_use]
pub fn head<'a>(readers: impl Iterator<Item = &'a str>) -> String {
    const FILE_COLUMNS: &str = "file,status,format,width,height,bytes,errors,warnings,infos,codes,first,sha256,modified,version,scale,bias,quality,lossless,puid,repairable";
    let file_columns = FILE_COLUMNS.split(',').map(str::to_owned);
    let reader_columns = readers.flat_map(|reader| {
        // The first column has the name of the reader alone.
        let others = ReaderPrediction::COLUMNS[1..].iter();
        let others = others.map(move |column| format!("{reader}: {column}"));
        std::iter::once(reader.to_owned()).chain(others)
    });
    join_cells(file_columns.chain(reader_columns))
}

/// Returns the row for a file, including its predictions. `readers` is the number of readers.
#[must_use]
pub fn row(lint: &Lint, readers: usize) -> String {
    let number = |number: Option<u64>| number.map(|number| number.to_string()).unwrap_or_default();
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    let mut codes: Vec<&str> = lint.findings.iter().map(|finding| finding.code).collect();
    codes.dedup();
    let first = lint.findings.first().map(Diagnostic::text);
    let file_columns = [
        lint.file.clone(),
        lint.status.name().to_owned(),
        lint.format.unwrap_or_default().to_owned(),
        number(lint.width.map(u64::from)),
        number(lint.height.map(u64::from)),
        number(lint.bytes),
        lint.errors.to_string(),
        lint.warnings.to_string(),
        lint.infos.to_string(),
        codes.join(" "),
        first.or_else(|| lint.reason.clone()).unwrap_or_default(),
        text(&lint.sha256),
        text(&lint.modified),
        text(&lint.metadata.version),
        text(&lint.metadata.scale),
        text(&lint.metadata.bias),
        text(&lint.metadata.quality),
        (lint.metadata.lossless).map_or(String::new(), |lossless| {
            if lossless { "yes" } else { "no" }.to_owned()
        }),
        lint.metadata.puid.unwrap_or_default().to_owned(),
        text(&lint.repairable),
    ];
    let reader_columns = (0..readers).flat_map(|reader| match lint.readers.get(reader) {
        Some(prediction) => prediction.cells(),
        None => [const { String::new() }; ReaderPrediction::COLUMNS.len()],
    });
    join_cells(file_columns.into_iter().chain(reader_columns))
}

/// Joins cells to a row.
pub fn join_cells(texts: impl Iterator<Item = String>) -> String {
    join_texts(texts.map(|text| quote_cell(&text)), ",") + "\n"
}

/// Returns the text of a cell. An apostrophe prevents spreadsheets from interpreting it as a formula.
#[must_use]
pub fn cell_text(text: &str) -> String {
    const FORMULAS: [char; 8] = ['=', '+', '-', '@', '＝', '＋', '－', '＠'];
    let is_formula = text.trim_start().starts_with(FORMULAS);
    let apostrophe = if is_formula { "'" } else { "" };
    apostrophe.to_owned() + &text.replace(char::is_control, " ")
}

/// Quotes a cell according to RFC 4180, and prevents spreadsheets from interpreting it as a formula.
fn quote_cell(text: &str) -> String {
    // Most cells need no quotes.
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._:-".contains(&byte);
    if text.bytes().all(is_plain) && !text.starts_with('-') {
        return text.to_owned();
    }
    let text = cell_text(text);
    match text.contains([',', ';', '"', '\'']) || text.trim() != text {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_quoted_and_never_formulas() {
        for (text, expected) in [
            ("coin.ptm", "coin.ptm"),
            ("a,b", "\"a,b\""),
            ("a;b", "\"a;b\""),
            ("say \"a\"", "\"say \"\"a\"\"\""),
            ("=1+1", "\"'=1+1\""),
            (" @SUM(A1)", "\"' @SUM(A1)\""),
            ("-x.ptm", "\"'-x.ptm\""),
            ("＝1", "\"'＝1\""),
            ("a\u{1b}b\nc", "a b c"),
        ] {
            assert_eq!(quote_cell(text), expected);
        }
    }
}
