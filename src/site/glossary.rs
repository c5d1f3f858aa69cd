//! The words of the format and of this suite.

use maud::html;

use super::paper::{Paper, SiteFile};

/// Returns the anchor of a word on its page.
pub(super) fn anchor(word: &str) -> String {
    format!("w-{}", word.replace([' ', ','], "-"))
}

/// Returns the glossary.
pub(super) fn page(paper: Paper) -> SiteFile {
    let body = html! {
        h1 { "Glossary" }
        dl.glossary {
            @for (word, means) in &paper.library.texts.glossary { dt id=(anchor(word)) { (word) } dd { (paper.prose(means)) } }
        }
    };
    paper.page("glossary.html", "Glossary", "Glossary", &body)
}
