//! Search index: a script that a page loads when the user focuses the search box.

use serde_json::{Value, json};

use super::{docs_pages, glossary, library::Library, page::SiteFile};

/// Generates the index: id, kind, URL and description of each page.
pub(super) fn index(library: &Library) -> SiteFile {
    let subjects = library.subjects().into_iter().map(|subject| json!(subject));
    let headings = docs_pages::headings()
        .map(|(heading, url, document)| json!([heading, "document", url, document]));
    let words = library.texts.glossary.iter().map(|(word, meaning)| {
        let url = format!("glossary.html#{}", glossary::anchor(word));
        json!([word, "word", url, meaning])
    });
    let entries: Value = subjects.chain(headings).chain(words).collect();
    let script = format!("window.searchIndex = {entries};\n");
    SiteFile::new("search-index.js", script)
}
