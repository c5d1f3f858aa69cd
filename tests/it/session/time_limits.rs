//! Exceeded time limits: which requests are repeated alone, and how their answers are judged.
//!
//! Decoders in this process exceed a limit by saying so. Programs sleep for a multiple of `--timeout`.

use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use ptm_harness::pipeline::{Check, FinishedCase, Observer, check, judge_answers};
use ptm_harness::report::Report;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::session::run::Run;
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::protocol::frame::{Answer, Samples, TimeLimit};
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::verdicts::outcome::Outcome;

use crate::common::{CheckRun, Workspace, assert_conforms, assert_contains, zoo};
use crate::in_process::{self, reference_answer};

/// The usual time limit of the decoders in this file.
const LIMIT: Duration = Duration::from_secs(10);

/// Returns part of the suite: the first files, every eighth of the other small files, and their twins.
fn suite() -> Suite {
    let mut suite = in_process::suite_of_small_files();
    let cases = suite.cases.iter().enumerate();
    let some = cases.filter(|(number, case)| case.first || number % 8 == 0);
    let ids = some.flat_map(|(_, case)| [Some(case.id.clone()), case.twin_of.clone()]);
    let ids: HashSet<String> = ids.flatten().collect();
    suite.cases.retain(|case| ids.contains(&case.id));
    suite
}

/// The time that a decoder needs for a file.
#[derive(Clone, Copy, PartialEq)]
enum Pace {
    /// Less than the usual limit.
    Quick,
    /// More than the usual limit, but less than the higher one.
    Slow,
    /// More than any limit.
    Endless,
}

impl Pace {
    /// Returns the answer of the reference, unless it takes too long.
    fn answer(self, request: &Request) -> Answer {
        match (self, request.attempt) {
            (Pace::Quick, _) | (Pace::Slow, AttemptKind::Alone) => reference_answer(request),
            _ => Answer::TimedOut(request.attempt.time_limit(LIMIT)),
        }
    }
}

/// Runs `suite` in both modes, with one job and with four, against a decoder that answers correctly at a pace that depends on the
/// case. Asserts that the reports are equal for any number of jobs.
fn runs(suite: &Suite, pace: impl Fn(&Case) -> Pace + Sync) -> Vec<Run> {
    let pace = |request: &Request| pace(suite.case(request.name).expect("the case exists"));
    let mut runs = Vec::new();
    for repeat in [Repeat::Failures, Repeat::FailuresAndSample] {
        let reports = [1, 4].map(|jobs| {
            let plan = RunPlan {
                repeat,
                ..RunPlan::new(suite, jobs)
            };
            let run = in_process::run(suite, &plan, |request| pace(request).answer(request));
            let command = ["decoder".to_owned()];
            let report = Report::new(suite, &run, &command, vec!["none".to_owned()]);
            runs.push(run);
            report.to_yaml().expect("YAML")
        });
        assert_eq!(reports[0], reports[1]);
    }
    runs
}

fn ids(suite: &Suite, run: &Run, outcome: Outcome) -> Vec<String> {
    let indices = run.judgment.with_outcome(outcome);
    indices.map(|i| suite.cases[i].id.clone()).collect()
}

fn message(suite: &Suite, run: &Run, id: &str) -> String {
    let index = suite.cases.iter().position(|case| case.id == id);
    let verdict = &run.judgment.cases[index.expect("the case exists")];
    verdict.as_ref().expect("it is judged").message.clone()
}

/// Returns the ids of legal cases that are not first files.
fn legal(suite: &Suite) -> Vec<String> {
    let cases = suite.cases.iter();
    let legal = cases.filter(|case| case.expect == Expect::Decode && !case.first);
    legal.map(|case| case.id.clone()).collect()
}

#[track_caller]
fn assert_passes(suite: &Suite, run: &Run) {
    assert_eq!(ids(suite, run, Outcome::Fail), [""; 0]);
    assert_eq!(ids(suite, run, Outcome::NotRun), [""; 0]);
    assert_eq!((run.exit_status(), &run.ended_early), (0, &None));
    let scores = run.scores(|i| suite.features(i));
    assert_eq!(scores.robustness.part, scores.robustness.whole);
    let mut observed = run.observations.iter().flatten();
    assert!(observed.all(|seen| seen.nondeterminism.is_none()));
}

#[test]
fn slow_answers_are_judged_normally_and_remarked_on() {
    let suite = suite();
    let slow = &legal(&suite)[30];
    for run in runs(&suite, |case| match case.id == *slow {
        true => Pace::Slow,
        false => Pace::Quick,
    }) {
        assert_passes(&suite, &run);
        let [remark] = &run.remarks[..] else {
            panic!("{:?}", run.remarks)
        };
        assert!(!remark.failure);
        assert_contains(
            &remark.message,
            &format!("the time limit of 10 s (`--timeout`) on 1 file && within 30 s && : {slow}"),
        );
    }
}

#[test]
fn endless_file_fails_alone_with_the_higher_limit() {
    let suite = suite();
    let malformed = suite
        .cases
        .iter()
        .find(|case| case.expect == Expect::Reject);
    let malformed = malformed.expect("a malformed file").id.clone();
    let first = suite
        .cases
        .iter()
        .find(|case| case.first)
        .expect("a first file");
    for endless in [&legal(&suite)[30], &malformed, &first.id] {
        for run in runs(&suite, |case| match case.id == *endless {
            true => Pace::Endless,
            false => Pace::Quick,
        }) {
            assert_eq!(ids(&suite, &run, Outcome::Fail), [endless.as_str()]);
            assert_eq!(run.ended_early, None);
            assert_eq!(
                message(&suite, &run, endless),
                "exceeds the time limit of 30 s (`--timeout`)"
            );
        }
    }
}

/// A busy machine must not end the run of a correct decoder.
#[test]
fn slow_files_in_a_row_do_not_end_a_run() {
    let suite = suite();
    let legal = legal(&suite);
    for count in [3, 7, legal.len()] {
        let slow = &legal[..count];
        for run in runs(&suite, |case| match slow.contains(&case.id) {
            true => Pace::Slow,
            false => Pace::Quick,
        }) {
            assert_passes(&suite, &run);
        }
    }
    for run in runs(&suite, |_| Pace::Slow) {
        assert_passes(&suite, &run);
    }
}

/// Three endless files in a row end a run, even if other files are slow. Two do not.
#[test]
fn endless_files_in_a_row_end_a_run() {
    let suite = suite();
    let legal = legal(&suite);
    let pace = |endless: &[String]| {
        let (endless, slow) = (endless.to_vec(), legal[..8].to_vec());
        move |case: &Case| match case {
            _ if endless.contains(&case.id) => Pace::Endless,
            _ if slow.contains(&case.id) => Pace::Slow,
            _ => Pace::Quick,
        }
    };
    for run in runs(&suite, pace(&legal[20..23])) {
        let limit = "exceeds the time limit of 30 s (`--timeout`)";
        let why = format!("the run ended early: the decoder {limit} on three legal files in a row");
        assert_eq!(run.ended_early, Some(why));
        assert_eq!(ids(&suite, &run, Outcome::Fail), legal[20..23]);
        let next = ids(&suite, &run, Outcome::NotRun).swap_remove(0);
        let position = |id: &str| suite.cases.iter().position(|case| case.id == id);
        assert_eq!(position(&next), position(&legal[22]).map(|last| last + 1));
    }
    let two = [&legal[20..22], &legal[23..25]].concat();
    for run in runs(&suite, pace(&two)) {
        assert_eq!(run.ended_early, None);
        assert_eq!(ids(&suite, &run, Outcome::Fail), two);
    }
}

/// At most five requests exceed the higher limit. The legal files are repeated first.
#[test]
fn repetition_ends_after_five_endless_files() {
    let suite = suite();
    let pace = |case: &Case| match case.expect {
        Expect::Decode if case.id == legal(&suite)[40] => Pace::Slow,
        Expect::Reject => Pace::Endless,
        _ => Pace::Quick,
    };
    for run in runs(&suite, pace) {
        let failing = ids(&suite, &run, Outcome::Fail);
        let malformed = suite
            .cases
            .iter()
            .filter(|case| case.expect == Expect::Reject);
        assert_eq!(failing, malformed.map(|case| &*case.id).collect::<Vec<_>>());
        let messages: Vec<String> = failing.iter().map(|id| message(&suite, &run, id)).collect();
        let of = |seconds| format!("exceeds the time limit of {seconds} s (`--timeout`)");
        assert!(failing.len() > 10);
        assert!(messages[..5].iter().all(|text| *text == of(30)));
        assert!(messages[5..].iter().all(|text| *text == of(10)));
        let open = format!("because others exceeded 30 s: {}", failing.len() - 5);
        let [slow, remark] = &run.remarks[..] else {
            panic!("{:?}", run.remarks)
        };
        assert!(slow.message.contains("on 1 file") && !slow.failure);
        assert!(remark.message.ends_with(&open), "{}", remark.message);
        assert!(!remark.failure);
    }
}

/// A decoder that never answers is not a decoder, and only three requests are sent, each with the higher limit.
#[test]
fn decoder_that_never_answers_is_given_three_requests() {
    let suite = suite();
    let requests = Mutex::new(Vec::new());
    let run = in_process::run(&suite, &RunPlan::new(&suite, 4), |request| {
        requests.lock().expect("a list").push(request.attempt);
        Pace::Endless.answer(request)
    });
    assert_eq!(
        requests.into_inner().expect("a list"),
        [AttemptKind::Alone; 3]
    );
    let limit = "exceeds the time limit of 30 s (`--timeout`)";
    let reason = run.not_a_decoder.expect("it is not a decoder");
    assert!(reason.starts_with(&format!("it {limit} and decodes none of the first files")));
}

/// All formats but one are answered at first contact, and then nothing is.
#[test]
fn decoder_that_stops_answering_ends_early() {
    let suite = suite();
    let legal = legal(&suite);
    for run in runs(&suite, |case| match case.first {
        true => Pace::Quick,
        false => Pace::Endless,
    }) {
        assert!(run.ended_early.is_some());
        let failing = ids(&suite, &run, Outcome::Fail);
        assert!(legal[..3].iter().all(|id| failing.contains(id)));
        assert!(failing.len() < 20, "{failing:?}");
    }
}

#[test]
fn repetition_has_the_machine_to_itself() {
    let suite = suite();
    let legal = legal(&suite);
    let (running, alone) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let run = in_process::run(&suite, &RunPlan::new(&suite, 4), |request| {
        running.fetch_add(1, Ordering::SeqCst);
        let pace = match legal[..20].iter().any(|id| id == request.name) {
            true => Pace::Slow,
            false => Pace::Quick,
        };
        let answer = pace.answer(request);
        if request.attempt == AttemptKind::Alone {
            alone.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_millis(2));
            assert_eq!(running.load(Ordering::SeqCst), 1, "{}", request.name);
        }
        running.fetch_sub(1, Ordering::SeqCst);
        answer
    });
    assert_passes(&suite, &run);
    assert!(alone.into_inner() >= 20);
}

/// A wrong image whose repetitions exceed a limit is a wrong image, not a decoder with varying responses.
#[test]
fn timeout_of_a_repetition_is_not_nondeterminism() {
    let suite = suite();
    let wrong = &legal(&suite)[30];
    // The number of repetitions that exceed the limit, of two: both, or only the second.
    for answered in [0, 1] {
        for repeat in [Repeat::Failures, Repeat::FailuresAndSample] {
            let repetitions = AtomicUsize::new(0);
            let plan = RunPlan {
                repeat,
                ..RunPlan::new(&suite, 2)
            };
            let run = in_process::run(&suite, &plan, |request| {
                if request.name != wrong {
                    return reference_answer(request);
                }
                let is_repetition = request.attempt == AttemptKind::Repetition;
                if is_repetition && repetitions.fetch_add(1, Ordering::SeqCst) >= answered {
                    return Answer::TimedOut(TimeLimit(LIMIT));
                }
                change_first_sample(reference_answer(request))
            });
            assert_eq!(ids(&suite, &run, Outcome::Fail), [wrong.as_str()]);
            let text = message(&suite, &run, wrong);
            assert!(
                text.contains("expected") && text.contains("received"),
                "{text}"
            );
            let mut observed = run.observations.iter().flatten();
            assert!(observed.all(|seen| seen.nondeterminism.is_none()));
            assert!(repetitions.into_inner() > 0);
        }
    }
}

fn change_first_sample(answer: Answer) -> Answer {
    let Answer::Decoded(mut frame) = answer else {
        return answer;
    };
    match &mut frame.samples {
        Samples::U8(samples) => samples[0] ^= 0x55,
        Samples::F32(samples) => samples[0] += 100.0,
    }
    Answer::Decoded(frame)
}

/// Two different images are a difference, even if the repetition that would tell serve mode from chance exceeds a limit.
#[test]
fn different_images_differ_even_if_the_next_repetition_times_out() {
    let suite = suite();
    let wrong = &legal(&suite)[30];
    let repetitions = AtomicUsize::new(0);
    let plan = RunPlan {
        repeat: Repeat::FailuresAndSample,
        ..RunPlan::new(&suite, 1)
    };
    let ask = |request: &Request<'_>, _: usize| {
        let answer = reference_answer(request);
        Reply::from(match request.attempt {
            AttemptKind::Repetition if request.name == wrong => {
                match repetitions.fetch_add(1, Ordering::SeqCst) {
                    0 => answer,
                    _ => Answer::TimedOut(TimeLimit(LIMIT)),
                }
            }
            _ if request.name == wrong => change_first_sample(answer),
            _ => answer,
        })
    };
    let run = judge_answers(&suite, &plan, &ask);
    assert_eq!(ids(&suite, &run, Outcome::Fail), [wrong.as_str()]);
    let text = message(&suite, &run, wrong);
    assert!(
        text.starts_with("two calls returned different responses"),
        "{text}"
    );
    assert!(!text.contains("serve mode"), "{text}");
}

/// The memory limit may be exceeded before or after the time limit.
#[test]
fn memory_and_time_limits_are_not_nondeterminism() {
    let suite = suite();
    let large = &legal(&suite)[30];
    for first in [
        AttemptKind::Usual,
        AttemptKind::Alone,
        AttemptKind::Repetition,
    ] {
        let run = in_process::run(&suite, &RunPlan::new(&suite, 2), |request| {
            match (request.name == large, request.attempt == first) {
                (false, _) => reference_answer(request),
                (true, false) => Answer::TimedOut(request.attempt.time_limit(LIMIT)),
                (true, true) => Answer::OutOfMemory("more than 2048 MiB".to_owned()),
            }
        });
        assert_eq!(ids(&suite, &run, Outcome::Fail), [large.as_str()]);
        let mut observed = run.observations.iter().flatten();
        assert!(observed.all(|seen| seen.nondeterminism.is_none()));
    }
}

/// A user who ends the run after a number of cases.
struct StopAfter<'a>(usize, &'a AtomicBool);

impl Observer for StopAfter<'_> {
    fn case_finished(&self, _: &FinishedCase, done: usize, _: usize) {
        self.1.store(done > self.0, Ordering::Relaxed);
    }
}

/// Requests that exceeded the limit have no verdict if the user ends the run before they are repeated.
#[test]
fn interrupted_run_has_no_verdict_on_open_requests() {
    let suite = suite();
    let legal = legal(&suite);
    let plan = RunPlan::new(&suite, 2);
    let ask = |request: &Request<'_>, _: usize| {
        Reply::from(match legal[..2].iter().any(|id| id == request.name) {
            true => Pace::Endless.answer(request),
            false => reference_answer(request),
        })
    };
    let impatient = StopAfter(100, &plan.stop);
    let checked = check(&Check::of_answers(&suite, &plan), &ask, &impatient);
    let run = checked.expect("a function has no trouble").run;
    assert_eq!(run.ended_early.as_deref(), Some("the run was interrupted"));
    assert_eq!(ids(&suite, &run, Outcome::Fail), [""; 0]);
    assert!(ids(&suite, &run, Outcome::NotRun).contains(&legal[0]));
    assert_eq!(run.violations, 0);
}

/// Options that select a few small cases of every kind.
const CASES: &str = "--case hand-* --case first-lrgb --case header-plain-*";

/// Checks a program in both modes that sleeps for this many seconds on these files, with a time limit of 1 s.
fn check_sleeper(slow: &[(&str, f64)]) -> [CheckRun; 2] {
    let suite = in_process::suite();
    ["--one-shot", "--serve"].map(|mode| {
        let here = Workspace::new();
        std::fs::create_dir(here.path("slow")).expect("a directory");
        for (id, seconds) in slow {
            let case = suite.case(id).expect("the case exists");
            let built = case.build(TableSpelling::default());
            here.write(&format!("slow/{seconds}-{id}"), &built.file);
        }
        let decoder = zoo("sleeps-on-slow-files");
        let line = format!("check {CASES} {mode} --timeout 1 --report report.yaml -- {decoder}");
        let mut command = here.command(&line);
        command.env("ZOO_SLOW_FILES", here.path("slow"));
        let (status, text) = crate::common::outcome(&command.output().expect("it starts"));
        let checked = CheckRun::new(status, text, &here.path("report.yaml"));
        assert_conforms(&checked.report, "report");
        checked
    })
}

#[test]
fn program_that_sleeps_longer_than_the_limit_passes() {
    for checked in check_sleeper(&[("hand-lum", 1.2)]) {
        let remark = "note: it exceeded the time limit of 1 s (`--timeout`) on";
        checked.assert_exit(0, &format!("{remark} && within 3 s && hand-lum"));
    }
    let row = [
        "hand-lrgb-blocks",
        "hand-lum",
        "hand-lum-in-color",
        "hand-rgb-blocks",
    ];
    for checked in check_sleeper(&row.map(|id| (id, 1.2))) {
        checked.assert_exit(0, "exceeded the time limit of 1 s (`--timeout`) on");
    }
}

#[test]
fn program_that_sleeps_forever_fails_one_file() {
    for id in ["hand-lum", "first-lrgb"] {
        for checked in check_sleeper(&[(id, 1000.0)]) {
            checked.assert_exit(1, "exceeds the time limit of 3 s (`--timeout`)");
            assert_eq!(checked.cases("fail"), [id]);
            assert_eq!(checked.cases("not run"), [""; 0]);
        }
    }
}
