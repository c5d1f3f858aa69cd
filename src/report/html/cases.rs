//! Failing cases with their evidence, grouped by cause.

use std::collections::HashMap;

use maud::{Markup, html};

use crate::report::html::evidence::standard_error;
use crate::report::html::shell::{link, mark};
use ptm_harness::report::document::{CaseResult, LikelyCause, Report};
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_suite::name::SuiteName;
use ptm_suite::verdicts::outcome::Outcome;

/// Maximum number of bytes of markup for the evidence of all failing cases: images, files, excerpts, previews and standard
/// error. Evidence that does not fit is omitted, and the page mentions the omission.
pub const MAX_EVIDENCE_BYTES: usize = 3_500_000;

/// Number of cases per group that are initially visible.
const INITIALLY_VISIBLE_CASES: usize = 12;

/// Failing cases that share a cause, or all failing cases whose cause is unknown.
pub(super) struct Group<'a> {
    pub cause: Option<&'a LikelyCause>,
    pub cases: Vec<&'a CaseResult>,
}

impl Group<'_> {
    fn heading(&self, suite: SuiteName) -> String {
        match self.cause {
            Some(cause) => format!("The {} {}", suite.subject(), cause.effect),
            None => "Unexplained failures".to_owned(),
        }
    }

    pub(super) fn anchor(&self) -> String {
        match self.cause {
            // Several causes may be of one kind. Each has a different first case.
            Some(cause) => format!(
                "cases-{}",
                cause.explains.first().map_or("none", String::as_str)
            ),
            None => "cases-unexplained".to_owned(),
        }
    }
}

/// Groups the failing cases of a report by cause. The example of a cause is its first case. The unexplained cases come last.
pub(super) fn groups(report: &Report) -> Vec<Group<'_>> {
    let mut groups = Vec::new();
    for cause in report.diagnoses.iter().map(Some).chain([None]) {
        let failing = report.with_outcome(Outcome::Fail);
        let is_caused = |case: &&CaseResult| report.cause_of(case) == cause;
        let mut cases: Vec<_> = failing.filter(is_caused).collect();
        if let Some(example) = cause.and_then(|cause| cause.explains.first())
            && let Some(first) = cases.iter().position(|case| case.id == *example)
        {
            cases[..=first].rotate_right(1);
        }
        if !cases.is_empty() {
            groups.push(Group { cause, cases });
        }
    }
    groups
}

/// Rendered evidence, by id of the case.
pub(super) type EvidenceMarkup<'a> = HashMap<&'a str, Markup>;

/// Returns evidence for as many failing cases as fit in [`MAX_EVIDENCE_BYTES`]: the first case of every group, then the
/// second of every group, and so on.
pub(super) fn evidence<'a>(
    of_case: &dyn Fn(&str) -> Option<Markup>,
    groups: &[Group<'a>],
) -> EvidenceMarkup<'a> {
    let mut evidence = HashMap::new();
    let longest = groups.iter().map(|group| group.cases.len()).max();
    let in_turn = (0..longest.unwrap_or_default())
        .flat_map(|rank| groups.iter().filter_map(move |group| group.cases.get(rank)));
    let mut left = MAX_EVIDENCE_BYTES;
    for case in in_turn {
        let Some(shown) = of_case(&case.id) else {
            continue;
        };
        let Some(rest) = left.checked_sub(shown.0.len()) else {
            break;
        };
        left = rest;
        evidence.insert(case.id.as_str(), shown);
    }
    evidence
}

/// Renders the section of failing cases and the filter for all cases.
pub(super) fn failures(
    texts: &SuiteTexts,
    report: &Report,
    groups: &[Group],
    evidence: Option<&EvidenceMarkup>,
) -> Markup {
    let card = |case: &CaseResult, open: bool| {
        let markup = evidence.and_then(|evidence| evidence.get(case.id.as_str()));
        card(texts, report, case, markup, open)
    };
    let shown_count = evidence.map(HashMap::len);
    let failures = groups.iter().map(|group| group.cases.len()).sum::<usize>();
    html! {
        section aria-labelledby="cases" {
            h2 #cases { "Cases" }
            form.tools role="search" {
                label for="filter" { "Filter" }
                input #filter type="search" placeholder="an id, a clause such as 2.4/8, or a word" autocomplete="off" spellcheck="false";
                span #found role="status" aria-live="polite" { (report.cases.len()) " cases" }
                button #open type="button" { "Open all" }
                button #close type="button" { "Close all" }
            }
            @if failures > 0 && shown_count.is_none() {
                p.note { "This page was generated from a YAML report, which contains no images. Use “ptm-conform check --html” for a page with images." }
            } @else if let Some(shown) = shown_count && shown < failures {
                p.note {
                    "Images and bytes are shown for " (shown) " of " (failures)
                    " failures, beginning with one failure for each cause; a page contains at most " (MAX_EVIDENCE_BYTES / 1000) " kB of them."
                }
            }
            @for (i, group) in groups.iter().enumerate() {
                section.group id=(group.anchor()) aria-label=(group.heading(report.suite)) {
                    h3 { (group.heading(report.suite)) " " span.count { (group.cases.len()) } }
                    @let (first, more) = group.cases.split_at(INITIALLY_VISIBLE_CASES.min(group.cases.len()));
                    @for (j, case) in first.iter().enumerate() { (card(case, i == 0 && j == 0)) }
                    @if !more.is_empty() {
                        details.more {
                            summary { span.count { (more.len()) } " more" }
                            @for case in more { (card(case, false)) }
                        }
                    }
                }
            }
        }
    }
}

/// Renders the card of a failing case.
fn card(
    texts: &SuiteTexts,
    report: &Report,
    case: &CaseResult,
    evidence: Option<&Markup>,
    open: bool,
) -> Markup {
    let (says, purpose) = (&case.message, texts.purpose(&case.id));
    // The last part of the message names the affected part of the image; the evidence contains the texel.
    let short = says.rsplit("; ").next().unwrap_or_default();
    let long = match (evidence, says.split_once("texel (")) {
        (Some(_), Some((before, _))) => format!("{before}{short}"),
        _ => says.to_owned(),
    };
    html! {
        details.case id={ "case-" (case.id) } open[open] {
            summary {
                span.mark aria-label="fail" { (mark(Outcome::Fail)) }
                code { (case.id) }
                span.clauses { (case.clauses.join(" ")) }
                span.says { @if report.is_known(case) { span.chip { "known" } " " } (short) }
            }
            div.body {
                @if let Some(purpose) = purpose { p.because { (purpose) } }
                p.clauses { "Clauses " (clauses(report.suite, &case.clauses)) }
                p {
                    "Requested: " code { @if case.view.is_empty() { "nothing" } @else { (case.view) } } ", expected: " (case.expect) ". Result: "
                    (long) "."
                }
                @match evidence {
                    Some(evidence) => (evidence),
                    None => @if !case.stderr.is_empty() { (standard_error(&case.stderr)) },
                }
                p.label { "Run it again, with the other options of the run" }
                pre.command tabindex="0" { (repeat_command(report, &case.id)) }
                p.quiet {
                    code { "ptm-conform explain " (case.id) }
                    @if purpose.is_some() && report.suite.case_page(&case.id).is_some() { " · " (link(report.suite.case_page(&case.id), &html! { "its page" })) }
                }
            }
        }
    }
}

/// Renders clause ids as links to the site.
fn clauses(suite: SuiteName, ids: &[String]) -> Markup {
    html! {
        @for (i, id) in ids.iter().enumerate() { @if i > 0 { ", " } (link(suite.clause_page(id), &html! { (id) })) }
    }
}

/// Returns the command that repeats a single case, with the decoder command quoted for a shell.
fn repeat_command(report: &Report, id: &str) -> String {
    let command = &report.decoder.command;
    let quoted = |word: &str| shlex::try_quote(word).map_or_else(|_| "''".to_owned(), Into::into);
    let words = command.split(' ').map(quoted).collect::<Vec<_>>().join(" ");
    let case = quoted(id);
    let is_template = ["{in}", "{out}"].iter().any(|word| command.contains(word));
    let check = match report.suite {
        SuiteName::Ptm => "check",
        SuiteName::Texture => "check --suite texture",
        SuiteName::Writers => "check-writer",
        SuiteName::Fitters => "check-writer --fitter",
    };
    match is_template {
        true => format!(
            "ptm-conform {check} --case {case} --cmd {}",
            quoted(command)
        ),
        false => format!("ptm-conform {check} --case {case} -- {words}"),
    }
}
