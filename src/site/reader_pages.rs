//! Pages for public readers: results of a run of the suite, and known mistakes.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::objects::{self, ShownReader};
use super::page::{PageContext, SiteFile};
use super::readers::ReaderRun;
use crate::report::html::ClauseTally;
use ptm::Format;
use ptm_files::readers::{Evidence, ReaderProfile, profiles};
use ptm_mistakes::Misreading;
use ptm_suite::cases::Case;
use ptm_suite::clauses::Clause;

/// Number of cases per outcome that are initially visible.
const INITIALLY_VISIBLE_CASES: usize = 20;

fn tallies<'a>(context: PageContext<'a>, run: &ReaderRun) -> BTreeMap<&'a str, ClauseTally> {
    let cases = context.library.suite.cases.iter();
    ClauseTally::count(cases.map(|case| (&case.clauses, run.outcome(&case.id))))
}

/// Renders the list of readers and the page of each reader.
pub(super) fn pages(context: PageContext) -> Vec<SiteFile> {
    let readers = context.library.readers().into_iter();
    let pages = readers.map(|reader| page(context, reader));
    std::iter::once(list(context)).chain(pages).collect()
}

/// Returns the mistakes of a reader: first those in its profile, then other sightings.
fn mistakes(reader: &str) -> Vec<&'static Misreading> {
    let mut mistakes = behaviors(reader);
    mistakes.retain(|behavior| behavior.reading_of.is_none());
    mistakes
}

/// Returns the mistakes of a reader, and its readings of open questions.
fn behaviors(reader: &str) -> Vec<&'static Misreading> {
    let profiled = profile(reader).map_or(&[][..], |profile| &profile.misreadings);
    let profiled = profiled.iter().map(|known| ptm_mistakes::find(&known.slug));
    let mut mistakes: Vec<&Misreading> = profiled.flatten().collect();
    for misreading in ptm_mistakes::behaviors() {
        let mut seen = misreading.sightings.iter();
        let is_seen = seen.any(|sighting| sighting.reader == reader);
        if is_seen && !mistakes.iter().any(|known| known.slug == misreading.slug) {
            mistakes.push(misreading);
        }
    }
    mistakes
}

/// Returns the reader with its known behavior. If its formats are not known, it is assumed to support all of them.
pub(super) fn shown_reader(reader: &str) -> ShownReader {
    let mut formats = Format::ALL.to_vec();
    if let Some(profile) = profile(reader) {
        formats.retain(|format| {
            profile
                .formats
                .iter()
                .any(|name| name == format.short_name())
        });
    }
    ShownReader {
        name: reader.to_owned(),
        behaviors: behaviors(reader),
        formats,
    }
}

/// Returns the run of the suite against a reader, if there is one.
fn find_run<'a>(context: PageContext<'a>, reader: &str) -> Option<&'a ReaderRun> {
    context.library.runs.iter().find(|run| run.reader == reader)
}

fn profile(reader: &str) -> Option<&'static ReaderProfile> {
    profiles().iter().find(|profile| profile.reader == reader)
}

fn list(context: PageContext) -> SiteFile {
    let body = html! {
        p.lead { "These public programs read PTM files. The suite was run on some of them. The entries for the others are based on their source code. "
            a href="../scoreboard.html" { "The scoreboard" } " compares the runs clause by clause." }
        div.scroll tabindex="0" { table.list {
            thead { tr { th scope="col" { "reader" } th scope="col" { "run" } th scope="col" { "formats" } th scope="col" { "known mistakes" } } }
            tbody { @for reader in context.library.readers() {
                @let run = find_run(context, reader);
                tr {
                    td { (context.link_as(reader, &html! { (reader) })) }
                    td { @if let Some(run) = run { (run.dated_version()) } @else { "–" } }
                    td { @if let Some(profile) = profile(reader) { (profile.formats.join(", ")) } @else { "–" } }
                    td { (mistakes(reader).len()) }
                }
            } }
        } }
    };
    context.list("Readers", &body)
}

fn page(context: PageContext, reader: &str) -> SiteFile {
    let run = find_run(context, reader);
    let mistakes = mistakes(reader);
    let readings: Vec<_> = (behaviors(reader).into_iter())
        .filter_map(|behavior| Some((behavior, behavior.reading_of?)))
        .collect();
    let body = html! {
        h1 { (reader) }
        @if let Some(object) = objects::reader(context, reader) { (object) }
        @if let Some(run) = run { (run_facts(context, run)) }
        @else { p { "The suite was not run on this reader. This page is based on its source code." } }
        @if !mistakes.is_empty() {
            h2 { "Known mistakes" }
            ul { @for misreading in mistakes {
                li { (context.link(misreading.slug)) ", clause " (context.link_as(misreading.clause, &html! { (misreading.clause) })) ": the reader " (misreading.effect) "." }
            } }
        }
        @if !readings.is_empty() {
            h2 { "Readings of open questions" }
            p { "These are no mistakes: the rulings allow them." }
            ul { @for (behavior, ruling) in readings {
                li { "The reader " (behavior.effect) " (ruling " (context.link(ruling)) ")." }
            } }
        }
        @if let Some(profile) = profile(reader) { (render_profile(profile)) }
        @if let Some(run) = run { (run_results(context, run)) }
    };
    context.entry("Readers", reader, reader, &body)
}

/// Renders the formats and limits of a reader, with the evidence for them.
fn render_profile(profile: &ReaderProfile) -> Markup {
    let basis = |evidence| match evidence {
        Evidence::Run => "based on a run",
        Evidence::Code => "based on the source code",
    };
    html! {
        h2 { "Supported files" }
        dl.facts {
            @if let Some(version) = &profile.version { dt { "Examined version" } dd { (version) } }
            dt { "Formats" } dd { (profile.formats.join(", ")) " (" (basis(profile.evidence)) ")" }
            @if !profile.limits.is_empty() {
                dt { "Limits" } dd { ul.plain { @for known in &profile.limits { li { "The reader " (known.limit.behavior) " (" (basis(known.evidence)) ")." } } } }
            }
            @if !profile.unusual.is_empty() {
                dt { "Files outside the format" } dd { ul.plain { @for row in &profile.unusual { li {
                    "The reader " (row.shows.label()) " files " (row.kind.label())
                    @if !row.formats.is_empty() { " (" (row.formats.join(", ")) ")" }
                    @if !row.fault.is_empty() { ": " (row.fault) }
                    " (" (basis(row.evidence)) ")."
                } } } }
            }
            dt { "Prediction" } dd { code { "ptm-conform lint --for " (profile.name) " FILE" } " predicts the reader's output for a file." }
        }
    }
}

/// Renders what was run, when, and how it ended.
fn run_facts(context: PageContext, run: &ReaderRun) -> Markup {
    html! {
        dl.facts {
            dt { "Source" } dd { a href=(run.source) { (run.source) } " (" (run.language) ")" }
            dt { "Version" } dd { (run.dated_version()) }
            dt { "Run" } dd { (run.run_date) ", " (run.command) "; judged by suite " (run.suite) " (" (run.cases) " cases)" }
            dt { "Views" } dd { (run.views.join(", ")) }
            dt { "Outcomes" } dd { (run.counts()) }
        }
        @for remark in &run.remarks { p.note { (context.prose(remark)) } }
    }
}

/// Renders the clauses with failing cases, and all cases by outcome.
fn run_results(context: PageContext, run: &ReaderRun) -> Markup {
    let tallies = tallies(context, run);
    let failing = |clause: &&Clause| {
        let tally = tallies.get(clause.id.as_str());
        tally.is_some_and(|tally| tally.failed > 0)
    };
    let clauses: Vec<&Clause> = context.library.clauses.iter().filter(failing).collect();
    html! {
        h2 { "Clauses with failing cases" }
        @if clauses.is_empty() { p { "None." } }
        ul { @for clause in clauses {
            @let tally = tallies[clause.id.as_str()];
            li { (context.link_as(&clause.id, &html! { (clause.id) })) " " (clause.rule) " " span.quiet { (tally.passed) " of " (tally.passed + tally.failed) " pass" } }
        } }
        h2 { "Cases" }
        @for (outcome, cases) in &run.outcomes {
            details.others { summary { (cases.len()) " " (outcome) } (case_list(context, cases)) }
        }
    }
}

fn case_list(context: PageContext, cases: &[String]) -> Markup {
    let (first, more) = cases.split_at(INITIALLY_VISIBLE_CASES.min(cases.len()));
    html! {
        ul.columns { @for case in first { li { (context.link(case)) } } }
        @if !more.is_empty() { details { summary { (more.len()) " more" } ul.columns { @for case in more { li { (context.link(case)) } } } } }
    }
}

/// Returns the results of a run for the cases that satisfy `is_counted`.
fn total(context: PageContext, run: &ReaderRun, is_counted: impl Fn(&Case) -> bool) -> ClauseTally {
    let mut tally = ClauseTally::default();
    for case in context
        .library
        .suite
        .cases
        .iter()
        .filter(|case| is_counted(case))
    {
        tally.add(run.outcome(&case.id));
    }
    tally
}

/// Renders the table of readers and clauses.
pub(super) fn scoreboard(context: PageContext) -> SiteFile {
    let runs = &context.library.runs;
    let all: Vec<_> = runs.iter().map(|run| tallies(context, run)).collect();
    let tally = |index: usize, clause: &str| all[index].get(clause).copied().unwrap_or_default();
    let tested = |clause: &&Clause| {
        (0..runs.len()).any(|index| tally(index, &clause.id) != ClauseTally::default())
    };
    let differs = |clause: &Clause| {
        let mut states = (0..runs.len()).map(|index| tally(index, &clause.id).state());
        let first = states.next();
        states.any(|state| Some(state) != first)
    };
    let body = html! {
        h1 { "Scoreboard" }
        p.lead { "For each clause, the table shows how many of the judged cases each public reader passes; the stronger the red of a cell, the larger the share of failures. A case may test several clauses, so one mistake can appear in several rows; "
            "each reader's page lists its known mistakes." }
        p.legend {
            span.tile data-state="fail" { "✗" } " at least one case failed "
            span.tile data-state="pass" { "✓" } " all judged cases passed "
            span.tile data-state="open" { "?" } " no case was judged (all were unsupported, inconclusive or not run)"
        }
        form.tools {
            label for="list-filter" { "Filter" }
            input #list-filter type="search" placeholder="a clause or a word" autocomplete="off" spellcheck="false";
            label.check { input #differing type="checkbox"; " only clauses on which readers differ" }
            span #list-found role="status" aria-live="polite" {}
        }
        div.scroll.tall tabindex="0" { table.matrix.scoreboard.filtered {
            thead { tr {
                th scope="col" { "clause" }
                @for run in runs {
                    th scope="col" title={ (run.dated_version()) ", run " (run.run_date) ", suite " (run.suite) } { span { (context.link_as(&run.reader, &html! { (run.reader) })) } }
                }
            } }
            tbody {
                tr.total { th scope="row" { "all cases" } @for run in runs { (total(context, run, |_| true).share_cell()) } }
                @for format in Format::ALL {
                    tr.total { th scope="row" { (format.short_name()) } @for run in runs { (total(context, run, |case| case.format() == format).share_cell()) } }
                }
            }
            tbody { @for clause in context.library.clauses.iter().filter(tested) {
                tr data-same[!differs(clause)] {
                    th scope="row" { (context.link_as(&clause.id, &html! { code { (clause.id) } })) " " span.rule { (clause.rule) } }
                    @for index in 0..runs.len() { (tally(index, &clause.id).share_cell()) }
                }
            } }
        } }
    };
    context.page("scoreboard.html", "Scoreboard", "Scoreboard", &body)
}
