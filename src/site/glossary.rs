//! Glossary of the terms of the format and of this suite.

use maud::html;

use super::paper::{PageContext, SiteFile};

/// Returns the anchor of a word on the glossary page.
pub(super) fn anchor(word: &str) -> String {
    format!("w-{}", word.replace([' ', ','], "-"))
}

/// Renders the glossary page.
pub(super) fn page(paper: PageContext) -> SiteFile {
    let body = html! {
        h1 { "Glossary" }
        dl.glossary {
            @for (word, meaning) in &paper.library.texts.glossary { dt id=(anchor(word)) { (word) } dd { (paper.prose(meaning)) } }
        }
    };
    paper.page("glossary.html", "Glossary", "Glossary", &body)
}
