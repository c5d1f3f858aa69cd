//! What public readers answered to the suite, judged and diagnosed again. Skipped where the shared data is absent.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ptm_conform::Reading;
use ptm_conform::diagnose::{Cause, diagnose};
use ptm_conform::misreadings;
use ptm_conform::protocol::frame::{Answer, Frame};
use ptm_conform::report::shards::Kept;
use ptm_conform::runner::run::{Reply, Request};
use ptm_conform::session::outcome::Outcome;
use ptm_conform::session::plan::{Repeat, RunPlan};
use ptm_conform::session::run::{Run, check};
use ptm_conform::suite::cases::{Case, Suite, TableSpelling};
use sha2::{Digest, Sha256};

/// The beginning of a digest, as answers are kept under.
fn digest(file: &[u8]) -> String {
    let digest = Sha256::digest(file);
    digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn answers(reader: &str) -> Option<PathBuf> {
    let name = format!("../shared/evidence/runs/{reader}.answers");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    if path.is_file() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there", path.display());
    None
}

/// The answers by file and view. Files that the suite no longer has are never asked for.
fn kept(path: &Path) -> HashMap<(String, String), Kept<Frame>> {
    let text = std::fs::read_to_string(path).expect("the answers are text");
    let answers = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    answers
        .filter(|kept: &Kept<Frame>| !kept.alone)
        .map(|kept| ((kept.file.clone(), kept.view.clone()), kept))
        .collect()
}

/// The run as it was, of all cases whose answers were kept.
fn replayed(suite: &Suite, path: &Path) -> Run {
    let known = kept(path);
    let is_kept = |case: &Case| {
        TableSpelling::all().any(|table| {
            let file = digest(&case.build(table).file);
            let mut views = case.views.iter();
            views.any(|view| known.contains_key(&(file.clone(), view.to_string())))
        })
    };
    let withheld = |case: &Case| (!is_kept(case)).then(|| "no answer was kept".to_owned());
    let plan = RunPlan {
        selected: vec![true; suite.cases.len()],
        jobs: 2,
        views: Vec::new(),
        soonest: Vec::new(),
        declared_views: None,
        declared_kinds: None,
        repeat: Repeat::Nothing,
        withheld: suite.cases.iter().map(withheld).collect(),
        precomputed: false,
        stop: Arc::new(AtomicBool::new(false)),
    };
    let ask = |request: &Request<'_>, _: usize| -> Reply {
        let key = (digest(request.file), request.view.to_string());
        let Some(kept) = known.get(&key) else {
            return Answer::Unsupported.into();
        };
        // The expected picture is not kept.
        let answer = kept
            .answer
            .clone()
            .unwrap_or_else(|| misreadings::answer(&[], Reading::SPEC, request.file, request.view));
        Reply {
            stderr: kept.stderr.clone(),
            exit: kept.exit,
            ..answer.into()
        }
    };
    check(suite, &plan, &ask, &|_, _, _, _| ())
}

/// Every cause that is said of a reader: how many cases it explains, its name and its words.
fn causes(reader: &str) -> Option<Vec<(usize, String)>> {
    let path = answers(reader)?;
    let suite = Suite::load().expect("the suite loads").prepared();
    let run = replayed(&suite, &path);
    let judged = run.judgement.cases.iter().flatten();
    let failures = judged
        .filter(|judged| judged.outcome == Outcome::Fail)
        .count();
    assert!(failures > 100, "{reader} fails {failures} cases");
    let found = diagnose(&suite, &run, &[], 2);
    assert!(found.faults.is_empty(), "{:?}", found.faults);
    let causes = found.diagnoses.into_iter().map(|diagnosis| {
        let words = match diagnosis.cause {
            Cause::Misreading { misreading, .. } => misreading.slug.to_owned(),
            Cause::Described { effect, .. } => effect,
        };
        (diagnosis.explains.len(), words)
    });
    let causes: Vec<(usize, String)> = causes.collect();
    for cause in &causes {
        println!("  {cause:?}");
    }
    Some(causes)
}

#[track_caller]
fn says(reader: &str, known: &[&str], false_ones: &[&str]) {
    let Some(causes) = causes(reader) else { return };
    let is_said = |words: &str| causes.iter().any(|(_, says)| says.contains(words));
    for words in known {
        assert!(is_said(words), "{reader}: {words:?} is not said");
    }
    for words in false_ones {
        assert!(
            !is_said(words),
            "{reader}: {words:?} is said, and is not so"
        );
    }
}

#[test]
fn a_reader_that_ignores_motion_and_takes_numbers_by_prefix() {
    says(
        "cceh",
        &[
            "motion-ignored",
            "numbers-by-prefix",
            "short-payload-padded",
        ],
        &["motion-two-lines-only", "motion-on-one-line-only"],
    );
}

#[test]
fn a_reader_that_refuses_transforms_and_one_line_headers() {
    says(
        "relight",
        &[
            "rgb-planes-coefficient-major",
            "every file with a transform other than 0",
            "size-two-lines-only",
            "scale-bias-two-lines-only",
            "double-space-dies",
        ],
        &["numbers-by-prefix"],
    );
}

#[test]
fn a_reader_that_once_ended_the_search() {
    says("rtiviewer", &["size-two-lines-only"], &[]);
}
