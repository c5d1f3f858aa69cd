//! The index of the search box: a script that every page loads when the user begins to type.

use serde_json::{Value, json};

use super::docs_pages;
use super::glossary;
use super::library::Library;
use super::paper::SiteFile;

/// Returns the index: for each page its id, kind, address and words.
pub(super) fn index(library: &Library) -> SiteFile {
    let subjects = library.subjects().into_iter();
    let subjects =
        subjects.map(|subject| json!([subject.id, subject.kind, subject.place, subject.words]));
    let headings = docs_pages::headings()
        .map(|(heading, place, document)| json!([heading, "document", place, document]));
    let words = library.texts.glossary.iter().map(|(word, means)| {
        let place = format!("glossary.html#{}", glossary::anchor(word));
        json!([word, "word", place, means])
    });
    let entries: Value = subjects.chain(headings).chain(words).collect();
    let script = format!("window.searchIndex = {entries};\n");
    SiteFile::new("search-index.js", script)
}
