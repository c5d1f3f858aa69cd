//! Glossary of the terms of the format and of this suite.

use maud::html;

use super::page::{PageContext, SiteFile};

pub(super) fn anchor(word: &str) -> String {
    format!("w-{}", word.replace([' ', ','], "-"))
}

pub(super) fn page(context: PageContext) -> SiteFile {
    let body = html! {
        h1 { "Glossary" }
        dl.glossary {
            @for (word, meaning) in &context.library.texts.glossary { dt id=(anchor(word)) { (word) } dd { (context.prose(meaning)) } }
        }
    };
    context.page("glossary.html", "Glossary", "Glossary", &body)
}
