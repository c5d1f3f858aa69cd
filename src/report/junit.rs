//! Reports as `JUnit` XML, for tools that read test results.
//!
//! A failing case or a problem with the whole run is reported as a failure. A case that was not run, or a program that is not a
//! decoder, is an error. Known failures and cases without evidence, such as unsupported ones, are skipped.

use std::time::Duration;

use maud::{Markup, PreEscaped, html};

use ptm_harness::pipeline::times::Times;
use ptm_harness::report::document::{CaseResult, Report};
use ptm_suite::clauses::section_of;
use ptm_suite::verdicts::outcome::Outcome;

/// Test: its class, its name, the name and markup of its result element (`None` if it passed), and its standard error.
type Test<'a> = (String, String, Option<(&'static str, Markup)>, &'a str);

/// Returns all problems with the whole run, and all cases, as tests. The class of a case is the section of its first clause.
fn tests(report: &Report) -> Vec<Test<'_>> {
    let mut tests = Vec::new();
    let mut add = |name, element| tests.push(("ptm-conform".to_owned(), name, Some(element), ""));
    if let Some(reason) = &report.reason {
        let element = html! { error message=(report.verdict) { (reason) } };
        add("first-files".to_owned(), ("error", element));
    }
    let failures = report.remarks.iter().filter(|remark| remark.failure);
    for (number, remark) in (1..).zip(failures) {
        let element = html! { failure message=(remark.message) {} };
        add(format!("whole-run-{number}"), ("failure", element));
    }
    tests.extend(report.cases.iter().map(|case| {
        // A dot would separate packages.
        let section = case.clauses.first().map_or("none", |id| section_of(id));
        let class = format!("ptm-conform.section-{}", section.replace('.', "_"));
        (class, case.id.clone(), element(report, case), &*case.stderr)
    }));
    tests
}

/// Renders a report as `JUnit` XML, with the start of the run and the times of the cases in seconds if they are known.
#[must_use]
pub fn junit(report: &Report, times: Option<&Times>) -> String {
    let tests = tests(report);
    let [failures, errors, skipped] = ["failure", "error", "skipped"].map(|element| {
        let statuses = tests.iter().filter_map(|test| test.2.as_ref());
        statuses.filter(|status| status.0 == element).count()
    });
    let scores = [
        ("correctness", report.scores.correctness.to_string()),
        ("breadth", report.scores.breadth.to_string()),
        ("robustness", report.scores.robustness.to_string()),
        ("verdict", report.verdict.to_string()),
    ];
    let seconds = |time: Duration| format!("{:.3}", time.as_secs_f64());
    let start = times.map(|times| humantime::format_rfc3339_seconds(times.start).to_string());
    let total = times.map(|times| seconds(times.of_case.values().sum()));
    let time_of = |name: &str| times?.of_case.get(name).copied().map(seconds);
    let xml = html! {
        (PreEscaped("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"))
        testsuites name="ptm-conform" tests=(tests.len()) failures=(failures) errors=(errors) {
            testsuite name=(report.decoder.command) tests=(tests.len()) failures=(failures) errors=(errors) skipped=(skipped) timestamp=[start] time=[total] {
                properties {
                    @for (name, value) in &scores { property name=(name) value=(value) {} }
                }
                @for (class, name, element, stderr) in &tests {
                    "\n"
                    testcase classname=(class) name=(name) time=[time_of(name)] {
                        @if let Some((_, element)) = element { (element) }
                        @if !stderr.is_empty() { system-err { (stderr) } }
                    }
                }
            }
        }
    };
    // XML allows no other control characters, not even escaped ones.
    let allowed = |c: char| !c.is_control() || matches!(c, '\n' | '\r' | '\t');
    let replaced = |c: char| !allowed(c) || matches!(c, '\u{fffe}' | '\u{ffff}');
    xml.0.replace(replaced, "\u{fffd}")
}

/// Returns the name and markup of the result element of a case, or `None` if the case passed.
fn element(report: &Report, case: &CaseResult) -> Option<(&'static str, Markup)> {
    let says = match case.message.as_str() {
        "" => case.outcome.name(),
        says => says,
    };
    Some(match case.outcome {
        _ if report.is_known(case) => {
            let element = html! { skipped message={ "known failure: " (says) } {} };
            ("skipped", element)
        }
        Outcome::Pass => return None,
        Outcome::Fail => {
            let (subject, cause) = (report.suite.subject(), report.cause_of(case));
            let clauses = (!case.clauses.is_empty()).then(|| case.clauses.join(", "));
            let kind = clauses.map(|clauses| format!("clause {clauses}"));
            let element = html! {
                failure message=(says) type=[kind] {
                    @if let Some(cause) = cause { "The " (subject) " " (cause.effect) (cause.clause_text()) ". Fix: " (cause.fix) "." }
                }
            };
            ("failure", element)
        }
        Outcome::NotRun => ("error", html! { error message={ "not run: " (says) } {} }),
        _ => ("skipped", html! { skipped message=(says) {} }),
    })
}
