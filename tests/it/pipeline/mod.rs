//! The pipeline in this process: what an observer learns, and when.

#![cfg(unix)]

use std::sync::Mutex;

use ptm_harness::pipeline::texture::TextureCheck;
use ptm_harness::pipeline::{
    self, Agenda, Check, Error, FinishedCase, FirstCauses, FoundCauses, Observer, Stage, check,
};
use ptm_harness::report::Report;
use ptm_harness::report::document::LikelyCause;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::strength::smoke;
use ptm_suite::cases::Suite;
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
            Stage::PrioritizedCases => "prioritized cases:",
            Stage::FirstSearch(_) => "first search:",
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

    fn first_causes_found(&self, first: &FirstCauses) {
        let causes: Vec<&str> = first.causes.iter().map(LikelyCause::name).collect();
        self.add(format!("first causes: {}", causes.join(" ")));
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
    let smoke = smoke::ids().expect("a list of ids");
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
    // The first search has a time limit.
    events.retain(|event| !event.starts_with("first causes: "));
    let expected = [
        "first contact:",
        "offers raw coef rgb; undone in []",
        "agenda",
        "prioritized cases:",
        "case",
        "first search:",
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
