//! Pages for rulings: question, readings and evidence.

use maud::{Markup, html};

use super::paper::{PageContext, SiteFile};
use crate::suite::cases::Case;
use crate::suite::clauses::{Ruling, RulingKind};

/// Renders the list of rulings and the page of each ruling.
pub(super) fn pages(paper: PageContext) -> Vec<SiteFile> {
    let rulings = &paper.library.rulings;
    let list = html! {
        p.lead { "Rulings answer the questions that the text leaves open. Each page states this suite's reading, those of public readers, and whether other readings fail." }
        (PageContext::descriptions(&paper.library.texts.ruling_kinds, &["must", "choice", "lenient"]))
        div.scroll tabindex="0" { table.list {
            thead { tr { th scope="col" { "ruling" } th scope="col" { "kind" } th scope="col" { "question" } } }
            tbody { @for ruling in rulings { tr { td { (paper.link(&ruling.id)) } td { (ruling.kind.name()) } td { (ruling.question.trim()) } } } }
        } }
    };
    let mut pages = vec![paper.list("Rulings", &list)];
    pages.extend(rulings.iter().map(|ruling| page(paper, ruling)));
    pages
}

/// Renders the question, the readings and the evidence of a ruling.
pub(super) fn describe_ruling(paper: PageContext, ruling: &Ruling) -> Markup {
    html! {
        p { b { "Question: " } (paper.prose(ruling.question.trim())) }
        p { b { "Our reading: " } (paper.prose(ruling.reading.trim())) }
        @for also in &ruling.alternatives { p { b { "Also correct: " } (paper.prose(also)) } }
        p { b { "Evidence: " } (paper.prose(ruling.evidence.trim())) }
    }
}

fn page(paper: PageContext, ruling: &Ruling) -> SiteFile {
    let depends = |case: &&Case| {
        case.ruling.as_ref() == Some(&ruling.id) || case.axes().contains(&ruling.id.as_str())
    };
    let cases: Vec<&Case> = paper.library.suite.cases.iter().filter(depends).collect();
    let mut kinds: Vec<&str> = Vec::new();
    for case in &cases {
        if !kinds.contains(&case.expect.name()) {
            kinds.push(case.expect.name());
        }
    }
    let body = html! {
        h1 { code { (ruling.id) } " " span.chip { (ruling.kind.name()) } }
        p { (paper.library.texts.ruling_kinds[ruling.kind.name()]) @if ruling.kind != RulingKind::Lenient && kinds.contains(&"lenient") { " Cases of this ruling that are marked lenient are still outside the specification, and may be refused." } }
        (describe_ruling(paper, ruling))
        h2 { "Clauses" }
        ul { @for clause in &ruling.clauses { li { (paper.link(clause)) " " @if let Some(clause) = paper.library.clause(clause) { (clause.rule) } } } }
        @if !cases.is_empty() {
            h2 { "Cases that depend on this ruling" }
            (PageContext::descriptions(&paper.library.texts.expectations, &kinds))
            ul.columns { @for case in cases { li { (paper.link(&case.id)) " " span.quiet { (case.expect.name()) } } } }
        }
    };
    let title = format!("Ruling {}", ruling.id);
    paper.entry("Rulings", &ruling.id, &title, &body)
}
