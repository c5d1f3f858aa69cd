//! Pages for rulings: question, readings and evidence.

use maud::{Markup, html};

use super::objects;
use super::page::{PageContext, SiteFile};
use ptm_suite::cases::Case;
use ptm_suite::clauses::{Basis, Ruling, RulingKind};

/// Renders the list of rulings and the page of each ruling.
pub(super) fn pages(context: PageContext) -> Vec<SiteFile> {
    let rulings = &context.library.rulings;
    let list = html! {
        p.lead { "Rulings answer the questions that the text leaves open. Each page states how this suite and public readers read the text, and whether other readings fail." }
        (PageContext::descriptions(&context.library.texts.ruling_kinds, &["must", "choice", "lenient"]))
        div.scroll tabindex="0" { table.list {
            thead { tr { th scope="col" { "ruling" } th scope="col" { "kind" } th scope="col" { "rests on" } th scope="col" { "question" } } }
            tbody { @for ruling in rulings { tr { td { (context.link(&ruling.id)) } td { (ruling.kind.name()) } td { (ruling.rests_on.map_or("", Basis::name)) } td { (ruling.question.trim()) } } } }
        } }
    };
    let mut pages = vec![context.list("Rulings", &list)];
    pages.extend(rulings.iter().map(|ruling| page(context, ruling)));
    pages
}

/// Renders the question, the readings and the evidence of a ruling.
pub(super) fn describe_ruling(context: PageContext, ruling: &Ruling) -> Markup {
    html! {
        p { b { "Question: " } (context.prose(ruling.question.trim())) }
        p { b { "Our reading: " } (context.prose(ruling.reading.trim())) }
        @for also in &ruling.alternatives { p { b { "Also correct: " } (context.prose(also)) } }
        p { b { "Evidence: " } (context.prose(ruling.evidence.trim())) }
        @if let Some(basis) = ruling.rests_on { p { b { "Rests on: " } (basis.name()) " – " (basis.describe()) "." } }
    }
}

fn page(context: PageContext, ruling: &Ruling) -> SiteFile {
    let depends = |case: &&Case| {
        case.ruling.as_ref() == Some(&ruling.id) || case.axes().contains(&ruling.id.as_str())
    };
    let cases: Vec<&Case> = context.library.suite.cases.iter().filter(depends).collect();
    let mut kinds: Vec<&str> = Vec::new();
    for case in &cases {
        if !kinds.contains(&case.expect.name()) {
            kinds.push(case.expect.name());
        }
    }
    let body = html! {
        h1 { code { (ruling.id) } " " span.chip { (ruling.kind.name()) } }
        p { (context.library.texts.ruling_kinds[ruling.kind.name()]) @if ruling.kind != RulingKind::Lenient && kinds.contains(&"lenient") { " Cases of this ruling that are marked lenient are still outside the specification, and may be refused." } }
        (describe_ruling(context, ruling))
        @if let Some(objects) = objects::choice(context, &ruling.id) {
            h2 { "An object under each reading" }
            (objects)
        }
        h2 { "Clauses" }
        ul { @for clause in &ruling.clauses { li { (context.link(clause)) " " @if let Some(clause) = context.library.clause(clause) { (clause.rule) } } } }
        @if !cases.is_empty() {
            h2 { "Cases that depend on this ruling" }
            (PageContext::descriptions(&context.library.texts.expectations, &kinds))
            ul.columns { @for case in cases { li { (context.link(&case.id)) " " span.quiet { (case.expect.name()) } } } }
        }
    };
    let title = format!("Ruling {}", ruling.id);
    context.entry("Rulings", &ruling.id, &title, &body)
}
