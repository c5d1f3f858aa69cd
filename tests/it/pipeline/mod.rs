//! The pipeline in this process: what an observer learns, and when.

#![cfg(unix)]

use std::collections::BTreeSet;
use std::sync::Mutex;

use ptm::Format;
use ptm_generate::Compression;
use ptm_harness::pipeline::texture::TextureCheck;
use ptm_harness::pipeline::{
    self, Agenda, Check, Error, FinishedCase, FirstVerdicts, FoundCauses, Observer, Stage, check,
};
use ptm_harness::report::Report;
use ptm_harness::report::baseline::Baseline;
use ptm_harness::report::document::{BaselineComparison, LikelyCause, Verdict};
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::strength::smoke;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::texture::cases::TextureView;
use ptm_suite::verdicts::outcome::Outcome;
use ptm_texture::Rules;

use crate::in_process::{answer_with, jobs, misreading, suite_of_small_files};

/// Keeps everything that happens, except single requests.
#[derive(Default)]
struct Log {
    events: Mutex<Vec<String>>,
    verdicts: Mutex<Option<Report>>,
    /// True if the report with all verdicts cannot be written.
    is_full: bool,
}

impl Log {
    fn add(&self, event: impl Into<String>) {
        let mut events = self.events.lock().expect("no observer panics");
        // Cases and repeats are counted, not listed.
        let event = event.into();
        if events.last() != Some(&event) {
            events.push(event);
        }
    }

    fn events(self) -> Vec<String> {
        self.events.into_inner().expect("no observer panics")
    }
}

impl Observer for Log {
    fn stage_began(&self, stage: &Stage) {
        self.add(match stage {
            Stage::FirstContact => "first contact:",
            Stage::Sample => "sample:",
            Stage::PrioritizedCases => "prioritized cases:",
            Stage::Cases => "cases:",
            Stage::Repeats => "repeats:",
            Stage::Report => "report:",
            Stage::Search(_) => "search:",
        });
    }

    fn contact_made(&self, views: &[&'static str], undone: &[&'static str]) {
        let (views, undone) = (views.join(" "), undone.join(" "));
        self.add(format!("offers {views}; undone in [{undone}]"));
    }

    fn agenda_known(&self, agenda: &Agenda) {
        assert!(agenda.prioritized < agenda.total);
        self.add("agenda");
    }

    fn case_finished(&self, _: &FinishedCase, _: usize, _: usize) {
        self.add("case");
    }

    fn request_repeated(&self, _: usize, _: usize) {
        self.add("repeat");
    }

    fn first_verdicts(&self, first: &FirstVerdicts) {
        assert!(first.failed <= first.judged);
        let clauses: Vec<&str> = first.failing_clauses.keys().map(String::as_str).collect();
        self.add(format!("failing clauses: {}", clauses.join(" ")));
    }

    fn verdicts_reported(&self, report: &Report) -> Result<(), String> {
        *self.verdicts.lock().expect("no observer panics") = Some(report.clone());
        self.add("verdicts");
        match self.is_full {
            true => Err("the disk is full".to_owned()),
            false => Ok(()),
        }
    }

    fn causes_found(&self, found: &FoundCauses) {
        let causes: Vec<&str> = found.causes.iter().map(LikelyCause::name).collect();
        self.add(format!("causes: {}", causes.join(" ")));
    }
}

/// Returns a plan with the smoke subset first, as the program makes it.
fn plan(suite: &Suite) -> RunPlan {
    let smoke = smoke::ids(&ptm::Format::ALL).expect("a list of ids");
    RunPlan {
        prioritized: suite
            .cases
            .iter()
            .map(|case| smoke.contains(&case.id))
            .collect(),
        repeat: Repeat::Failures,
        ..RunPlan::new(suite, jobs())
    }
}

#[test]
fn verdicts_are_reported_before_causes_are_searched() {
    let suite = suite_of_small_files();
    let plan = plan(&suite);
    let mistake = misreading("bias-added");
    let decoder = |request: &Request<'_>, _: usize| Reply::from(answer_with(&[mistake], request));
    let log = Log::default();
    let checked = check(&Check::new(&suite, &plan), &decoder, &log).expect("a verdict");

    assert_eq!(checked.report.diagnoses[0].name(), "bias-added");
    let verdicts = log.verdicts.lock().expect("no observer panics").clone();
    let without_causes = Report {
        diagnoses: Vec::new(),
        ..checked.report
    };
    assert_eq!(verdicts, Some(without_causes));

    let mut events = log.events();
    let clauses = events
        .iter()
        .position(|event| event.starts_with("failing clauses: "));
    let clauses = events.remove(clauses.expect("the first verdicts are known"));
    assert!(clauses.contains("2.4/8"), "{clauses}");
    let expected = [
        "first contact:",
        "offers raw coef rgb; undone in []",
        "sample:",
        "case",
        "agenda",
        "prioritized cases:",
        "case",
        "cases:",
        "case",
        "repeats:",
        "repeat",
        "report:",
        "verdicts",
        "search:",
        "causes: bias-added",
    ];
    assert_eq!(events, expected);
}

/// Checks a decoder that answers with 69 if `lacks` returns true for a case, and counts its requests.
fn check_decoder_without(suite: &Suite, lacks: impl Fn(&Case) -> bool + Sync) -> (Report, usize) {
    let plan = plan(suite);
    let decoder = |request: &Request<'_>, _: usize| {
        let case = suite.case(request.name).expect("the case exists");
        Reply::from(match lacks(case) {
            true => Answer::Unsupported,
            false => answer_with(&[], request),
        })
    };
    let checked = check(&Check::new(suite, &plan), &decoder, &()).expect("a verdict");
    let requests = checked.run.request_count;
    (checked.report, requests)
}

#[test]
fn files_of_a_lacking_format_are_not_asked_and_have_no_verdict() {
    let suite = suite_of_small_files();
    let is_other = |case: &Case| case.format() != Format::Lrgb;
    let (report, requests) = check_decoder_without(&suite, is_other);
    assert_eq!(report.verdict, Verdict::Pass);
    let not_asked: usize = report.not_asked.values().sum();
    assert_eq!(report.cases.len() + not_asked, suite.cases.len());
    assert!(requests * 100 < suite.cases.len() * 35, "{requests}");
    // All files of the format that it reads, and a few of the others.
    let judged = |format: Format| {
        let of_format = report
            .cases
            .iter()
            .filter(|result| suite.case(&result.id).expect("the case exists").format() == format);
        of_format.count()
    };
    let all = |format: Format| {
        suite
            .cases
            .iter()
            .filter(|case| case.format() == format)
            .count()
    };
    assert_eq!(judged(Format::Lrgb), all(Format::Lrgb));
    assert!((4..all(Format::JpegRgb) / 2).contains(&judged(Format::JpegRgb)));
    assert_eq!(report.scores.robustness.whole, requests);
    let baseline = Baseline::default().compare(&report);
    assert_eq!(baseline, BaselineComparison::default());

    let plan = plan(&suite);
    let check_all = Check {
        asks_all: true,
        ..Check::new(&suite, &plan)
    };
    let decoder = |request: &Request<'_>, _: usize| {
        let case = suite.case(request.name).expect("the case exists");
        Reply::from(match is_other(case) {
            true => Answer::Unsupported,
            false => answer_with(&[], request),
        })
    };
    let all = check(&check_all, &decoder, &()).expect("a verdict").report;
    assert_eq!(all.cases.len(), suite.cases.len());
    assert_eq!(all.scores.correctness, report.scores.correctness);
    assert_eq!(all.scores.breadth, report.scores.breadth);
}

#[test]
fn files_of_another_lacking_feature_are_not_asked_either() {
    let suite = suite_of_small_files();
    let predicts = |case: &Case| case.compression().is_some_and(Compression::predicts);
    let (report, _) = check_decoder_without(&suite, predicts);
    assert_eq!(report.verdict, Verdict::Pass);
    assert_eq!(report.not_asked.keys().collect::<Vec<_>>(), ["prediction"]);
    // A decoder that reads some of the first files may read others.
    let (report, _) = check_decoder_without(&suite, |case| {
        predicts(case) && case.format() == Format::JpegRgb
    });
    assert!(report.not_asked.is_empty(), "{:?}", report.not_asked);
    let (report, _) = check_decoder_without(&suite, |_| false);
    assert!(report.not_asked.is_empty() && report.verdict == Verdict::Pass);
}

#[test]
fn the_first_tenth_of_a_run_tests_every_clause() {
    let suite = Suite::load().expect("the suite loads");
    let plan = plan(&suite);
    let asked = Mutex::new(Vec::new());
    let decoder = |request: &Request<'_>, _: usize| {
        asked
            .lock()
            .expect("no panic")
            .push(request.name.to_owned());
        Reply::from(answer_with(&[], request))
    };
    let plan = RunPlan { jobs: 1, ..plan };
    check(&Check::new(&suite, &plan), &decoder, &()).expect("a verdict");
    let asked = asked.into_inner().expect("no panic");
    let contact = asked.len() - suite.cases.len();
    let first = &asked[contact..contact + suite.cases.len() / 10];
    let clauses = |case: &Case| case.clauses.clone();
    let tested: BTreeSet<String> = first
        .iter()
        .flat_map(|id| clauses(suite.case(id).expect("the case exists")))
        .collect();
    let all: BTreeSet<String> = suite.cases.iter().flat_map(clauses).collect();
    let untested: Vec<&String> = all.difference(&tested).collect();
    assert!(untested.is_empty(), "{untested:?}");
}

#[test]
fn common_transforms_are_undone_unless_all_answers_are_judged_as_they_are() {
    let suite = suite_of_small_files();
    let plan = plan(&suite);
    let mistake = misreading("rows-top-down");
    let decoder = |request: &Request<'_>, _: usize| Reply::from(answer_with(&[mistake], request));
    let log = Log::default();
    let undone = check(&Check::new(&suite, &plan), &decoder, &log).expect("a verdict");
    assert_eq!(
        log.events()[1],
        "offers raw coef rgb; undone in [raw coef rgb]"
    );
    assert_eq!(undone.run.exit_status(), 1);
    assert!(
        undone.report.remarks[0]
            .message
            .contains("the rows are upside down")
    );

    let log = Log::default();
    let as_they_are = check(&Check::of_answers(&suite, &plan), &decoder, &log).expect("a verdict");
    let events = log.events();
    assert_eq!(events[1], "offers raw coef rgb; undone in []");
    assert_eq!(events.last().map(String::as_str), Some("verdicts"));
    let failures = |report: &Report| report.with_outcome(Outcome::Fail).count();
    assert!(failures(&as_they_are.report) > 2 * failures(&undone.report));
}

#[test]
fn texture_stages_are_checked_in_the_same_order() {
    let suite = Suite::load_texture().expect("the suite loads");
    let plan = RunPlan::new(&suite, jobs());
    let mistake = ptm_mistakes::texture::all().next().expect("a misreading");
    let rules = mistake.apply_to(Rules::SPEC);
    let stage = |request: &Request<'_, TextureView>, _: usize| {
        let case = suite.case(request.name).expect("the case exists");
        Reply::from(case.answer(&rules))
    };
    let log = Log::default();
    let check = TextureCheck::new(&suite, &plan);
    let (run, report) = pipeline::texture::check(&check, &stage, &log).expect("a verdict");
    assert_eq!(run.exit_status(), 1);
    assert_eq!(report.diagnoses[0].name(), mistake.slug);
    let expected = [
        "first contact:",
        "offers texture; undone in []",
        "cases:",
        "case",
        "repeats:",
        "report:",
        "verdicts",
        "search:",
        &format!("causes: {}", mistake.slug),
    ];
    assert_eq!(log.events(), expected);
}

#[test]
fn check_ends_if_the_verdicts_cannot_be_written() {
    let mut suite = suite_of_small_files();
    suite.cases.retain(|case| case.first);
    let plan = RunPlan::new(&suite, 1);
    let mistake = misreading("rows-top-down");
    let decoder = |request: &Request<'_>, _: usize| Reply::from(answer_with(&[mistake], request));
    let log = Log {
        is_full: true,
        ..Log::default()
    };
    let error = check(&Check::new(&suite, &plan), &decoder, &log).err();
    assert_eq!(error, Some(Error::Observer("the disk is full".to_owned())));
    assert_eq!(log.events().last().map(String::as_str), Some("verdicts"));
}
