//! A run in parts is the run in one piece.

use std::path::{Path, PathBuf};

use ptm_conform::Reading;
use ptm_conform::misreadings::{answer, named};
use ptm_conform::protocol::frame::Answer;
use ptm_conform::report::Report;
use ptm_conform::report::conclude::{conclude, undo_common_transforms};
use ptm_conform::report::document::Tool;
use ptm_conform::report::merge::KeptAnswers;
use ptm_conform::report::shards::{Circumstances, End, Keeper, OtherRemarks, Shard, answers_path};
use ptm_conform::runner::run::{Reply, Request};
use ptm_conform::session::asking::Ask;
use ptm_conform::session::plan::{Repeat, RunPlan};
use ptm_conform::session::remark::Remark;
use ptm_conform::session::run::{Run, Session};
use ptm_conform::suite::cases::{Case, Suite};

fn circumstances() -> Circumstances {
    Circumstances {
        command: vec!["./decoder".to_owned(), "--strict".to_owned()],
        name: Some("a decoder".to_owned()),
        limits: vec!["none".to_owned()],
        ..Circumstances::default()
    }
}

fn plan(suite: &Suite, part: Option<Shard>) -> RunPlan {
    let mut plan = RunPlan::of(suite, 2);
    plan.repeat = Repeat::Failures;
    for (case, selected) in suite.cases.iter().zip(&mut plan.selected) {
        *selected = part.is_none_or(|part| part.holds(&case.id));
    }
    plan
}

fn remarks() -> OtherRemarks {
    OtherRemarks {
        before: Vec::new(),
        after: vec![Remark::note("a word on it".to_owned())],
    }
}

type Decoder = dyn Fn(&Request) -> Answer + Sync;

/// A run as `check` makes it.
fn asked(suite: &Suite, plan: &RunPlan, ask: &Ask, keeper: Option<&Keeper<Case>>) -> Run {
    let mut session = Session::new(suite, plan, ask);
    let mut contact = session.first_contact();
    undo_common_transforms(suite, &mut session, &mut contact, &[]);
    let observations = session.ask_cases(&contact, &|case, observation, _, _| {
        if let Some(keeper) = keeper.filter(|_| !session.undoes_changes()) {
            keeper.observed(case, observation);
        }
    });
    session.verdicts(contact, observations, &|_, _| ())
}

/// The report of a run in one piece.
fn whole(suite: &Suite, decoder: &Decoder) -> Report {
    let ask = |request: &Request<'_>, _: usize| Reply::from(decoder(request));
    let mut run = asked(suite, &plan(suite, None), &ask, None);
    conclude(suite, &mut run, &circumstances(), &remarks(), 2).expect("no misreading is assumed")
}

/// Runs one part and keeps its answers answers_path the path that is returned.
fn run_part(
    suite: &Suite,
    part: Shard,
    decoder: &Decoder,
    tool: &Tool,
    directory: &Path,
) -> PathBuf {
    let report = directory.join(format!("part-{}.yaml", part.number));
    let keeper = Keeper::new(&answers_path(&report)).expect("a file");
    let ask = |request: &Request<'_>, _: usize| {
        let reply = Reply::from(decoder(request));
        keeper.answered(request, &reply);
        reply
    };
    let plan = plan(suite, Some(part));
    let run = asked(suite, &plan, &ask, Some(&keeper));
    let end = End::of(suite, &plan, &run, tool, part, circumstances(), remarks());
    keeper.finish(end).expect("the answers are written");
    report
}

/// Eight parts and the whole.
#[track_caller]
fn comes_out_the_same(suite: &Suite, decoder: &Decoder) {
    let whole = whole(suite, decoder);
    let scratch = tempfile::tempdir().expect("a directory");
    let mut parts: Vec<PathBuf> = (1..=8)
        .map(|number| {
            let part = Shard { number, of: 8 };
            run_part(suite, part, decoder, &whole.tool, scratch.path())
        })
        .collect();
    parts.rotate_left(3); // in any order
    let answers = KeptAnswers::read(suite, &parts).expect("all parts are there");
    let merged = answers.merge(suite, 2, &|_, _, _, _| {});
    let (_, merged) = merged.expect("every answer is there");
    assert_eq!(merged.to_yaml(), whole.to_yaml());
}

fn misread(slug: &str) -> impl Fn(&Request) -> Answer + Sync {
    let misreading = named(slug).expect("a misreading");
    move |request| answer(&[misreading], Reading::SPEC, request.file, request.view)
}

fn right(request: &Request) -> Answer {
    answer(&[], Reading::SPEC, request.file, request.view)
}

/// The same for the same file, and without a pattern otherwise.
fn draw(request: &Request, of: u32) -> bool {
    let sum = request.file.iter().fold(7_u32, |sum, &byte| {
        sum.wrapping_mul(31).wrapping_add(u32::from(byte))
    });
    (sum >> 7).is_multiple_of(of)
}

/// Each of these has verdicts in one part that depend on answers in another.
#[test]
fn eight_parts_merged_are_the_whole_run() {
    let suite = Suite::load().expect("the suite loads").prepared();
    comes_out_the_same(&suite, &right);
    comes_out_the_same(&suite, &misread("rows-top-down"));
    // Refuses what it supports: told only from files of the same feature that it decodes.
    comes_out_the_same(&suite, &|request| match draw(request, 5) {
        true => Answer::Unsupported,
        false => right(request),
    });
    // Two dialects.
    comes_out_the_same(&suite, &|request| {
        let reading = match draw(request, 2) {
            true => Reading::SPEC.with_motion_minus(),
            false => Reading::SPEC,
        };
        answer(&[], reading, request.file, request.view)
    });
    // Knows one spelling of tables, and crashes now and then.
    comes_out_the_same(&suite, &|request| {
        let spelled = |word: &[u8]| request.file.windows(word.len()).any(|at| at == word);
        if spelled(b"N_LUT_ENTRIES") || spelled(b"_LUT\n") && !spelled(b"nentries ") {
            Answer::Rejected
        } else if draw(request, 40) {
            Answer::Crashed("signal 11".to_owned())
        } else {
            right(request)
        }
    });
}

#[test]
fn parts_that_make_no_whole_are_refused() {
    let suite = Suite::load().expect("the suite loads").prepared();
    let scratch = tempfile::tempdir().expect("a directory");
    let tool = whole(&suite, &right).tool;
    let run = |number, of| {
        let part = Shard { number, of };
        run_part(&suite, part, &right, &tool, scratch.path())
    };
    let refused = |parts: &[PathBuf]| KeptAnswers::read(&suite, parts).err().expect("a refusal");

    let (first, second) = (run(1, 2), run(2, 2));
    assert_eq!(refused(std::slice::from_ref(&first)), "part 2/2 is missing");
    assert_eq!(
        refused(&[first.clone(), second.clone(), first.clone()]),
        "duplicate part 1/2"
    );
    let other = run(3, 3);
    assert!(refused(&[first.clone(), other]).contains("not of the same run as "));

    let cut = answers_path(&second);
    let text = std::fs::read_to_string(&cut).expect("text");
    let lines = text.lines().count();
    let without_end: Vec<&str> = text.lines().take(lines - 1).collect();
    std::fs::write(&cut, without_end.join("\n")).expect("a file");
    assert!(
        refused(&[first.clone(), second.clone()])
            .ends_with("the last line is missing; was the run interrupted?")
    );
    std::fs::write(&cut, "{\n").expect("a file");
    assert!(refused(&[first, second.clone()]).contains("line 1: "));
    std::fs::remove_file(&cut).expect("a file");
    assert!(refused(&[second]).contains("part-2.yaml.answers"));
}

#[test]
fn the_program_merges_what_it_ran_in_parts() {
    let scratch = tempfile::tempdir().expect("a directory");
    let path = |name: &str| scratch.path().join(name).to_string_lossy().into_owned();
    let chosen = ["--case", "hand-*", "--case", "first-*", "--case", "lut-*"];
    let check = |options: &[&str], report: &str| {
        let mut words = vec!["check", "--report", report];
        words.extend(chosen);
        words.extend(options);
        let zoo = crate::common::zoo();
        words.extend(["--", &zoo, "accepts-malformed"]);
        crate::common::run(&words).status.code()
    };
    assert_eq!(check(&[], &path("whole.yaml")), Some(1));
    for part in ["1/2", "2/2"] {
        let report = path(&format!("part-{}.yaml", &part[..1]));
        assert!(check(&["--shard", part], &report).is_some_and(|status| status < 2));
    }
    let (first, second) = (path("part-1.yaml"), path("part-2.yaml"));
    let merged = crate::common::run(&[
        "report",
        "merge",
        &first,
        &second,
        "--report",
        &path("merged.yaml"),
    ]);
    assert_eq!(
        merged.status.code(),
        Some(1),
        "{}",
        String::from_utf8_lossy(&merged.stderr)
    );
    let read = |name: &str| std::fs::read_to_string(path(name)).expect("a report");
    assert_eq!(read("merged.yaml"), read("whole.yaml"));
    let missing = crate::common::run(&["report", "merge", &first]);
    assert_eq!(missing.status.code(), Some(2));
}
