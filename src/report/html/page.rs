//! The page of one report.

use std::collections::HashMap;

use maud::{Markup, html};

use crate::report::document::{CaseResult, LikelyCause, Report, SuiteName};
use crate::report::html::clause_map;
use crate::report::html::evidence::standard_error;
use crate::report::html::shell::{mark, verdict_mark, whole};
use crate::report::reported::Reported;
use crate::report::words::known_words;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::session::scores::Fraction;
use crate::suite::cases::Suite;
use crate::suite::clauses::Clause;

/// Bytes of markup that the evidence of all failing cases may take together: pictures, excerpts, previews and standard
/// error. What does not fit is left out, and the page says so.
pub const EVIDENCE: usize = 3_500_000;

/// Cases of a group that are there without being asked for.
const SHOWN: usize = 12;

/// The page of a report; with the pictures of `run`, where the run is at hand.
///
/// # Errors
/// None that a report can cause.
pub fn page<C: Reported>(
    suite: &Suite<C>,
    report: &Report,
    run: Option<&Run<C>>,
) -> Result<String, String> {
    let clauses = C::all_clauses()?;
    let groups = groups(report);
    let evidence = evidence(suite, run, &groups);
    let title = format!(
        "{}: {} — {}",
        report.decoder.command,
        report.verdict,
        report.suite.short()
    );
    let body = html! {
        (header(suite, report))
        main {
            (diagnosis(report, &groups, &clauses))
            (failures(suite, report, &groups, run.is_some(), &evidence))
            (clause_map::section(report, &clauses))
            (dialect::<C>(report)?)
            (others(report))
            (about(report))
        }
    };
    Ok(whole(&title, &body))
}

/// Failing cases under the cause that explains them, the unexplained ones last.
struct Group<'a> {
    /// What was asked: of a decoder, or of a writer.
    suite: SuiteName,
    cause: Option<&'a LikelyCause>,
    cases: Vec<&'a CaseResult>,
}

impl Group<'_> {
    fn heading(&self) -> String {
        self.cause.map_or_else(
            || "Unexplained failures".to_owned(),
            |cause| format!("The {} {}", self.suite.subject(), cause.effect),
        )
    }

    fn anchor(&self) -> String {
        self.cause.map_or_else(
            || "cases-unexplained".to_owned(),
            // Two causes of one kind may misread different clauses.
            |cause| format!("cases-{}-{}", cause.name(), cause.clause.replace('/', "-")),
        )
    }
}

fn groups(report: &Report) -> Vec<Group<'_>> {
    let place = |case: &CaseResult| {
        let cause = report.cause_of(case);
        let mut causes = report.diagnoses.iter();
        let place = cause.and_then(|cause| causes.position(|other| other == cause));
        place.unwrap_or(report.diagnoses.len())
    };
    let causes = report.diagnoses.iter().map(Some).chain([None]);
    let mut groups: Vec<Group> = causes
        .map(|cause| Group {
            suite: report.suite,
            cause,
            cases: Vec::new(),
        })
        .collect();
    for case in report.cases.iter().filter(|case| failed(case)) {
        groups[place(case)].cases.push(case);
    }
    groups.retain(|group| !group.cases.is_empty());
    groups
}

fn failed(case: &CaseResult) -> bool {
    case.outcome == Outcome::Fail.name()
}

/// What there is to see of each failing case, as far as the allowance goes: the first of every group, then the second.
fn evidence<'a, C: Reported>(
    suite: &Suite<C>,
    run: Option<&Run<C>>,
    groups: &[Group<'a>],
) -> HashMap<&'a str, Markup> {
    let Some(run) = run else {
        return HashMap::new();
    };
    let places: HashMap<&str, usize> = suite
        .cases
        .iter()
        .enumerate()
        .map(|(i, case)| (case.id(), i))
        .collect();
    let longest = groups.iter().map(|group| group.cases.len()).max();
    let in_turn = (0..longest.unwrap_or_default())
        .flat_map(|rank| groups.iter().filter_map(move |group| group.cases.get(rank)));
    let mut left = EVIDENCE;
    let mut evidence = HashMap::new();
    for case in in_turn {
        let shown = places.get(case.id.as_str()).and_then(|&i| {
            let observation = run.observations[i].as_ref()?;
            Some(suite.cases[i].evidence(run.table, observation))
        });
        let Some(shown) = shown else { continue };
        let Some(rest) = left.checked_sub(shown.0.len()) else {
            break;
        };
        left = rest;
        evidence.insert(case.id.as_str(), shown);
    }
    evidence
}

fn header<C: Reported>(suite: &Suite<C>, report: &Report) -> Markup {
    let of = report.cases.len();
    let count = |outcome: Outcome| {
        report
            .cases
            .iter()
            .filter(|case| case.outcome == outcome.name())
            .count()
    };
    html! {
        header.top {
            div.bar {
                span.brand { "ptm-conform " span { (report.tool.version) } }
                button #theme type="button" aria-pressed="false" title="Dark or light" { "◐ " span { "Dark or light" } }
            }
            p.kicker { (report.suite.title()) }
            @if let Some(name) = &report.decoder.name {
                p.kicker { (name) @if let Some(version) = &report.decoder.version { " " (version) } ", asked as" }
            }
            h1 {
                code { (report.decoder.command) }
                " "
                span.verdict data-verdict=(report.verdict) { (verdict_mark(&report.verdict)) " " (report.verdict) }
            }
            @if let Some(reason) = &report.reason {
                pre.reason tabindex="0" { (reason) }
            }
            @for remark in &report.remarks {
                p.remark data-failure[remark.failure] { b { @if remark.failure { "✗ Fails: " } @else { "Note: " } } (remark.says) }
            }
            dl.scores {
                (score("Correctness", report.scores.correctness, "cases passed, of those judged among what it supports"))
                (score("Breadth", report.scores.breadth, "features decoded, of those in the suite"))
                (score("Robustness", report.scores.robustness, "calls that ended in a picture or a refusal"))
            }
            p.counts {
                @for outcome in Outcome::ALL {
                    @if count(outcome) > 0 { span.outcome data-outcome=(outcome.name()) { (mark(outcome.name())) " " (count(outcome)) " " (outcome.name()) } " " }
                }
                @if let Some(news) = &report.baseline {
                    span.quiet { "of the failures " (news.known.len()) " known, " (news.new.len()) " new; " (news.stale.len()) " fixed" } " "
                }
                @if of < suite.cases.len() { span.quiet { (of) " of " (suite.cases.len()) " cases were selected" } }
            }
        }
    }
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

fn diagnosis(report: &Report, groups: &[Group], clauses: &[Clause]) -> Markup {
    let failures = report.cases.iter().filter(|case| failed(case)).count();
    html! {
        section #main tabindex="-1" aria-labelledby="diagnosis" {
            h2 #diagnosis { "Diagnosis" }
            @if failures == 0 {
                p.lead {
                    @if report.verdict == "pass" { "All judged cases passed." }
                    @else { "No case failed, but the run does not count as passed: see the cases below." }
                }
            }
            @for group in groups {
                @match group.cause {
                    Some(cause) => (diagnosed(cause, group, failures, clauses)),
                    None => article.cause.unexplained {
                        p.share { b { (group.cases.len()) } " of " (failures) " failures" }
                        div {
                            h3 { "Unexplained failures" }
                            p { a href={ "#" (group.anchor()) } { "See them" } ", in the order of the text." }
                        }
                    },
                }
            }
        }
    }
}

fn diagnosed(cause: &LikelyCause, group: &Group, failures: usize, clauses: &[Clause]) -> Markup {
    let rule = clauses.iter().find(|clause| clause.id == cause.clause);
    let subject = group.suite.subject();
    html! {
        article.cause {
            p.share { b { (cause.explains.len()) } " of " (failures) " failures" }
            div {
                h3 { "The " (subject) " " (cause.effect) "." }
                p.fix { b { "Fix: " } (cause.fix) "." }
                @if cause.blames_its_clause() {
                    p.rule {
                        b { "Clause " (cause.clause) } @if let Some(rule) = rule { ": " (rule.rule) }
                    }
                }
                @for (slug, other) in known_words(group.suite, &cause.or).take(3) {
                    p { "Or, which fails the same cases: it " (other.effect) " (clause " (other.clause) "; " code { (slug) } ")." }
                }
                @for (slug, other) in known_words(group.suite, &cause.with) {
                    p { "In some of them also: it " (other.effect) " (" code { (slug) } ")." }
                }
                @if !cause.partly.is_empty() {
                    p { (cause.partly.len()) " more in part: it goes wrong there too, but not in just this way." }
                }
                @if let Some(passing) = cause.except.first() {
                    p { "But not everywhere: " (cause.except.len()) " cases pass that such a " (subject) " would fail, for example " code { (passing) } "." }
                }
                @if let Some(shows) = &cause.shows { p { "All that shows of it: the " (subject) " " (shows) ". Other causes would show alike." } }
                @if let Some(example) = &cause.example { p { "For example " (example.strip_prefix("for example ").unwrap_or(example).trim_end_matches('.')) "." } }
                p.quiet {
                    a href={ "#" (group.anchor()) } { "See the cases" }
                    @if let Some(slug) = &cause.misreading { " · " code { "ptm-conform explain " (slug) } }
                }
            }
        }
    }
}

fn failures<C: Reported>(
    suite: &Suite<C>,
    report: &Report,
    groups: &[Group],
    pictures: bool,
    evidence: &HashMap<&str, Markup>,
) -> Markup {
    let failures = groups.iter().map(|group| group.cases.len()).sum::<usize>();
    html! {
        section aria-labelledby="cases" {
            h2 #cases { "Cases" }
            form.tools role="search" {
                label for="filter" { "Filter" }
                input #filter type="search" placeholder="an id, a clause such as 2.4/8, a word" autocomplete="off" spellcheck="false";
                span #found role="status" aria-live="polite" { (report.cases.len()) " cases" }
                button #open type="button" { "Open all" }
                button #close type="button" { "Close all" }
            }
            @if failures > 0 && !pictures {
                p.note { "Made from a report in YAML, which holds no pictures; “ptm-conform check --html” makes a page that does." }
            } @else if evidence.len() < failures {
                p.note {
                    "Pictures and bytes are shown for " (evidence.len()) " of " (failures)
                    " failures, the first of each cause before the second: a page holds " (EVIDENCE / 1000) " kB of them."
                }
            }
            @for (i, group) in groups.iter().enumerate() {
                section.group id=(group.anchor()) aria-label=(group.heading()) {
                    h3 { (group.heading()) " " span.quiet { (group.cases.len()) } }
                    @let (first, more) = group.cases.split_at(SHOWN.min(group.cases.len()));
                    @for (j, case) in first.iter().enumerate() {
                        (card(suite, case, report.is_known(case), evidence.get(case.id.as_str()), i == 0 && j == 0))
                    }
                    @if !more.is_empty() {
                        details.more {
                            summary { (more.len()) " more" }
                            @for case in more { (card(suite, case, report.is_known(case), evidence.get(case.id.as_str()), false)) }
                        }
                    }
                }
            }
        }
    }
}

/// A failing case.
fn card<C: Reported>(
    suite: &Suite<C>,
    case: &CaseResult,
    known: bool,
    evidence: Option<&Markup>,
    open: bool,
) -> Markup {
    let says = case.says.as_deref().unwrap_or_default();
    // Of a difference the end says how much of the picture it is; the evidence shows the texel.
    let short = says.rsplit("; ").next().unwrap_or_default();
    let long = match (evidence, says.split_once("texel (")) {
        (Some(_), Some((before, _))) => format!("{before}{short}"),
        _ => says.to_owned(),
    };
    html! {
        details.case id={ "case-" (case.id) } open[open] {
            summary {
                span.mark aria-label="fail" { (mark("fail")) }
                code { (case.id) }
                span.clauses { (case.clauses.join(" ")) }
                span.says { @if known { "known: " } (short) }
            }
            div.body {
                @if let Some(known) = suite.case(&case.id) { p.because { (known.because()) } }
                p.clauses { "Clauses " (case.clauses.join(", ")) }
                p {
                    "Asked for " code { (case.view.as_deref().unwrap_or("nothing")) } ", expected: " (case.expect) ". Result: "
                    (long) "."
                }
                @match evidence {
                    Some(evidence) => (evidence),
                    None => @if let Some(stderr) = &case.stderr { (standard_error(stderr)) },
                }
                p.quiet { code { "ptm-conform explain " (case.id) } }
            }
        }
    }
}

/// Everything that did not fail, outcome after outcome.
fn others(report: &Report) -> Markup {
    html! {
        section aria-labelledby="others" {
            h2 #others { "All other cases" }
            @for outcome in Outcome::ALL {
                @let cases: Vec<&CaseResult> = report.cases.iter().filter(|case| case.outcome == outcome.name()).collect();
                @if outcome != Outcome::Fail && !cases.is_empty() {
                    details.others {
                        summary { span.mark { (mark(outcome.name())) } " " (cases.len()) " " (outcome.name()) }
                        table.list {
                            thead { tr { th scope="col" { "case" } th scope="col" { "view" } th scope="col" { "expected" } th scope="col" { "clauses" } th scope="col" { "remark" } } }
                            tbody {
                                @for case in cases {
                                    tr { td { code { (case.id) } } td { (case.view.as_deref().unwrap_or("–")) } td { (case.expect) @if case.weak { ", weakly" } } td { (case.clauses.join(" ")) } td { (case.says.as_deref().unwrap_or_default()) } }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// How the decoder reads what the text leaves open, and what it decodes at all.
fn dialect<C: Reported>(report: &Report) -> Result<Markup, String> {
    let rulings = C::all_rulings()?;
    Ok(html! {
        section aria-labelledby="dialect" {
            h2 #dialect { "Dialect and breadth" }
            p { "Where the text leaves a value open, each of these readings is right, if it is followed throughout." }
            @if report.dialect.is_empty() { p.quiet { "No case showed any of them." } } @else {
                table.list {
                    thead { tr { th scope="col" { "ruling" } th scope="col" { "the question" } th scope="col" { "this decoder" } } }
                    tbody {
                        @for known in &report.dialect {
                            tr {
                                td { code { (known.ruling) } }
                                td { (rulings.iter().find(|ruling| ruling.id == known.ruling).map(|ruling| ruling.question.trim()).unwrap_or_default()) }
                                td { (known.reading) }
                            }
                        }
                    }
                }
            }
            ul.features {
                @for feature in &report.decoder.decodes { li { span.mark { (mark("pass")) } " " (feature) } }
                @for feature in &report.decoder.unsupported { li.absent { span.mark { (mark("unsupported")) } " " (feature) " " small { "unsupported, as it says itself" } } }
            }
            p.quiet { "Views offered: " (report.decoder.views.join(", ")) }
        }
    })
}

fn about(report: &Report) -> Markup {
    html! {
        footer {
            p {
                (report.tool.name) " " (report.tool.version) ". Digest of the suite's files: "
                code.digest { (report.tool.corpus) }
            }
            ul { @for limit in &report.tool.limits { li { (limit) } } }
            p { "A case, clause, ruling or misreading is explained by " code { "ptm-conform explain ID" } "." }
        }
    }
}
