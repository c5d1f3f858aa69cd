//! Links to pages of the site: hyperlinks (OSC 8) if the terminal supports them, and text otherwise.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::IsTerminal;
use std::sync::LazyLock;

use ptm_files::lint::codes;
use ptm_suite::address::{self, published_url};
use ptm_suite::texture::cases as texture;
use ptm_suite::{cases::Suite, clauses, name::SuiteName};

/// Returns a line with the URL of a page, or an empty string if there is no page.
pub fn page_line(page: Option<String>) -> String {
    let line = page.map(|page| format!("  page: {}\n", published_url(&page)));
    line.unwrap_or_default()
}

/// Adds hyperlinks to text if standard output is a terminal that supports them. Never adds links for a pipe or a file.
pub fn add_links(text: &str) -> String {
    let wanted = std::io::stdout().is_terminal()
        && anstream::AutoStream::choice(&std::io::stdout()) != anstream::ColorChoice::Never
        && supports_hyperlinks::supports_hyperlinks();
    match wanted {
        true => insert_links(text, &page_url),
        false => text.to_owned(),
    }
}

fn page_url(word: &str) -> Option<String> {
    PAGES.get(word).map(|page| published_url(page))
}

/// Pages, keyed by the id of a case, clause, misreading or code. Ids that could be mistaken for ordinary words are omitted.
static PAGES: LazyLock<HashMap<String, String>> = LazyLock::new(|| {
    let (ptm, stage) = (SuiteName::Ptm, SuiteName::Texture);
    let mut pages = HashMap::new();
    let mut put = |id: &str, page: Option<String>| {
        let page = page.filter(|_| id.contains(['-', '/']));
        pages.extend(page.map(|page| (id.to_owned(), page)));
    };
    // Ignore errors in the files of the suite, which are reported elsewhere.
    for case in Suite::load().iter().flat_map(|suite| &suite.cases) {
        put(&case.id, ptm.case_page(&case.id));
    }
    for case in Suite::load_texture().iter().flat_map(|suite| &suite.cases) {
        put(&case.id, stage.case_page(&case.id));
    }
    for (suite, clauses) in [(ptm, clauses::clauses()), (stage, texture::clauses())] {
        for clause in clauses.into_iter().flatten() {
            put(&clause.id, suite.clause_page(&clause.id));
        }
    }
    for misreading in ptm_mistakes::all() {
        put(misreading.slug, Some(ptm.misreading_page(misreading.slug)));
    }
    for code in codes::ALL.iter() {
        put(code.id, Some(address::code(code.id)));
    }
    pages
});

/// Turns URLs of the site, and words for which `address` returns a URL, into hyperlinks. Escape sequences are preserved.
fn insert_links(text: &str, address: &dyn Fn(&str) -> Option<String>) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '/' | '.' | ':' | '#');
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_last = |c: char| c.is_ascii_alphabetic();
        let length = match first {
            '\x1b' => rest.find(is_last).map(|end| end + 1),
            _ if is_part(first) => rest.find(|c: char| !is_part(c)),
            _ => Some(first.len_utf8()),
        };
        let (word, after) = rest.split_at(length.unwrap_or(rest.len()));
        let name = word.trim_end_matches(['.', ':', '/']);
        let target = match name.starts_with(address::SITE) {
            true => Some(name.to_owned()),
            false => address(name),
        };
        match target {
            Some(target) if first != '\x1b' => {
                let _ = write!(out, "\x1b]8;;{target}\x1b\\{name}\x1b]8;;\x1b\\");
                out += &word[name.len()..];
            }
            _ => out += word,
        }
        rest = after;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_words_with_a_page_become_links() {
        let text = "\x1b[1mclause 2.4/8:\x1b[0m x. More: ptm-conform explain rows-top-down\n  FAIL hand-rgb-blocks  (2.7.1/2, 2.4/99) rows";
        let linked = insert_links(text, &page_url);
        assert_eq!(linked.matches("\x1b]8;;https://").count(), 4, "{linked:?}");
        for (name, place) in [
            ("2.4/8", "format/2.4.html#c-2.4-8"),
            ("rows-top-down", "misreadings/rows-top-down.html"),
            ("hand-rgb-blocks", "cases/hand-rgb-blocks.html"),
            ("2.7.1/2", "format/2.7.html#c-2.7.1-2"),
        ] {
            let link = format!("\x1b]8;;{}{place}\x1b\\{name}\x1b]8;;\x1b\\", address::SITE);
            assert!(linked.contains(&link), "{name}: {linked:?}");
        }
        let plain = |text: &str| anstream::adapter::strip_str(text).to_string();
        assert_eq!(plain(&linked), plain(text));
    }

    #[test]
    fn page_addresses_become_links() {
        let line = page_line(SuiteName::Ptm.clause_page("2.9.8/2"));
        let expected = format!("{}format/2.9.8.html#c-2.9.8-2", address::SITE);
        assert_eq!(line, format!("  page: {expected}\n"));
        let linked = insert_links(&line, &|_| None);
        assert_eq!(linked.matches("2.9.8.html").count(), 2, "{linked:?}");
    }
}
