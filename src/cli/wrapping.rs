//! Long lines, in parts that a terminal is wide enough for.

use std::borrow::Cow;

use terminal_size::{Height, Width};
use textwrap::{Options, WordSeparator, WordSplitter};

/// The narrowest page that text is wrapped for.
const NARROWEST: usize = 40;

/// The columns of a terminal that lines are wrapped for; none where there is no terminal.
pub fn columns(size: Option<(Width, Height)>) -> Option<usize> {
    size.map(|(width, _)| usize::from(width.0).max(NARROWEST))
}

/// A line that is longer than `width` in parts that are not, all but the first further in.
pub fn folded(line: &str, width: Option<usize>) -> Vec<Cow<'_, str>> {
    let indent = line.len() - line.trim_start_matches(' ').len();
    // A command is copied as a whole.
    match width.filter(|_| !line[indent..].starts_with("$ ")) {
        Some(width) => textwrap::wrap(line, options(width, &" ".repeat(indent + 2)))
            .into_iter()
            .map(|line| Cow::Owned(line.into_owned()))
            .collect(),
        None => vec![line.into()],
    }
}

fn options(width: usize, hanging: &str) -> Options<'_> {
    Options::new(width)
        .subsequent_indent(hanging)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .break_words(false)
}
