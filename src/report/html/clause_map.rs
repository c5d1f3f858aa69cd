//! Map of all clauses of the specification, colored by the results of the run.

use std::collections::{BTreeMap, BTreeSet};

use maud::{Markup, html};

use crate::report::html::shell::link;
use ptm::Format;
use ptm_harness::report::document::Report;
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_suite::clauses::{Clause, ClauseStatus, section_of};
use ptm_suite::name::SuiteName;
use ptm_suite::verdicts::outcome::Outcome;

/// Results of a run for one clause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClauseTally {
    /// Number of cases that passed.
    pub passed: usize,
    /// Number of cases that failed.
    pub failed: usize,
    /// Number of cases with any other outcome, such as unsupported or inconclusive.
    pub open: usize,
}

impl ClauseTally {
    /// Counts results by clause. Each result is paired with the clauses of its case.
    pub(crate) fn count<'a>(
        results: impl Iterator<Item = (&'a Vec<String>, Outcome)>,
    ) -> BTreeMap<&'a str, ClauseTally> {
        let mut tallies: BTreeMap<&str, ClauseTally> = BTreeMap::new();
        for (clauses, outcome) in results {
            for clause in clauses {
                tallies.entry(clause).or_default().add(outcome);
            }
        }
        tallies
    }

    /// Counts a result.
    pub(crate) fn add(&mut self, outcome: Outcome) {
        *match outcome {
            Outcome::Pass => &mut self.passed,
            Outcome::Fail => &mut self.failed,
            _ => &mut self.open,
        } += 1;
    }

    /// Returns a style that colors a cell by the share of failed cases, if there are any.
    pub(crate) fn heat(self) -> Option<String> {
        let share = 100 * self.failed / (self.passed + self.failed).max(1);
        (self.failed > 0).then(|| format!("--share:{}%", 20 + 80 * share / 100))
    }

    /// Renders the tally as a narrow cell: the share of passed cases, with the numbers as a tooltip.
    pub(crate) fn share_cell(self) -> Markup {
        let (state, mark) = self.state();
        let judged = self.passed + self.failed;
        let says = format!("{} of {judged} pass, {} open", self.passed, self.open);
        html! {
            td data-state=(state) style=[self.heat()] title=(says) {
                @if self.failed > 0 { (100 * self.passed / judged) small { "%" } } @else { (mark) }
            }
        }
    }

    /// Renders the tally as a small cell: the number of failed cases, or a symbol.
    fn heat_cell(self, section: &str, format: &str) -> Markup {
        let (state, mark) = self.state();
        let says = format!(
            "{section}, {format}: {} passed, {} failed, {} open",
            self.passed, self.failed, self.open
        );
        html! {
            td data-state=(state) style=[self.heat()] title=(says) {
                @if self.failed > 0 { (self.failed) } @else { (mark) }
            }
        }
    }

    /// Returns the state of the clause as a word and a symbol.
    pub(crate) fn state(self) -> (&'static str, &'static str) {
        match self {
            ClauseTally { failed: 1.., .. } => ("fail", "✗"),
            ClauseTally { passed: 1.., .. } => ("pass", "✓"),
            ClauseTally { open: 1.., .. } => ("open", "?"),
            _ => ("none", "·"),
        }
    }

    /// Renders the tally as a cell of a table.
    pub(crate) fn cell(self) -> Markup {
        let (state, mark) = self.state();
        let judged = self.passed + self.failed;
        html! {
            td.result data-state=(state) style=[self.heat()] {
                (mark) " "
                @if judged > 0 { (self.passed) span { "/" (judged) } } @else if self.open > 0 { span { (self.open) " open" } }
            }
        }
    }
}

/// Results of a run for the cases of each format, and of each section and format.
pub(super) struct FormatTallies<'a> {
    by_section: BTreeMap<(&'a str, &'static str), ClauseTally>,
    by_format: BTreeMap<&'static str, ClauseTally>,
}

impl<'a> FormatTallies<'a> {
    /// Counts the results of a report. A case counts once for each section of its clauses.
    pub(super) fn new(report: &'a Report, texts: &SuiteTexts) -> FormatTallies<'a> {
        let mut tallies = FormatTallies {
            by_section: BTreeMap::new(),
            by_format: BTreeMap::new(),
        };
        for case in &report.cases {
            let Some(&format) = texts.formats.get(&case.id) else {
                continue;
            };
            let sections: BTreeSet<&str> = case.clauses.iter().map(|id| section_of(id)).collect();
            for section in sections {
                tallies
                    .by_section
                    .entry((section, format))
                    .or_default()
                    .add(case.outcome);
            }
            tallies
                .by_format
                .entry(format)
                .or_default()
                .add(case.outcome);
        }
        tallies
    }

    /// Returns the results for a format.
    pub(super) fn of_format(&self, format: &str) -> ClauseTally {
        self.by_format.get(format).copied().unwrap_or_default()
    }

    /// Renders the sections as rows and the formats as columns.
    pub(super) fn markup(&self) -> Markup {
        let sections: BTreeSet<&str> = self.by_section.keys().map(|key| key.0).collect();
        html! {
            @if !self.by_section.is_empty() {
                div.scroll tabindex="0" {
                    table.sections {
                        caption { "Sections of the specification and formats: failed cases, ✓ if all judged cases passed, ? if none was judged, · if there is no case" }
                        thead { tr { th scope="col" { "section" } @for format in Format::ALL { th scope="col" { span { (format.short_name()) } } } } }
                        tbody {
                            @for section in sections {
                                tr {
                                    th scope="row" { (section) }
                                    @for format in Format::ALL.map(Format::short_name) {
                                        (self.by_section.get(&(section, format)).copied().unwrap_or_default().heat_cell(section, format))
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

pub(super) fn tallies(report: &Report) -> BTreeMap<&str, ClauseTally> {
    let cases = report.cases.iter();
    ClauseTally::count(cases.map(|case| (&case.clauses, case.outcome)))
}

pub(super) fn group_by_section(clauses: &[Clause]) -> impl Iterator<Item = (&str, &[Clause])> {
    let sections = clauses.chunk_by(|a, b| section_of(&a.id) == section_of(&b.id));
    sections.map(|clauses| (section_of(&clauses[0].id), clauses))
}

pub(super) fn section(report: &Report, clauses: &[Clause]) -> Markup {
    let tallies = tallies(report);
    let is_misread = |id: &str| {
        let mut causes = report.diagnoses.iter();
        causes.any(|cause| cause.misread_clause() == Some(id))
    };
    html! {
        section aria-labelledby="clauses" {
            h2 #clauses { "Clauses" }
            p {
                "A case may test several clauses, and a failing case counts for each of them. The mark ▸ shows the clause that the diagnosis names. "
                "Select a clause to filter the cases above."
            }
            p.legend {
                span.tile data-state="fail" { "✗" } " a case failed "
                span.tile data-state="pass" { "✓" } " all judged cases passed "
                span.tile data-state="open" { "?" } " no case was judged "
                span.tile data-state="none" { "·" } " not testable"
            }
            div.map {
                @for (section, clauses) in group_by_section(clauses) {
                    div.row {
                        span.section { (section) }
                        div {
                            @for clause in clauses {
                                @let counts = tally(&tallies, clause);
                                @let (state, mark) = counts.state();
                                @let blamed = is_misread(&clause.id);
                                @let ordinal = clause.id.split(['/', '-']).next_back().unwrap_or_default();
                                button.tile type="button" data-state=(state) data-blamed[blamed] data-clause=(clause.id)
                                    title={ (clause.id) ": " (clause.rule) " " (counts.passed) " passed, " (counts.failed) " failed." }
                                    aria-label={ "clause " (clause.id) ": " (counts.passed) " passed, " (counts.failed) " failed" } {
                                    @if blamed { "▸" } (mark) small { (ordinal) }
                                }
                            }
                        }
                    }
                }
            }
            (table(report.suite, clauses, &tallies))
        }
    }
}

fn table(suite: SuiteName, clauses: &[Clause], tallies: &BTreeMap<&str, ClauseTally>) -> Markup {
    html! {
        details.others {
            summary { "All clauses and their rules" }
            table.list.rules {
                thead { tr { th scope="col" { "clause" } th scope="col" { "result" } th.number scope="col" { "passed" } th.number scope="col" { "failed" } th.number scope="col" { "open" } th scope="col" { "rule" } } }
                tbody {
                    @for clause in clauses {
                        @let counts = tally(tallies, clause);
                        @let (state, mark) = counts.state();
                        tr {
                            td { (link(suite.clause_page(&clause.id), &html! { code { (clause.id) } })) }
                            td data-state=(state) { (mark) " " (result(state, clause.status)) }
                            td.number { (counts.passed) } td.number { (counts.failed) } td.number { (counts.open) }
                            td { (clause.rule) }
                        }
                    }
                }
            }
        }
    }
}

fn tally(tallies: &BTreeMap<&str, ClauseTally>, clause: &Clause) -> ClauseTally {
    tallies.get(clause.id.as_str()).copied().unwrap_or_default()
}

fn result(state: &'static str, status: ClauseStatus) -> &'static str {
    match (state, status) {
        ("none", ClauseStatus::Informative) => "informative",
        ("none", ClauseStatus::Untestable) => "untestable",
        ("none", _) => "not selected",
        ("open", _) => "nothing judged",
        (state, _) => state,
    }
}
