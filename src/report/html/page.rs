//! Page of a single report.

use maud::{Markup, html};

use crate::report::html::cases::{EvidenceMarkup, Group, evidence, failures, groups};
use crate::report::html::clause_map::FormatTallies;
use crate::report::html::diagnosis::{diagnosis, next_steps};
use crate::report::html::evidence::Evidence;
use crate::report::html::shell::{complete_page, link, mark, verdict_mark};
use crate::report::html::{clause_map, scene};
use crate::report::text::not_asked_text;
use ptm_harness::report::document::{CaseResult, Report};
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_harness::session::lit_scene::LitScene;
use ptm_suite::verdicts::{outcome::Outcome, scores::Fraction};
use ptm_suite::{address::SITE, clauses::Ruling};

/// Renders the page of a report, with images of the responses.
#[must_use]
pub fn page(texts: &SuiteTexts, report: &Report, shown: &Evidence) -> String {
    let groups = groups(report);
    let evidence = evidence(&shown.of_case, &groups);
    page_with(texts, report, &groups, Some((&evidence, shown.scene)))
}

/// Renders the page of a report without images.
#[must_use]
pub fn page_without_images(texts: &SuiteTexts, report: &Report) -> String {
    page_with(texts, report, &groups(report), None)
}

fn page_with(
    texts: &SuiteTexts,
    report: &Report,
    groups: &[Group],
    images: Option<(&EvidenceMarkup, Option<&LitScene>)>,
) -> String {
    let (command, verdict) = (&report.decoder.command, &report.verdict);
    let (evidence, scene) = images.unzip();
    let title = format!("{command}: {verdict} — {}", report.suite.short_title());
    let body = html! {
        (header(texts, report))
        main {
            @if report.reason.is_some() {
                (next_steps(report))
            } @else {
                div.first {
                    (diagnosis(report, groups, &texts.clauses))
                    aside {
                        @if let Some(scene) = scene.flatten().filter(|scene| is_telling(scene, report)) { (scene::figure(scene)) }
                        @if report.with_outcome(Outcome::Fail).next().is_some() { (FormatTallies::new(report, texts).markup()) }
                    }
                }
            }
            @if !report.cases.is_empty() {
                (failures(texts, report, groups, evidence))
                (clause_map::section(report, &texts.clauses))
                (dialect(report, &texts.rulings))
                (other_cases(report))
            }
            (footer(report))
        }
    };
    complete_page(&title, &body)
}

/// Returns true if the scene supports the verdict. A correct image beside failures would contradict it.
fn is_telling(scene: &LitScene, report: &Report) -> bool {
    scene.is_visibly_wrong() || report.with_outcome(Outcome::Fail).next().is_none()
}

fn header(texts: &SuiteTexts, report: &Report) -> Markup {
    html! {
        header.top {
            div.bar {
                span.brand { "ptm-conform " span { (report.tool.version) } }
                button #theme type="button" aria-pressed="false" title="Dark or light" { "◐ " span { "Dark or light" } }
            }
            p.kicker { (report.suite.title()) }
            @if let Some(name) = &report.decoder.name {
                p.kicker { (name) @if let Some(version) = &report.decoder.version { " " (version) } ", called as" }
            }
            h1 {
                code { (report.decoder.command) }
                " "
                span.verdict data-verdict=(report.verdict) { (verdict_mark(report.verdict)) " " (report.verdict) }
            }
            @if let Some(reason) = &report.reason { pre.reason tabindex="0" { (reason) } }
            @for remark in &report.remarks {
                p.remark data-failure[remark.failure] { b { @if remark.failure { "✗ Fails: " } @else { "Note: " } } (remark.message) }
            }
            @if !report.cases.is_empty() { (results(texts, report)) }
        }
    }
}

/// Renders the scores and the number of cases with each outcome.
fn results(texts: &SuiteTexts, report: &Report) -> Markup {
    let (selected, all) = (report.cases.len(), texts.cases.len());
    html! {
        dl.scores {
            (score("Correctness", report.scores.correctness, "passed cases among the judged cases that the decoder supports"))
            (score("Breadth", report.scores.breadth, "decoded features among those in the suite"))
            (score("Robustness", report.scores.robustness, "calls that ended with an image or a refusal"))
        }
        p.counts {
            @for outcome in Outcome::ALL {
                @let count = report.with_outcome(outcome).count();
                @if count > 0 {
                    button.chip type="button" data-outcome=(outcome.name()) data-filter={ "is:" (filter_value(outcome)) } title="Show only these cases" {
                        (mark(outcome)) " " span.count { (count) } " " (outcome.name())
                    } " "
                }
            }
            @if let Some(baseline) = &report.baseline {
                span.quiet { (baseline.known.len()) " known failures, " (baseline.new.len()) " new failures, " (baseline.stale.len()) " fixed" } " "
            }
            @let not_asked: usize = report.not_asked.values().sum();
            @if selected + not_asked < all { span.quiet { (selected + not_asked) " of " (all) " cases were selected" } }
            @if not_asked > 0 { span.quiet { " " (not_asked) " were not asked" } }
        }
    }
}

fn filter_value(outcome: Outcome) -> String {
    outcome.name().replace(' ', "-")
}

fn score(name: &str, score: Fraction, means: &str) -> Markup {
    let Fraction { part, whole } = score;
    html! {
        div {
            dt { (name) }
            dd.number { (part) span { "/" (whole) } }
            dd { meter min="0" max=(whole.max(1)) value=(part) aria-label=(name) { (score) } }
            dd.means { (means) }
        }
    }
}

/// Renders the cases that did not fail, grouped by outcome.
fn other_cases(report: &Report) -> Markup {
    html! {
        section aria-labelledby="others" {
            h2 #others { "All other cases" }
            @for outcome in Outcome::ALL {
                @let cases: Vec<&CaseResult> = report.with_outcome(outcome).collect();
                @if outcome != Outcome::Fail && !cases.is_empty() {
                    details.others data-outcome=(filter_value(outcome)) {
                        summary { span.mark { (mark(outcome)) } " " span.count { (cases.len()) } " " (outcome.name()) }
                        table.list {
                            thead { tr { th scope="col" { "case" } th scope="col" { "view" } th scope="col" { "expected" } th scope="col" { "clauses" } th scope="col" { "remark" } } }
                            tbody {
                                @for case in cases {
                                    tr { td { (link(report.suite.case_page(&case.id), &html! { code { (case.id) } })) } td { @if case.view.is_empty() { "–" } @else { (case.view) } } td { (case.expect) @if case.weak { ", weakly" } } td { (case.clauses.join(" ")) } td { (case.message) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Renders the decoder's readings of open questions and the features that it decodes.
fn dialect(report: &Report, rulings: &[Ruling]) -> Markup {
    html! {
        section aria-labelledby="dialect" {
            h2 #dialect { "Dialect and breadth" }
            p { "The specification leaves some questions open. Each of the readings below is correct if the decoder follows it in all files." }
            @if report.dialect.is_empty() { p.quiet { "No case distinguishes the readings." } } @else {
                table.list {
                    thead { tr { th scope="col" { "ruling" } th scope="col" { "the question" } th scope="col" { "this decoder" } } }
                    tbody {
                        @for known in &report.dialect {
                            tr {
                                td { (link(Some(report.suite.ruling_page(&known.ruling)), &html! { code { (known.ruling) } })) }
                                td { (rulings.iter().find(|ruling| ruling.id == known.ruling).map(|ruling| ruling.question.trim()).unwrap_or_default()) }
                                td { (known.reading) }
                            }
                        }
                    }
                }
            }
            ul.features {
                @for feature in &report.decoder.decodes { li { span.mark { (mark(Outcome::Pass)) } " " (feature) } }
                @for feature in &report.decoder.unsupported { li.absent { span.mark { (mark(Outcome::Unsupported)) } " " (feature) " " small { (report.in_words_for_decoder("unsupported (exit status 69)")) } } }
            }
            @if let Some(text) = not_asked_text(report) { p.quiet { (text) } }
            p.quiet { "Views offered: " (report.decoder.views.join(", ")) }
        }
    }
}

fn footer(report: &Report) -> Markup {
    html! {
        footer {
            p {
                (report.tool.name) " " (report.tool.version) ". Digest of the suite's files: "
                code.digest { (report.tool.corpus) }
            }
            ul { @for limit in &report.tool.limits { li { (limit) } } }
            p {
                "Cases, clauses, rulings and misreadings are explained by " code { "ptm-conform explain ID" } " and on "
                a href=(SITE) { "the site" } ". This page loads nothing from a server."
            }
        }
    }
}
