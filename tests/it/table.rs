//! Tables of test data, written as text.

/// Reads a table with one row per line. Cells are separated by a `|` that has a space on each side.
///
/// An indented line continues the row above it, and `↵` represents a line feed.
#[track_caller]
pub fn rows<const N: usize>(table: &str) -> Vec<[String; N]> {
    let mut rows: Vec<String> = Vec::new();
    for line in table.lines().filter(|line| !line.is_empty()) {
        match rows.last_mut().filter(|_| line.starts_with(' ')) {
            Some(row) => *row = format!("{row} {}", line.trim_start()),
            None => rows.push(line.to_owned()),
        }
    }
    let cells = |row: String| {
        let words: Vec<&str> = row.split(' ').collect();
        let cells = words.split(|word| *word == "|").map(|cell| cell.join(" "));
        let cells: Vec<String> = cells.map(|cell| cell.trim().replace('↵', "\n")).collect();
        let count = cells.len();
        cells
            .try_into()
            .unwrap_or_else(|_| panic!("{count} cells: {row}"))
    };
    rows.into_iter().map(cells).collect()
}
