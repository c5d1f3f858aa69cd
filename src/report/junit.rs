//! The report as `JUnit` XML, for tools that read test results.
//!
//! A failed case is a failure, and a case that was not run is an error. A problem of the whole run is also a failure. Known
//! failures and cases without evidence (unsupported, inconclusive, another dialect, not judged, assumed) are skipped.

use maud::{Markup, PreEscaped, html};

use crate::report::document::{CaseResult, Report};
use crate::session::outcome::Outcome;
use crate::suite::clauses::section_of;

/// XML element of a test that did not pass: its name, attributes and content.
struct NotPassed {
    element: &'static str,
    message: String,
    clauses: String,
    text: String,
}

/// Class, name, status (`None` if the test passed) and standard error of a test.
type Test<'a> = (String, String, Option<NotPassed>, &'a str);

/// Returns the problems of the whole run and all cases as tests. The class of a case is the section of its first clause.
fn tests(report: &Report) -> Vec<Test<'_>> {
    let whole_run = |element, name: String, message: &str, text: &str| -> Test<'_> {
        let (message, text) = (message.to_owned(), text.to_owned());
        let status = NotPassed {
            element,
            message,
            clauses: String::new(),
            text,
        };
        ("ptm-conform".to_owned(), name, Some(status), "")
    };
    let reason = report.reason.iter();
    let mut tests: Vec<_> = reason
        .map(|reason| whole_run("error", "first-files".into(), &report.verdict, reason))
        .collect();
    let failures = report.remarks.iter().filter(|remark| remark.failure);
    for (number, remark) in (1..).zip(failures) {
        let name = format!("whole-run-{number}");
        tests.push(whole_run("failure", name, &remark.says, ""));
    }
    tests.extend(report.cases.iter().map(|case| {
        // A dot would separate packages.
        let section = case.clauses.first().map_or("none", |id| section_of(id));
        let class = format!("ptm-conform.section-{}", section.replace('.', "_"));
        let status = case_status(report, case);
        (class, case.id.clone(), status, &*case.stderr)
    }));
    tests
}

/// Renders a report as `JUnit` XML.
#[must_use]
pub fn junit(report: &Report) -> String {
    let tests = tests(report);
    let [failures, errors, skipped] = ["failure", "error", "skipped"].map(|element| {
        let statuses = tests.iter().filter_map(|test| test.2.as_ref());
        statuses.filter(|status| status.element == element).count()
    });
    let scores = [
        ("correctness", report.scores.correctness.to_string()),
        ("breadth", report.scores.breadth.to_string()),
        ("robustness", report.scores.robustness.to_string()),
        ("verdict", report.verdict.clone()),
    ];
    let xml = html! {
        (PreEscaped("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"))
        testsuites name="ptm-conform" tests=(tests.len()) failures=(failures) errors=(errors) {
            testsuite name=(report.decoder.command) tests=(tests.len()) failures=(failures) errors=(errors) skipped=(skipped) {
                properties {
                    @for (name, value) in &scores { property name=(name) value=(value) {} }
                }
                @for (class, name, not_passed, stderr) in &tests {
                    "\n"
                    testcase classname=(class) name=(name) {
                        @if let Some(status) = not_passed { (render_status(status)) }
                        @if !stderr.is_empty() { system-err { (stderr) } }
                    }
                }
            }
        }
    };
    // XML allows no other control characters, not even escaped ones.
    let allowed = |c: char| !c.is_control() || matches!(c, '\n' | '\r' | '\t');
    xml.0.replace(
        |c| !allowed(c) || c == '\u{fffe}' || c == '\u{ffff}',
        "\u{fffd}",
    )
}

/// Returns the status of a case, or `None` if the case passed.
fn case_status(report: &Report, case: &CaseResult) -> Option<NotPassed> {
    let says = match case.says.as_str() {
        "" => case.outcome.name(),
        says => says,
    };
    let (element, message) = match case.outcome {
        _ if report.is_known(case) => ("skipped", format!("known failure: {says}")),
        Outcome::Pass => return None,
        Outcome::Fail => ("failure", says.to_owned()),
        Outcome::NotRun => ("error", format!("not run: {says}")),
        _ => ("skipped", says.to_owned()),
    };
    let cause = report.cause_of(case).filter(|_| element == "failure");
    let text = cause.map_or_else(String::new, |cause| {
        let subject = report.suite.subject();
        let (effect, clause, fix) = (&cause.effect, &cause.clause, &cause.fix);
        format!("The {subject} {effect} (clause {clause}). Fix: {fix}.")
    });
    Some(NotPassed {
        element,
        message,
        clauses: case.clauses.join(", "),
        text,
    })
}

/// Renders the XML element of a status.
fn render_status(
    NotPassed {
        element,
        message,
        clauses,
        text,
    }: &NotPassed,
) -> Markup {
    match *element {
        "failure" => {
            html! { failure message=(message) type=[(!clauses.is_empty()).then(|| format!("clause {clauses}"))] { (text) } }
        }
        "error" => html! { error message=(message) { (text) } },
        _ => html! { skipped message=(message) {} },
    }
}
