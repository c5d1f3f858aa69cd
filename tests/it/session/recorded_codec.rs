//! The recorded answers of a decoder whose JPEG planes come from the crate jpeg-decoder 0.3.2, with its vectorized code
//! (`scripts/jpeg-decoder`, x86-64 with SSSE3). Everything else comes from the reference. The recording lacks one image of 1.3 MB,
//! that of `stream-beyond-64-kib-jpeg-lrgb`, which passed.

use std::collections::HashMap;

use ptm_harness::session::plan::RunPlan;
use ptm_suite::cases::{Case, TableSpelling};
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};
use ptm_suite::verdicts::outcome::Outcome;

use crate::in_process::{self, jobs, reference_answer, suite};
use crate::recordings::{digest, recording};

#[test]
fn jpeg_decoder_0_3_2_fails_the_saturated_cells() {
    let suite = suite();
    // `None` is the expected answer.
    let answers: HashMap<(String, String), Option<Answer<Frame>>> = recording("jpeg-decoder-0.3.2")
        .into_iter()
        .map(|recorded| ((recorded.file, recorded.view), recorded.answer))
        .collect();
    let is_recorded = |case: &Case| {
        let file = digest(&case.build(TableSpelling::default()).file);
        answers.contains_key(&(file, "raw".to_owned()))
    };
    let is_selected =
        |case: &Case| case.clauses.iter().any(|clause| clause == "2.9.8/11") && is_recorded(case);
    let plan = RunPlan {
        selected: suite.cases.iter().map(is_selected).collect(),
        views: vec![ViewKind::Raw],
        ..RunPlan::new(&suite, jobs())
    };
    let run = in_process::run(&suite, &plan, |request| {
        let key = (digest(request.file), request.view.to_string());
        let recorded = answers.get(&key).cloned().flatten();
        recorded.unwrap_or_else(|| reference_answer(request))
    });
    let failing = run.judgment.with_outcome(Outcome::Fail);
    let failing: Vec<&str> = failing.map(|i| suite.cases[i].id.as_str()).collect();
    let (saturated, others): (Vec<&str>, Vec<&str>) = failing
        .iter()
        .partition(|id| id.starts_with("saturated-cells-"));
    assert_eq!(others, Vec::<&str>::new());
    for format in ["-jpeg-rgb", "-jpeg-lrgb"] {
        assert!(
            saturated.iter().any(|id| id.ends_with(format)),
            "{saturated:?}"
        );
    }
    // The other cases of lossy planes pass, as before these cases existed.
    assert!(run.judgment.with_outcome(Outcome::Pass).count() >= 42);
}
