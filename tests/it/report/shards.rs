//! Tests that merged shards equal a run of the whole suite.

use std::path::{Path, PathBuf};
use std::time::Duration;

use ptm::Reading;
use ptm_harness::pipeline::merge::RecordedAnswers;
use ptm_harness::pipeline::recorder::ShardRecorder;
use ptm_harness::pipeline::texture::TextureCheck;
use ptm_harness::pipeline::{self, Check, Subject, check};
use ptm_harness::report::Report;
use ptm_harness::report::shards::{Circumstances, OtherRemarks, answers_path};
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::session::remark::Remark;
use ptm_mistakes::answer;
use ptm_suite::cases::Suite;
use ptm_suite::kit::shard::Shard;
use ptm_suite::protocol::frame::{Answer, Frame};
use ptm_suite::protocol::request::{AttemptKind, Reply, Request};
use ptm_suite::texture::cases::TextureView;
use ptm_texture::Rules;

use crate::common::{Workspace, zoo};
use crate::in_process::{answer_with, misreading, reference_answer, suite_of_small_files};

fn circumstances() -> Circumstances {
    Circumstances {
        command: vec!["./decoder".to_owned(), "--strict".to_owned()],
        name: Some("a decoder".to_owned()),
        limits: vec!["none".to_owned()],
        ..Circumstances::default()
    }
}

fn plan(suite: &Suite, part: Option<Shard>) -> RunPlan {
    let mut plan = RunPlan::new(suite, 2);
    plan.repeat = Repeat::Failures;
    for (case, selected) in suite.cases.iter().zip(&mut plan.selected) {
        *selected = part.is_none_or(|part| part.contains(case.id.as_bytes()));
    }
    plan
}

type Decoder = dyn Fn(&Request) -> Answer + Sync;

/// A decoder about which there are other remarks.
struct RemarkableDecoder<'a>(&'a Decoder);

impl Subject for RemarkableDecoder<'_> {
    fn ask(&self, request: &Request, _: usize) -> Reply {
        (self.0)(request).into()
    }

    fn remarks(&self) -> OtherRemarks {
        OtherRemarks {
            before: Vec::new(),
            after: vec![Remark::note("a remark".to_owned())],
        }
    }
}

/// Returns the report of a run without shards.
fn report_of_whole_run(suite: &Suite, decoder: &Decoder) -> Report {
    let plan = plan(suite, None);
    let whole = Check {
        circumstances: circumstances(),
        ..Check::new(suite, &plan)
    };
    let checked = check(&whole, &RemarkableDecoder(decoder), &());
    checked.expect("a function has no trouble").report
}

/// Runs one part and records its answers. Returns the path of its report.
fn run_part(suite: &Suite, part: Shard, decoder: &Decoder, folder: &Path) -> PathBuf {
    let report = folder.join(format!("part-{}.yaml", part.number));
    let plan = plan(suite, Some(part));
    let check_of_part = Check {
        circumstances: circumstances(),
        finds_causes: false,
        recorder: Some(ShardRecorder::new(part, &report).expect("a file")),
        ..Check::new(suite, &plan)
    };
    let checked = check(&check_of_part, &RemarkableDecoder(decoder), &());
    checked.expect("the answers are written");
    report
}

/// Asserts that eight merged parts produce the same report as a whole run.
#[track_caller]
fn assert_same_report(suite: &Suite, decoder: &Decoder) {
    let whole = report_of_whole_run(suite, decoder);
    let scratch = tempfile::tempdir().expect("a directory");
    let run = |number| run_part(suite, Shard { number, total: 8 }, decoder, scratch.path());
    // The parts can be merged in any order.
    let parts = [4, 5, 6, 7, 8, 1, 2, 3].map(run);
    let answers = RecordedAnswers::read(suite, &parts).expect("all parts exist");
    let merged = answers.merge(suite, 2, &()).expect("every answer exists");
    assert_eq!(merged.report.to_yaml(), whole.to_yaml());
}

/// Returns true for one in `count` files. The pseudorandom decision depends only on the bytes of the file.
fn is_sampled(request: &Request, count: u32) -> bool {
    let sum = request.file.iter().fold(7_u32, |sum, &byte| {
        sum.wrapping_mul(31).wrapping_add(u32::from(byte))
    });
    (sum >> 7).is_multiple_of(count)
}

/// For each decoder, verdicts in one part depend on answers in another part.
#[test]
fn eight_merged_shards_equal_the_whole_run() {
    let suite = suite_of_small_files();
    assert_same_report(&suite, &reference_answer);
    let mistake = misreading("rows-top-down");
    assert_same_report(&suite, &|request| answer_with(&[mistake], request));
    // Refuses some files as unsupported. Other files show that it supports their features.
    assert_same_report(&suite, &|request| match is_sampled(request, 5) {
        true => Answer::Unsupported,
        false => reference_answer(request),
    });
    // Mixes two dialects.
    assert_same_report(&suite, &|request| {
        let mut reading = Reading::SPEC;
        if is_sampled(request, 2) {
            reading.motion_sign = ptm::decode::predict::predictor_to_texel;
        }
        answer(&[], reading, request.file, request.view)
    });
    // Supports one spelling of tables and sometimes crashes.
    assert_same_report(&suite, &|request| {
        let spelled = |word: &[u8]| request.file.windows(word.len()).any(|at| at == word);
        if spelled(b"N_LUT_ENTRIES") || spelled(b"_LUT\n") && !spelled(b"nentries ") {
            Answer::Rejected
        } else if is_sampled(request, 40) {
            Answer::Crashed("signal 11".to_owned())
        } else {
            reference_answer(request)
        }
    });
}

/// Some files exceed the usual time limit, and all or some of them the higher one, too, so that not all are repeated.
#[test]
fn merged_shards_repeat_the_same_requests_as_the_whole_run() {
    let suite = suite_of_small_files();
    for endless in [1, 8] {
        assert_same_report(&suite, &move |request| {
            let limit = request.attempt.time_limit(Duration::from_secs(10));
            let is_slow = is_sampled(request, 40);
            match request.attempt {
                AttemptKind::Usual | AttemptKind::Repetition if is_slow => Answer::TimedOut(limit),
                AttemptKind::Alone if is_slow && is_sampled(request, endless * 40) => {
                    Answer::TimedOut(limit)
                }
                _ => reference_answer(request),
            }
        });
    }
}

#[test]
fn merged_shards_of_a_texture_stage_equal_the_whole_run() {
    let suite = Suite::load_texture().expect("the suite loads");
    let mistake = ptm_mistakes::texture::all().next().expect("a misreading");
    let rules = mistake.apply_to(Rules::SPEC);
    let stage = |request: &Request<'_, TextureView>, _: usize| {
        let case = suite.case(request.name).expect("the case exists");
        Reply::from(case.answer(&rules))
    };
    let scratch = tempfile::tempdir().expect("a directory");
    let run_part = |part: Option<Shard>| {
        let report = scratch.path().join(format!("{part:?}.yaml"));
        let mut plan = RunPlan::new(&suite, 2);
        for (case, selected) in suite.cases.iter().zip(&mut plan.selected) {
            *selected = part.is_none_or(|part| part.contains(case.id.as_bytes()));
        }
        let check = TextureCheck {
            circumstances: circumstances(),
            recorder: part.map(|part| ShardRecorder::new(part, &report).expect("a file")),
            ..TextureCheck::new(&suite, &plan)
        };
        let (_, whole) = pipeline::texture::check(&check, &stage, &()).expect("a verdict");
        (report, whole)
    };
    let (_, whole) = run_part(None);
    let parts = [1, 2].map(|number| run_part(Some(Shard { number, total: 2 })).0);
    let answers = RecordedAnswers::read(&suite, &parts).expect("all parts exist");
    let (_, merged) = answers
        .merge_texture(&suite, 2, &())
        .expect("every answer exists");
    assert_eq!(merged.to_yaml(), whole.to_yaml());
}

#[test]
fn incomplete_or_foreign_shards_are_not_merged() {
    let suite = suite_of_small_files();
    let scratch = tempfile::tempdir().expect("a directory");
    let run = |number, total| {
        let part = Shard { number, total };
        run_part(&suite, part, &reference_answer, scratch.path())
    };
    let refusal = |parts: &[PathBuf]| {
        RecordedAnswers::<Frame>::read(&suite, parts)
            .err()
            .expect("an error")
    };

    let (first, second) = (run(1, 2), run(2, 2));
    assert_eq!(refusal(std::slice::from_ref(&first)), "part 2/2 is missing");
    let twice = [first.clone(), second.clone(), first.clone()];
    assert_eq!(refusal(&twice), "duplicate part 1/2");
    let other = run(3, 3);
    assert!(refusal(&[first.clone(), other]).contains("not from the run of "));

    let cut = answers_path(&second);
    let text = std::fs::read_to_string(&cut).expect("UTF-8");
    let (without_end, _) = text.trim_end().rsplit_once('\n').expect("lines");
    std::fs::write(&cut, without_end).expect("a file");
    let message = "the last line is missing; was the run interrupted?";
    assert!(refusal(&[first.clone(), second.clone()]).ends_with(message));
    std::fs::write(&cut, "{\n").expect("a file");
    assert!(refusal(&[first, second.clone()]).contains("line 1: "));
    std::fs::remove_file(&cut).expect("a file");
    assert!(refusal(&[second]).contains("part-2.yaml.answers"));
}

#[test]
fn program_merges_shards() {
    let here = Workspace::new();
    let decoder = zoo("accepts-malformed");
    let check = |options: &str| {
        let cases = "--case hand-* --case first-* --case lut-*";
        here.run(&format!("check {cases} {options} -- {decoder}")).0
    };
    assert_eq!(check("--report whole.yaml"), 1);
    for part in [1, 2] {
        assert!(check(&format!("--shard {part}/2 --report part-{part}.yaml")) < 2);
    }
    here.exits(
        1,
        "report merge part-1.yaml part-2.yaml --report merged.yaml",
    );
    assert_eq!(here.text("merged.yaml"), here.text("whole.yaml"));
    here.exits(2, "report merge part-1.yaml");
}
