//! A page for each ruling: the question, our reading, the others, and the evidence.

use maud::{Markup, html};

use super::case_pages::meanings;
use super::paper::{Paper, SiteFile};
use crate::suite::cases::{Case, Expect};
use crate::suite::clauses::{Ruling, RulingKind};

/// Returns the pages of all rulings, and their list.
pub(super) fn pages(paper: Paper) -> Vec<SiteFile> {
    let rulings = &paper.library.rulings;
    let list = html! {
        h1 { "Rulings" }
        p.lead { "Where the text leaves something open, this suite says how it reads it, who reads how, and whether another reading fails." }
        (kinds())
        div.scroll tabindex="0" { table.list {
            thead { tr { th scope="col" { "ruling" } th scope="col" { "kind" } th scope="col" { "question" } } }
            tbody { @for ruling in rulings { tr { td { (paper.link(&ruling.id)) } td { (ruling.kind.name()) } td { (ruling.question.trim()) } } } }
        } }
    };
    let mut pages = vec![paper.page("rulings/index.html", "Rulings", "Rulings", &list)];
    pages.extend(rulings.iter().map(|ruling| page(paper, ruling)));
    pages
}

fn kinds() -> Markup {
    html! {
        dl.kinds {
            @for kind in [RulingKind::Must, RulingKind::Choice, RulingKind::Lenient] {
                dt { span.chip { (kind.name()) } } dd { (means(kind)) }
            }
        }
    }
}

fn means(kind: RulingKind) -> &'static str {
    match kind {
        RulingKind::Must => {
            "The text, real files or every independent reader settle it. A decoder that reads otherwise fails."
        }
        RulingKind::Choice => {
            "Nothing settles it. Each listed reading is right, if a decoder keeps to one of them throughout."
        }
        RulingKind::Lenient => {
            "The files are outside the specification. Refusing one is right, and so is the picture that the reading gives it, if it gives one; another picture is wrong."
        }
        RulingKind::ImplementationDefined => "Any answer is right; it is reported.",
    }
}

/// Describes a ruling.
pub(super) fn words(paper: Paper, ruling: &Ruling) -> Markup {
    html! {
        p { b { "Question: " } (paper.prose(ruling.question.trim())) }
        p { b { "Our reading: " } (paper.prose(ruling.reading.trim())) }
        @for also in &ruling.also { p { b { "Also right: " } (paper.prose(also)) } }
        p { b { "Evidence: " } (paper.prose(ruling.evidence.trim())) }
    }
}

fn page(paper: Paper, ruling: &Ruling) -> SiteFile {
    let shows = |case: &&Case| {
        case.ruling.as_ref() == Some(&ruling.id) || case.axes().contains(&ruling.id.as_str())
    };
    let cases: Vec<&Case> = paper.library.suite.cases.iter().filter(shows).collect();
    let mut kinds: Vec<Expect> = Vec::new();
    for case in &cases {
        if !kinds.contains(&case.expect) {
            kinds.push(case.expect);
        }
    }
    let body = html! {
        p.kicker { a href="index.html" { "Rulings" } }
        h1 { code { (ruling.id) } " " span.chip { (ruling.kind.name()) } }
        p { (means(ruling.kind)) @if ruling.kind != RulingKind::Lenient && kinds.contains(&Expect::Lenient) { " Its cases marked lenient are outside the specification all the same, and may be refused." } }
        (words(paper, ruling))
        h2 { "Clauses" }
        ul { @for clause in &ruling.clauses { li { (paper.link(clause)) " " @if let Some(clause) = paper.library.clause(clause) { (clause.rule) } } } }
        @if !cases.is_empty() {
            h2 { "Cases that show it" }
            (meanings(&kinds))
            ul.columns { @for case in cases { li { (paper.link(&case.id)) " " span.quiet { (case.expect.name()) } } } }
        }
    };
    paper.page(
        &format!("rulings/{}.html", ruling.id),
        "Rulings",
        &format!("Ruling {}", ruling.id),
        &body,
    )
}
