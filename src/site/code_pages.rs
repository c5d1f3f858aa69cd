//! Pages for lint codes: meaning, effect, fix, an example, and affected readers.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::page::{PageContext, SiteFile};
use super::readers::{ReaderRun, readers_with_mistake};
use ptm_files::lint::codes::{self, Code};
use ptm_files::lint::lint;
use ptm_suite::cases::{Case, TableSpelling};

/// Renders the list of codes and the page of each code.
pub(super) fn pages(context: PageContext) -> Vec<SiteFile> {
    let list = html! {
        p.lead { code { "ptm-conform lint" } " reports these codes. E (error): the file breaks a rule, or the reference cannot read it. W (warning): some readers refuse the file or display a different image. I: information." }
        div.scroll tabindex="0" { table.list {
            thead { tr { th scope="col" { "code" } th scope="col" { "clause" } th scope="col" { "message" } } }
            tbody { @for code in codes::ALL.iter() { tr { td { (context.link(code.id)) } td { (context.link_as(code.clause, &html! { (code.clause) })) } td { (code.message) } } } }
        } }
    };
    let mut pages = vec![context.list("Lint codes", &list)];
    pages.extend(codes::ALL.iter().map(|code| page(context, code)));
    pages
}

fn page(context: PageContext, code: &Code) -> SiteFile {
    let triggers = |case: &&Case| {
        let damage = case.damage().map(|damage| damage.name.as_str());
        code.is_triggered_by(&case.id) || damage.is_some_and(|damage| code.is_triggered_by(damage))
    };
    let cases = context.library.suite.cases.iter().filter(triggers);
    let cases: Vec<&Case> = cases.collect();
    let body = html! {
        h1 { code { (code.id) } " " span.chip data-severity=(code.severity.name()) { (code.severity.name()) } }
        p.lead { "Message: " (code.message) "." }
        h2 { "Severity" }
        p { (context.library.texts.severities[code.severity.name()]) }
        @if let Some(clause) = context.library.clause(code.clause) { p { "Clause " (context.link(&clause.id)) ": " (clause.rule) } }
        @if !code.fix.is_empty() {
            @let (first, rest) = code.fix.split_at(1);
            h2 { "Fix" } p { (first.to_uppercase()) (rest) "." }
        }
        (example(context, code, &cases))
        (affected_readers(context, code, &cases))
        @if !cases.is_empty() {
            h2 { "Cases that trigger this code" }
            ul.columns { @for case in &cases { li { (context.link(&case.id)) } } }
        }
    };
    context.entry("Lint codes", code.id, code.id, &body)
}

/// Renders the output of lint for the smallest file that triggers the code.
fn example(context: PageContext, code: &Code, cases: &[&Case]) -> Markup {
    let built = |case: &&&Case| case.build(TableSpelling::default()).file.len();
    let Some(case) = cases.iter().min_by_key(built) else {
        return html! {};
    };
    let file = case.build(TableSpelling::default());
    let findings = lint(&file.file);
    html! {
        h2 { "Example" }
        p { (context.link(&case.id)) ", " (file.file.len()) " bytes: " (case.because) }
        @for finding in findings.iter().filter(|finding| finding.code == code.id) {
            pre.command tabindex="0" { (case.id) ".ptm: byte " (finding.offset) ": " (finding.code) ": " (finding.message) @if !finding.found.is_empty() { "\n  found: " (finding.found) } }
        }
    }
}

/// Lists the readers that are affected by the problem that the code reports, based on runs and the catalog.
fn affected_readers(context: PageContext, code: &Code, cases: &[&Case]) -> Markup {
    let mut seen: Vec<_> = ptm_mistakes::all().collect();
    seen.retain(|m| m.clause == code.clause && !readers_with_mistake(m).is_empty());
    let runs = &context.library.runs;
    let tally = |run: &ReaderRun| {
        let mut tally: BTreeMap<&str, usize> = BTreeMap::new();
        for case in cases {
            *tally.entry(run.outcome(&case.id).name()).or_default() += 1;
        }
        tally
    };
    html! {
        @if !seen.is_empty() || !cases.is_empty() {
            h2 { "Readers" }
            @if !cases.is_empty() {
                p { "Results for the files that trigger this code:" }
                ul { @for run in runs { li { (context.link_as(&run.reader, &html! { (run.reader) })) ": "
                    @for (i, (outcome, count)) in tally(run).iter().enumerate() { @if i > 0 { ", " } (count) " " (outcome) }
                } } }
            }
            @if !seen.is_empty() {
                p { "Misreadings of this clause that were seen in public readers:" }
                ul { @for misreading in seen { li { (context.link(misreading.slug)) ": " (super::misreading_pages::sightings(context, misreading)) } } }
            }
        }
    }
}
