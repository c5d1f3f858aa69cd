//! Matrix of decoders and clauses: the results of several decoders on one page.

use maud::{Markup, html};

use crate::report::html::clause_map::{FormatTallies, group_by_section, tallies};
use crate::report::html::shell::{complete_page, link, verdict_mark};
use ptm::Format;
use ptm_harness::report::document::{LikelyCause, Report};
use ptm_harness::report::suite_texts::SuiteTexts;

/// Renders a table with one column per report, and one row for each format and for each clause that a case tests. All reports must be
/// for the suite of these texts.
///
/// # Errors
/// Returns an error if there are no reports or they are for different suites.
pub fn matrix(reports: &[Report], texts: &SuiteTexts) -> Result<String, String> {
    let (clauses, suite_size) = (&texts.clauses[..], texts.cases.len());
    let suite = reports.first().ok_or("no reports")?.suite;
    if reports.iter().any(|report| report.suite != suite) {
        return Err("these reports are from different suites".to_owned());
    }
    let tallies: Vec<_> = reports.iter().map(tallies).collect();
    let by_format = reports
        .iter()
        .map(|report| FormatTallies::new(report, texts));
    let by_format: Vec<_> = by_format.collect();
    let is_first = |report: &Report| report.tool.corpus == reports[0].tool.corpus;
    let body = html! {
        header.top {
            div.bar {
                span.brand { "ptm-conform " span { (env!("CARGO_PKG_VERSION")) } }
                button #theme type="button" aria-pressed="false" title="Dark or light" { "◐ " span { "Dark or light" } }
            }
            p.kicker { (suite.title()) }
            h1 { (reports.len()) " decoders, clause by clause" }
        }
        main #main tabindex="-1" {
            @if !reports.iter().all(is_first) {
                p.note { "These reports were made with different versions of the suite; do not compare their numbers." }
            }
            p.legend {
                span.tile data-state="fail" { "✗" } " passed cases out of judged cases; at least one case failed "
                span.tile data-state="pass" { "✓" } " all passed "
                span.tile data-state="open" { "?" } " no case was judged (all were unsupported, inconclusive or not run) "
                span.tile data-state="none" { "·" } " no case about the clause was selected"
            }
            div.scroll.tall tabindex="0" {
                table.matrix {
                    thead { tr { th scope="col" { "decoder" } @for i in 0..reports.len() { th scope="col" { (command_name(reports, i)) } } } }
                    tbody {
                        (row("verdict", reports, |report| html! { span.verdict data-verdict=(report.verdict) { (verdict_mark(report.verdict)) " " (report.verdict) } }))
                        (row("cases", reports, |report| html! { (report.cases.len()) @if report.cases.len() < suite_size { " of " (suite_size) } }))
                        (row("correctness", reports, |report| html! { (report.scores.correctness) }))
                        (row("breadth", reports, |report| html! { (report.scores.breadth) }))
                        (row("robustness", reports, |report| html! { (report.scores.robustness) }))
                        (row("likely mistakes", reports, |report| cause_list(&report.diagnoses)))
                    }
                    @if !texts.formats.is_empty() {
                        tbody {
                            tr.section { th colspan=(reports.len() + 1) scope="rowgroup" { "Formats" } }
                            @for format in Format::ALL.map(Format::short_name) {
                                tr { th scope="row" { (format) } @for tallies in &by_format { (tallies.of_format(format).cell()) } }
                            }
                        }
                    }
                    @for (section, clauses) in group_by_section(clauses) {
                        tbody {
                            tr.section { th colspan=(reports.len() + 1) scope="rowgroup" { "Section " (section) } }
                            @for clause in clauses {
                                @if tallies.iter().any(|tallies| tallies.contains_key(clause.id.as_str())) {
                                    tr {
                                        th scope="row" { (link(suite.clause_page(&clause.id), &html! { code { (clause.id) } })) " " span.rule { (clause.rule) } }
                                        @for tallies in &tallies { (tallies.get(clause.id.as_str()).copied().unwrap_or_default().cell()) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    };
    let title = format!("{} decoders — {}", reports.len(), suite.short_title());
    Ok(complete_page(&title, &body))
}

/// Renders the command of the decoder in report `i`, followed by a number if several reports have the same command.
fn command_name(reports: &[Report], i: usize) -> Markup {
    let command = &reports[i].decoder.command;
    let has_same_command = |report: &&Report| report.decoder.command == *command;
    let count = |reports: &[Report]| reports.iter().filter(has_same_command).count();
    html! {
        code { (command) }
        @if count(reports) > 1 { " " span.quiet { "(" (count(&reports[..=i])) ")" } }
    }
}

/// Renders the first cause, and the others folded: the slug for misreadings in the catalog, and a description for other causes.
fn cause_list(causes: &[LikelyCause]) -> Markup {
    let render = |cause: &LikelyCause| {
        html! {
            @match &cause.misreading {
                Some(slug) => code.cause { (slug) },
                None => span.cause { (cause.effect) },
            }
            " "
        }
    };
    html! {
        @match causes {
            [] => {},
            [only] => (render(only)),
            [first, others @ ..] => {
                (render(first))
                details { summary.quiet { "and " (others.len()) " more" } @for cause in others { (render(cause)) } }
            }
        }
    }
}

fn row(name: &str, reports: &[Report], of: impl Fn(&Report) -> Markup) -> Markup {
    html! { tr { th scope="row" { (name) } @for report in reports { td { (of(report)) } } } }
}
