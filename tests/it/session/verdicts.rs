//! Verdicts of a run: the table of outcomes, unsupported features, and limits.

use std::time::Duration;

use ptm::Format;
use ptm_conform::report::text::report_to_text;
use ptm_conform::report::{html, junit};
use ptm_harness::pipeline::judge_answers;
use ptm_harness::report::Report;
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::session::run::Run;
use ptm_suite::cases::{Case, Expect, Suite};
use ptm_suite::protocol::frame::{Answer, TimeLimit};
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::verdicts::outcome::{Outcome, ResponseKind, outcome};

use crate::common::repository_text;
use crate::in_process::{self, reference_answer, suite};

/// Runs the suite against a decoder whose answers depend on the case. The answer is correct if `decoder` returns `None`.
fn run(suite: &Suite, plan: &RunPlan, decoder: impl Fn(&Case) -> Option<Answer> + Sync) -> Run {
    in_process::run(suite, plan, |request| {
        let case = suite.case(request.name).expect("the case exists");
        match decoder(case) {
            Some(Answer::TimedOut(usual)) => Answer::TimedOut(request.attempt.time_limit(usual.0)),
            Some(answer) => answer,
            None => reference_answer(request),
        }
    })
}

fn timeout() -> Answer {
    Answer::TimedOut(TimeLimit(Duration::from_secs(10)))
}

fn cases<'a>(suite: &'a Suite, run: &'a Run, outcome: Outcome) -> impl Iterator<Item = &'a Case> {
    run.judgment
        .with_outcome(outcome)
        .map(|place| &suite.cases[place])
}

/// Parses the table of outcomes in a document. Returns the label and the outcomes of each row.
fn table(document: &str) -> Vec<(String, Vec<String>)> {
    let text = repository_text(document);
    let lines = text
        .lines()
        .skip_while(|line| !line.starts_with("| response |"));
    let rows = lines.skip(2).take_while(|line| line.starts_with('|'));
    rows.map(|row| {
        let mut cells = row
            .trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().to_owned());
        (cells.next().expect("a first cell"), cells.collect())
    })
    .collect()
}

#[test]
fn documents_show_the_verdict_table() {
    use Expect::{Decode, ImplementationDefined, Lenient, Refuse, Reject, Spelling};
    use ResponseKind::{Different, Expected, Rejected, Unsupported, Violation};
    let expects = [
        Decode,
        Reject,
        Refuse,
        Lenient,
        Spelling,
        ImplementationDefined,
    ];
    let rows: [(&str, ResponseKind, &[bool]); 7] = [
        ("the expected image", Expected, &[true, false]),
        ("a different image", Different, &[true, false]),
        ("65, features supported", Rejected, &[true]),
        ("69, features supported", Unsupported, &[true]),
        ("65, a feature not supported", Rejected, &[false]),
        ("69, a feature not supported", Unsupported, &[false]),
        (
            "a crash, an exceeded limit, or any other violation",
            Violation,
            &[true, false],
        ),
    ];
    for document in ["docs/protocol.md", "spec-cases/README.md"] {
        let written = table(document);
        assert_eq!(written.len(), rows.len(), "{document}: {written:#?}");
        for ((label, outcomes), (row, response, supported)) in written.iter().zip(rows) {
            assert_eq!(label, row, "{document}");
            for (expect, written) in expects.iter().zip(outcomes) {
                for &is_supported in supported {
                    let expected = outcome(*expect, is_supported, response).name();
                    let has_none = written == "–" && response == Expected;
                    assert!(
                        has_none || written == expected,
                        "{document}: {row}, {expect:?}"
                    );
                }
            }
            assert_eq!(outcomes.len(), expects.len(), "{document}: {row}");
        }
    }
}

#[test]
fn tables_are_unsupported_for_a_decoder_without_tables() {
    let suite = suite();
    let plan = RunPlan::new(&suite, 2);
    let run = run(&suite, &plan, |case| {
        case.format().has_table().then_some(Answer::Unsupported)
    });
    let with_tables = suite.cases.iter().filter(|case| case.format().has_table());
    let ids = cases(&suite, &run, Outcome::Unsupported).map(|case| &case.id);
    let unsupported: Vec<&String> = ids.collect();
    let expected: Vec<&String> = with_tables.map(|case| &case.id).collect();
    assert_eq!(unsupported, expected);
    for expect in [
        Expect::Decode,
        Expect::Reject,
        Expect::Lenient,
        Expect::Spelling,
    ] {
        assert!(cases(&suite, &run, Outcome::Unsupported).any(|case| case.expect == expect));
    }
    let others = suite.cases.len() - unsupported.len();
    assert_eq!(run.judgment.with_outcome(Outcome::Pass).count(), others);
    assert_eq!(run.exit_status(), 0);
}

#[test]
fn refusing_some_tables_passes_no_table_case() {
    let suite = suite();
    let run = run(&suite, &RunPlan::new(&suite, 2), |case| {
        let refused = match case.expect {
            Expect::Decode => Answer::Unsupported,
            _ => Answer::Rejected,
        };
        case.format().has_table().then_some(refused)
    });
    assert!(!cases(&suite, &run, Outcome::Pass).any(|case| case.format().has_table()));
    assert_eq!(run.judgment.with_outcome(Outcome::Fail).count(), 0);
}

#[test]
fn unselected_legal_files_still_decide_support() {
    let suite = suite();
    let cases = suite.cases.iter();
    let selected = cases.map(|case| case.expect == Expect::Spelling);
    let plan = RunPlan {
        selected: selected.collect(),
        ..RunPlan::new(&suite, 2)
    };
    let run = run(&suite, &plan, |case| {
        case.format().has_table().then_some(Answer::Unsupported)
    });
    assert_eq!(run.judgment.with_outcome(Outcome::Pass).count(), 0);
    assert!(run.judgment.with_outcome(Outcome::Unsupported).count() > 0);
}

#[test]
fn unsupported_passes_refuse_and_lenient_cases() {
    let suite = suite();
    let run = run(&suite, &RunPlan::new(&suite, 2), |case| {
        matches!(
            case.expect,
            Expect::Refuse | Expect::Lenient | Expect::Robust
        )
        .then_some(Answer::Unsupported)
    });
    for expect in [Expect::Refuse, Expect::Lenient, Expect::Robust] {
        let of_kind = suite.cases.iter().filter(|case| case.expect == expect);
        let passing = cases(&suite, &run, Outcome::Pass).filter(|case| case.expect == expect);
        assert_eq!(passing.count(), of_kind.count(), "{expect:?}");
    }
    assert_eq!(run.exit_status(), 0);
}

/// Such a case is inconclusive, because a refusal of the file would prove nothing.
#[test]
fn the_right_image_of_a_lenient_file_is_decoded_although_its_twin_is_refused() {
    let suite = suite();
    let run = run(&suite, &RunPlan::new(&suite, 2), |case| {
        (case.expect == Expect::Decode && !case.first).then_some(Answer::Rejected)
    });
    let inconclusive = cases(&suite, &run, Outcome::Inconclusive);
    let is_lenient = |case: &&Case| matches!(case.expect, Expect::Lenient | Expect::Robust);
    assert!(inconclusive.filter(is_lenient).count() > 0);
    let report = Report::new(&suite, &run, &["decoder".to_owned()], Vec::new());
    assert!(report.lenient.iter().all(|counts| counts.other == 0));
}

#[test]
fn timeouts_on_optional_files_do_not_end_a_run() {
    let suite = suite();
    let run = run(&suite, &RunPlan::new(&suite, 3), |case| {
        (case.expect != Expect::Decode && case.expect != Expect::Spelling).then(timeout)
    });
    assert_eq!(run.ended_early, None);
    assert_eq!(run.judgment.with_outcome(Outcome::NotRun).count(), 0);
    let is_slow = |case: &&Case| !matches!(case.expect, Expect::Decode | Expect::Spelling);
    let slow = suite.cases.iter().filter(is_slow);
    assert_eq!(
        run.judgment.with_outcome(Outcome::Fail).count(),
        slow.count()
    );
}

#[test]
fn three_timeouts_end_a_run_for_any_number_of_jobs() {
    let suite = suite();
    let cases = suite.cases.iter().enumerate();
    let legal = cases.filter(|(_, case)| case.expect == Expect::Decode && !case.first);
    let legal: Vec<usize> = legal.map(|(place, _)| place).skip(40).collect();
    let slow = [0, 1, 2].map(|place| &suite.cases[legal[place]].id);
    let reports = [1, 4].map(|jobs| {
        let plan = RunPlan::new(&suite, jobs);
        let run = run(&suite, &plan, |case| slow.contains(&&case.id).then(timeout));
        let not_run: Vec<usize> = run.judgment.with_outcome(Outcome::NotRun).collect();
        assert!(not_run.iter().copied().eq(legal[2] + 1..suite.cases.len()));
        assert_eq!(run.exit_status(), 1);
        let command = ["decoder".to_owned()];
        let report = Report::new(&suite, &run, &command, vec!["none".to_owned()]);
        let xml = junit::junit(&report, None);
        let texts = SuiteTexts::new(&suite).expect("the texts can be read");
        let page = html::page(
            &texts,
            &report,
            &html::Evidence::new(&suite, &run, html::case_evidence),
        );
        let text = report_to_text(&report, &texts, 10);
        for (form, text) in [("text", &text), ("JUnit", &xml), ("HTML", &page)] {
            let why = "the run ended early: the decoder exceeds the time limit of 30 s (`--timeout`) on three legal files in a row; ";
            let count = format!("{} cases were not run", not_run.len());
            assert!(text.contains(&(why.to_owned() + &count)), "{form}: {text}");
        }
        report.to_yaml().expect("YAML")
    });
    assert_eq!(reports[0], reports[1]);
}

#[test]
fn timeout_on_a_first_file_does_not_end_the_run() {
    let suite = suite();
    for format in [Format::Rgb, Format::Lum] {
        let run = run(&suite, &RunPlan::new(&suite, 2), |case| {
            (case.first && case.format() == format).then(timeout)
        });
        assert!(
            run.ended_early.is_none() && run.not_a_decoder.is_none(),
            "{format}"
        );
    }
}

#[test]
fn different_limits_are_not_nondeterminism() {
    let suite = suite();
    let hoards = |case: &Case| case.expect == Expect::Decode && case.id.starts_with("hand-lrgb");
    let plan = RunPlan {
        repeat: Repeat::FailuresAndSample,
        ..RunPlan::new(&suite, 2)
    };
    for served in [false, true] {
        let ask = |request: &Request<'_>, _: usize| {
            let out_of_memory = Answer::OutOfMemory("more than 2048 MiB".to_owned());
            let case = suite.case(request.name).expect("the case exists");
            match hoards(case) {
                true if request.attempt == AttemptKind::Repetition => Reply::from(timeout()),
                true => Reply {
                    serve_mode_answer: served.then(timeout),
                    ..Reply::from(out_of_memory)
                },
                false => Reply::from(reference_answer(request)),
            }
        };
        let run = judge_answers(&suite, &plan, &ask);
        let mut failing = cases(&suite, &run, Outcome::Fail).peekable();
        assert!(failing.peek().is_some() && failing.all(hoards));
        let mut observed = run.observations.iter().flatten();
        assert!(
            observed.all(|seen| seen.nondeterminism.is_none()),
            "{served}"
        );
    }
}
