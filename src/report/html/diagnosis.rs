//! Renders causes and fixes, and next steps for programs that are not decoders.

use maud::{Markup, html};

use crate::report::html::{cases::Group, shell::link};
use ptm_harness::report::document::{LikelyCause, Report, Verdict};
use ptm_harness::report::words::{call_instructions, details};
use ptm_suite::verdicts::outcome::Outcome;
use ptm_suite::{address::published_url, clauses::Clause};

/// Renders the causes, sorted by the number of cases that each explains.
pub(super) fn diagnosis(report: &Report, groups: &[Group], clauses: &[Clause]) -> Markup {
    let failures = report.with_outcome(Outcome::Fail).count();
    html! {
        section #main tabindex="-1" aria-labelledby="diagnosis" {
            h2 #diagnosis { "Diagnosis" }
            @if failures == 0 {
                p.lead {
                    @if report.verdict == Verdict::Pass { "All judged cases passed." }
                    @else { "No case failed, but the run does not count as passed. The reasons are at the top of this page and in the cases below." }
                }
            }
            @for group in groups {
                @match group.cause {
                    Some(cause) => (render_cause(report, cause, group, clauses)),
                    None => article.cause.unexplained {
                        p.share { b { (group.cases.len()) } " of " (failures) " failures" }
                        div {
                            h3 { "Unexplained failures" }
                            p { a href={ "#" (group.anchor()) } { "See the cases" } ", in the order of the specification." }
                        }
                    },
                }
            }
        }
    }
}

fn render_cause(report: &Report, cause: &LikelyCause, group: &Group, clauses: &[Clause]) -> Markup {
    let (suite, failures) = (report.suite, report.with_outcome(Outcome::Fail).count());
    html! {
        article.cause {
            p.share { b { (cause.explains.len()) } " of " (failures) " failures" }
            div {
                h3 { "The " (suite.subject()) " " (cause.effect) "." }
                p.fix { b { "Fix: " } (cause.fix) "." }
                @if let Some(id) = cause.misread_clause() {
                    p.rule {
                        b { "Clause " (link(suite.clause_page(id), &html! { (id) })) }
                        @if let Some(rule) = clauses.iter().find(|clause| clause.id == id) { ": " (rule.rule) }
                    }
                }
                @for (before, name, after, page) in details(cause, suite) {
                    p { (before) @if !name.is_empty() { (link(page, &html! { code { (name) } })) } (after) "." }
                }
                @if let Some(example) = &cause.example { p { "For example " (example.strip_prefix("for example ").unwrap_or(example).trim_end_matches('.')) "." } }
                p.quiet {
                    a href={ "#" (group.anchor()) } { "See the cases" }
                    @if let Some(slug) = &cause.misreading { " · " (link(Some(suite.misreading_page(slug)), &html! { "About this mistake" })) " · " code { "ptm-conform explain " (slug) } }
                }
            }
        }
    }
}

/// Renders the next steps for a program that is not a decoder.
pub(super) fn next_steps(report: &Report) -> Markup {
    let called = call_instructions(report.suite, &report.decoder.command);
    html! {
        section #main tabindex="-1" aria-labelledby="next" {
            h2 #next { "What to do next" }
            p.lead { "No case was judged, because the program does not implement the protocol yet." }
            ol.steps { @for line in called.lines() { li { (line) } } }
            p { a href=(published_url(report.suite.protocol_page())) { "The protocol" } " describes how a decoder is called and what each exit status means. "
                "The directory " code { "examples/decoders" } " contains a wrapper to start from." }
        }
    }
}
