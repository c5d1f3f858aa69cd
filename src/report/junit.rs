//! The report as `JUnit` XML, for tools that read test results.
//!
//! A failed case is a failure and a case that was not run is an error; a problem of the whole run is a failure, too. Skipped
//! are outcomes without evidence: unsupported, inconclusive, another dialect, not judged, assumed, a known failure; and a
//! lenient case that was answered in one of its right ways, because more than one is right.

use quick_junit::{NonSuccessKind, TestCase, TestCaseStatus, TestSuite};

use crate::report::document::{CaseResult, Report, section_of};
use crate::session::outcome::Outcome;
use crate::suite::cases::Expect;

/// Returns the XML, one test case for each case of `report`, under the section of its first clause.
///
/// # Errors
/// No error that depends on the report.
pub fn junit(report: &Report) -> Result<String, String> {
    let mut suite = TestSuite::new(report.decoder.command.as_str());
    let scores = [
        ("correctness", report.scores.correctness.to_string()),
        ("breadth", report.scores.breadth.to_string()),
        ("robustness", report.scores.robustness.to_string()),
        ("verdict", report.verdict.clone()),
    ];
    for (name, value) in scores {
        suite.add_property((name, value.as_str()));
    }
    if let Some(reason) = &report.reason {
        let mut status = not_passed(NonSuccessKind::Error, &report.verdict);
        status.set_description(reason);
        let mut case = TestCase::new("first-files", status);
        case.set_classname("ptm-conform");
        suite.add_test_case(case);
    }
    let failures = report.remarks.iter().filter(|remark| remark.failure);
    for (number, remark) in (1..).zip(failures) {
        let status = not_passed(NonSuccessKind::Failure, &remark.says);
        let mut case = TestCase::new(format!("whole-run-{number}"), status);
        case.set_classname("ptm-conform");
        suite.add_test_case(case);
    }
    suite.add_test_cases(report.cases.iter().map(|case| test_case(report, case)));
    let mut junit = quick_junit::Report::new("ptm-conform");
    junit.add_test_suite(suite);
    junit.to_string().map_err(|error| error.to_string())
}

fn test_case(report: &Report, case: &CaseResult) -> TestCase {
    let mut junit = TestCase::new(case.id.as_str(), status(report, case));
    // A dot would separate packages.
    let section = case.clauses.first().map_or("none", |id| section_of(id));
    let section = section.replace('.', "_");
    junit.set_classname(format!("ptm-conform.section-{section}"));
    if !case.stderr.is_empty() {
        junit.set_system_err(&case.stderr);
    }
    junit
}

fn status(report: &Report, case: &CaseResult) -> TestCaseStatus {
    let says = match case.says.as_str() {
        "" => case.outcome.name(),
        says => says,
    };
    match case.outcome {
        _ if report.is_known(case) => skipped(&format!("known failure: {says}")),
        Outcome::Fail => {
            let mut status = not_passed(NonSuccessKind::Failure, says);
            status.set_type(format!("clause {}", case.clauses.join(", ")));
            if let Some(cause) = report.cause_of(case) {
                let subject = report.suite.subject();
                let (effect, clause, fix) = (&cause.effect, &cause.clause, &cause.fix);
                let says = format!("The {subject} {effect} (clause {clause}). Fix: {fix}.");
                status.set_description(says);
            }
            status
        }
        Outcome::NotRun => not_passed(NonSuccessKind::Error, &format!("not run: {says}")),
        Outcome::Pass if case.expect == Expect::Lenient.name() => {
            skipped("lenient: more than one answer is right, and this was one of them")
        }
        Outcome::Pass => TestCaseStatus::success(),
        _ => skipped(says),
    }
}

fn not_passed(kind: NonSuccessKind, message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(kind);
    status.set_message(message);
    status
}

fn skipped(message: &str) -> TestCaseStatus {
    let mut status = TestCaseStatus::skipped();
    status.set_message(message);
    status
}
