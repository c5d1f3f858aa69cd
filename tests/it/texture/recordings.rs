//! Judges the recorded answers of texture stages whose sampling was done by a GPU: an NVIDIA H200, driver 580.159.04.
//!
//! In the recordings, `null` means that the answer was the expected one when it was recorded.

use std::collections::HashMap;

use ptm_harness::pipeline::texture::judge_answers;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::session::texture::TextureRun;
use ptm_suite::cases::Suite;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::texture::cases::{TextureCase, TextureView};
use ptm_suite::texture::choices::CHOICES;
use ptm_suite::texture::compare::ExpectedAnswer;
use ptm_suite::verdicts::outcome::Outcome;
use ptm_texture::Rules;
use serde_json::Value;

use crate::recordings::{digest, recording};

/// Cases that are newer than the recordings.
const NEW_CASES: [&str; 5] = ["BND-73", "BND-74", "BND-75", "DEP-58", "SMP-73"];

/// Cases whose expected answer has changed since the recording, so `null` does not tell what the stage answered.
const CHANGED_CASES: [&str; 1] = ["DEP-05"];

/// Cases in which weights of 8 bits exceed single precision.
const CASES_OF_INEXACT_WEIGHTS: [&str; 8] = [
    "SMP-08", "SMP-11", "SMP-21", "SMP-52", "SMP-59", "SMP-60", "BND-26", "PTM-56",
];

struct Recording {
    suite: Suite<TextureCase>,
    /// Recorded answers by case; `None` is the expected answer.
    answers: HashMap<String, Option<Answer<Value>>>,
}

impl Recording {
    fn load(stage: &str) -> Recording {
        let suite: Suite<TextureCase> = Suite::load_texture().expect("the suite loads");
        let mut answers = HashMap::new();
        for recorded in recording(stage) {
            let case = suite.case(&recorded.case).expect("ids are permanent");
            let question = case.to_file();
            assert_eq!(digest(&question), recorded.file, "{}", case.id);
            answers.insert(recorded.case, recorded.answer);
        }
        let missing = suite.cases.iter().map(|case| case.id.as_str());
        let mut missing: Vec<&str> = missing.filter(|id| !answers.contains_key(*id)).collect();
        missing.sort_unstable();
        assert_eq!(missing, NEW_CASES, "{stage}");
        Recording { suite, answers }
    }

    /// Judges the answers to all cases that are neither new nor changed.
    fn replay(&self) -> TextureRun {
        let withheld = self.suite.cases.iter().map(|case| match case.id.as_str() {
            id if NEW_CASES.contains(&id) => Some("newer than the recording".to_owned()),
            id if CHANGED_CASES.contains(&id) => Some("expected another answer".to_owned()),
            _ => None,
        });
        let plan = RunPlan {
            repeat: Repeat::Nothing,
            withheld: withheld.collect(),
            ..RunPlan::new(&self.suite, 1)
        };
        let ask = |request: &Request<'_, TextureView>, _: usize| -> Reply<Value> {
            let case = self.suite.case(request.name).expect("the case exists");
            let answer = self.answers[request.name].clone();
            answer.unwrap_or_else(|| case.answer(&Rules::SPEC)).into()
        };
        judge_answers(&self.suite, &plan, &ask)
    }

    fn failures(&self, run: &TextureRun) -> Vec<&str> {
        let failing = run.judgment.with_outcome(Outcome::Fail);
        failing.map(|i| self.suite.cases[i].id.as_str()).collect()
    }

    /// Returns the cases whose recorded answer is outside single precision, but within the tolerance of filters.
    fn cases_of_inexact_weights(&self) -> Vec<&str> {
        let is_inexact = |case: &&TextureCase| {
            let expected = case.expected(&CHOICES.reference());
            let exact = ExpectedAnswer {
                filter_tolerance: Value::Null,
                ..expected.clone()
            };
            match self.answers.get(&case.id) {
                Some(Some(Answer::Decoded(answer))) => {
                    exact.difference(answer).is_some() && expected.difference(answer).is_none()
                }
                _ => false,
            }
        };
        let cases = self.suite.cases.iter().filter(is_inexact);
        cases.map(|case| case.id.as_str()).collect()
    }
}

/// Returns the reading of a choice that a run shows.
fn reading(run: &TextureRun, ruling: &str) -> &'static str {
    let axis = CHOICES.axes(&[ruling])[0];
    CHOICES[axis].readings[run.judgment.dialect.0[axis]].0
}

#[test]
fn opengl_passes_and_lets_the_bias_select_the_mode() {
    let recording = Recording::load("h200-opengl-rgba32f");
    let run = recording.replay();
    assert_eq!(recording.failures(&run), Vec::<&str>::new());
    assert_eq!(run.exit_status(), 0);
    assert_eq!(reading(&run, "bias-and-mode"), "biased depth");
    assert_eq!(reading(&run, "texel-grid"), "cells");
    assert_eq!(
        recording.cases_of_inexact_weights(),
        CASES_OF_INEXACT_WEIGHTS
    );
}

#[test]
fn cuda_passes() {
    let recording = Recording::load("h200-cuda-rgba32f");
    let run = recording.replay();
    assert_eq!(recording.failures(&run), Vec::<&str>::new());
    assert_eq!(run.exit_status(), 0);
    assert_eq!(reading(&run, "bias-and-mode"), "span");
    assert_eq!(
        recording.cases_of_inexact_weights(),
        CASES_OF_INEXACT_WEIGHTS
    );
}

/// `GL_CLAMP_TO_BORDER` treats coordinate 1 as outside.
#[test]
fn explicit_clamp_by_a_hardware_border_fails_only_at_coordinate_one() {
    let recording = Recording::load("h200-opengl-rgba32f-border");
    let run = recording.replay();
    assert_eq!(recording.failures(&run), ["BND-54"]);
    assert_eq!(reading(&run, "bias-and-mode"), "biased depth");
}
