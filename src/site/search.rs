//! The index of the search box: a script that every page loads when the user begins to type.

use serde_json::json;

use super::docs_pages;
use super::glossary;
use super::library::{Library, PROTOCOL};
use super::paper::SiteFile;
use crate::misreadings;
use crate::tools::lint::codes;

/// Returns the index: for each page its id, kind, address and words.
pub(super) fn index(library: &Library) -> SiteFile {
    let mut entries = Vec::new();
    let mut put = |id: &str, kind: &str, words: &str| {
        if let Some(place) = library.place(id) {
            entries.push(json!([id, kind, place, words]));
        }
    };
    put(
        PROTOCOL,
        "protocol",
        "what a decoder is asked, and what exit status 0, 65, 69 and others count as",
    );
    for chapter in &library.annotated.chapters {
        put(&chapter.section, "section", &chapter.title);
    }
    for clause in &library.clauses {
        put(&clause.id, "clause", &clause.rule);
    }
    for ruling in &library.rulings {
        put(&ruling.id, "ruling", ruling.question.trim());
    }
    for code in codes::ALL.iter() {
        put(code.id, "lint code", code.says);
    }
    for reader in library.readers() {
        put(reader, "reader", "");
    }
    for misreading in misreadings::all() {
        put(misreading.slug, "misreading", misreading.effect);
    }
    for case in &library.suite.cases {
        put(&case.id, "case", &case.because);
    }
    for requirement in &library.requirements {
        put(&requirement.id, "texture", &requirement.rule);
    }
    for ruling in &library.texture_rulings {
        put(&ruling.id, "texture ruling", ruling.question.trim());
    }
    for misreading in misreadings::texture::all() {
        put(misreading.slug, "texture misreading", misreading.effect);
    }
    for case in &library.textures.cases {
        put(&case.id, "texture case", &case.because);
    }
    for (heading, place, document) in docs_pages::headings() {
        entries.push(json!([heading, "document", place, document]));
    }
    for (word, means) in &library.texts.glossary {
        let place = format!("glossary.html#{}", glossary::anchor(word));
        entries.push(json!([word, "word", place, means]));
    }
    let script = format!(
        "window.searchIndex = {};\n",
        serde_json::Value::Array(entries)
    );
    SiteFile {
        path: "search-index.js".to_owned(),
        bytes: script.into_bytes(),
    }
}
