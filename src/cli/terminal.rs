//! Text for human readers: colored, and wrapped to the width of the terminal.
//!
//! The first word of a line determines its color. Without a terminal, the text is unchanged;
//! [`print`](super::output::print) respects `NO_COLOR` and `--color`.

use std::fmt::Write;

use anstyle::{AnsiColor, Style};

use super::links::add_links;
use super::output::{columns, print, wrap_line};

const HEADING_STYLE: Style = Style::new().bold();
const ERROR_STYLE: Style = AnsiColor::Red.on_default().bold();
const SUCCESS_STYLE: Style = AnsiColor::Green.on_default().bold();
const HINT_STYLE: Style = AnsiColor::Cyan.on_default();
const REMARK_STYLE: Style = AnsiColor::Yellow.on_default();
const DIMMED_STYLE: Style = Style::new().dimmed();

/// Line prefixes and their styles.
const STYLED_PREFIXES: [(&[&str], Style); 8] = [
    (&["FAIL", "fail:", "✗"], ERROR_STYLE),
    (&["pass:", "✓", "Fix:"], SUCCESS_STYLE),
    (&["→"], HINT_STYLE),
    (&["note:"], REMARK_STYLE),
    (&["–", "$"], DIMMED_STYLE),
    (&["Unexplained failures:", "misreading "], HEADING_STYLE),
    (&["code ", "plane "], HEADING_STYLE),
    (&["case ", "clause ", "ruling "], HEADING_STYLE),
];

/// Prints text, colored and wrapped for the terminal.
pub fn print_styled(text: &str) {
    let width = columns(terminal_size::terminal_size_of(std::io::stdout()));
    print(&add_links(&style_text(text, width)));
}

/// Colors text and wraps lines longer than `width`.
fn style_text(text: &str, width: Option<usize>) -> String {
    let mut page = String::new();
    for line in text.lines() {
        let indent = line.len() - line.trim_start_matches(' ').len();
        for (i, line) in wrap_line(line, width).iter().enumerate() {
            let marked = styled_prefix(line).filter(|_| i == 0);
            let (end, style) = marked.unwrap_or((indent.min(line.len()), Style::new()));
            let (start, rest) = line.split_at(end);
            let (indent, prefix) = start.split_at(indent.min(end));
            let _ = writeln!(page, "{indent}{style}{prefix}{style:#}{rest}");
        }
    }
    page
}

fn styled_prefix(line: &str) -> Option<(usize, Style)> {
    let text = line.trim_start_matches(' ');
    let indent = line.len() - text.len();
    let is_number = |count: &str| count.parse::<u32>().is_ok();
    // "64 of 64 failures: …"
    if text.starts_with(|c: char| c.is_ascii_digit())
        && let Some((counts, _)) = text.split_once(" failures:")
        && counts.split(" of ").all(is_number)
    {
        return Some((indent + counts.len() + " failures:".len(), HEADING_STYLE));
    }
    let (start, style) = STYLED_PREFIXES.iter().find_map(|(starts, style)| {
        let start = starts.iter().find(|start| text.starts_with(**start))?;
        Some((start, style))
    })?;
    // A heading consists of the keyword and the name after it.
    let name = text[start.len()..].split(' ').next().unwrap_or_default();
    let length = match (start.ends_with(' '), indent) {
        (false, _) => start.len(),
        (true, 0) => start.len() + name.len(),
        (true, _) => return None,
    };
    Some((indent + length, *style))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "64 of 64 failures: the decoder reads the high byte of an index first.\n  Fix: read the low byte first.\n  FAIL a-case  (2.5/2)\n    byte     0  version    PTM_1.2\n  $ printf '1 raw a-very-long-name.ptm' | decoder serve | xxd | head\n";

    #[test]
    fn styling_changes_only_colors_and_never_wraps_commands() {
        let plain = |width| anstream::adapter::strip_str(&style_text(TEXT, width)).to_string();
        assert_eq!(plain(None), TEXT);
        let wrapped = TEXT.replacen("the high byte", "the\n  high byte", 1);
        assert_eq!(plain(Some(40)), wrapped);
    }

    #[test]
    fn lines_are_colored_by_their_meaning() {
        let colored_word = |line: &str| {
            let (end, style) = styled_prefix(line)?;
            Some((line[..end].to_owned(), style))
        };
        for (marked, rest, style) in [
            ("64 of 64 failures:", " the decoder", HEADING_STYLE),
            ("  FAIL", " a-case  (2.5/2)", ERROR_STYLE),
            ("pass:", " 2114 pass", SUCCESS_STYLE),
            ("case hand-lum", " (clauses 2.6/1): x", HEADING_STYLE),
            ("clause 2.5/2:", " x", HEADING_STYLE),
        ] {
            let found = colored_word(&format!("{marked}{rest}"));
            assert_eq!(found, Some((marked.to_owned(), style)));
        }
        assert_eq!(colored_word("3 of the failures: x"), None);
        assert_eq!(colored_word("  case of need"), None);
    }
}
