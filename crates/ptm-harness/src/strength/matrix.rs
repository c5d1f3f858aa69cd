//! The matrix of cases and misreadings: which cases catch which misreadings, and which misreadings the suite distinguishes.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Mutex;

use serde_json::Value;

use crate::diagnose::{can_affect_file, decode_stream_cached};
use crate::pipeline::{self, judge_answers};
use crate::session::texture::TextureObservation;
use crate::session::{plan::RunPlan, run::Run};
use ptm::reading::Reading;
use ptm_mistakes::Misreading;
use ptm_mistakes::texture::Change;
use ptm_suite::cases::Suite;
use ptm_suite::protocol::frame::{Answer, Frame, View, ViewKind};
use ptm_suite::protocol::request::Request;
use ptm_suite::texture::cases::{TextureCase, TextureView};
use ptm_suite::verdicts::outcome::Outcome;
use ptm_texture::Rules;

/// Results of a suite for a decoder with one mistake.
#[derive(Clone)]
pub struct MatrixRow<A: 'static = ptm_mistakes::Change> {
    /// Mistake of the decoder.
    pub misreading: &'static Misreading<A>,
    /// Indices of the failing cases, in suite order.
    pub killed_by: Vec<usize>,
    /// Hash of the answer to each case.
    pub answers: Vec<u64>,
}

/// Answers, indexed by case and view.
pub type KnownAnswers = HashMap<String, Answer>;

/// Runs the suite of PTM files against every misreading. `progress` receives the number of finished misreadings and the total.
#[must_use]
pub fn matrix(suite: &Suite, jobs: usize, progress: &dyn Fn(usize, usize)) -> Vec<MatrixRow> {
    let (_, correct) = run_with_mistakes(suite, &[], &[], jobs, &HashMap::new());
    let all = ptm_mistakes::all().count();
    let rows = ptm_mistakes::all().enumerate().map(|(i, misreading)| {
        let results = run_with_mistakes(suite, &[misreading], &[], jobs, &correct);
        progress(i + 1, all);
        matrix_row(suite, misreading, results)
    });
    rows.collect()
}

/// Runs the suite of texture questions against every misreading.
#[must_use]
pub fn texture_matrix(suite: &Suite<TextureCase>, jobs: usize) -> Vec<MatrixRow<Change>> {
    let plan = RunPlan::new(suite, jobs);
    let rows = ptm_mistakes::texture::all().map(|misreading| {
        let rules = misreading.apply_to(Rules::SPEC);
        let ask = |request: &Request<'_, TextureView>, _: usize| {
            let case = suite.case(request.name).expect("the case exists");
            case.answer(&rules).into()
        };
        let run = pipeline::texture::judge_answers(suite, &plan, &ask);
        let digest = |(case, observation): (&TextureCase, &Option<TextureObservation>)| {
            let digest = |answer: &Value, hasher: &mut _| answer.to_string().hash(hasher);
            let answer = observation.as_ref().map(|_| case.answer(&rules));
            answer.map_or(0, |answer| hash_answer(&answer, digest))
        };
        MatrixRow {
            misreading,
            killed_by: run.judgment.with_outcome(Outcome::Fail).collect(),
            answers: suite
                .cases
                .iter()
                .zip(&run.observations)
                .map(digest)
                .collect(),
        }
    });
    rows.collect()
}

fn matrix_row(
    suite: &Suite,
    misreading: &'static Misreading,
    (run, answers): (Run, KnownAnswers),
) -> MatrixRow {
    let observed = suite.cases.iter().zip(&run.observations);
    let digests = observed.map(|(case, observation)| {
        let view = &observation.as_ref()?.view;
        let answer = answers.get(&answer_key(&case.id, view))?;
        Some(hash_answer(answer, Frame::hash))
    });
    MatrixRow {
        misreading,
        killed_by: run.judgment.with_outcome(Outcome::Fail).collect(),
        answers: digests.map(Option::unwrap_or_default).collect(),
    }
}

/// Returns a hash of an answer. `hash_output` hashes an output.
fn hash_answer<T>(answer: &Answer<T>, hash_output: impl Fn(&T, &mut DefaultHasher)) -> u64 {
    let mut hasher = DefaultHasher::new();
    answer.name().hash(&mut hasher);
    if let Answer::Decoded(output) = answer {
        hash_output(output, &mut hasher);
    }
    hasher.finish()
}

/// Runs the suite against a decoder with these mistakes. Requests only `views`, or all views if the list is empty. Returns the
/// run and the answers. For files that no mistake can affect, reuses the answers in `correct`, if available.
#[must_use]
pub fn run_with_mistakes(
    suite: &Suite,
    mistakes: &[&Misreading],
    views: &[ViewKind],
    jobs: usize,
    correct: &KnownAnswers,
) -> (Run, KnownAnswers) {
    let reading = Reading {
        stream: decode_stream_cached,
        ..Reading::SPEC
    };
    let ask = |request: &Request<'_>| {
        let known = correct.get(&answer_key(request.name, request.view));
        let can_affect = |mistake: &&Misreading| can_affect_file(mistake, request.file);
        let known = known.filter(|_| !mistakes.iter().any(can_affect)).cloned();
        let compute = || ptm_mistakes::answer(mistakes, reading, request.file, request.view);
        known.unwrap_or_else(compute)
    };
    let plan = RunPlan {
        views: views.to_vec(),
        ..RunPlan::new(suite, jobs)
    };
    run_and_answers(suite, &plan, &ask)
}

/// Runs the suite and records every answer.
fn run_and_answers(
    suite: &Suite,
    plan: &RunPlan,
    ask: &(dyn Fn(&Request<'_>) -> Answer + Sync),
) -> (Run, KnownAnswers) {
    let answers = Mutex::new(HashMap::new());
    let record = |request: &Request<'_>, _: usize| {
        let answer = ask(request);
        let key = answer_key(request.name, request.view);
        let mut answers = answers.lock().expect("no worker panics");
        answers.insert(key, answer.clone());
        answer.into()
    };
    let run = judge_answers(suite, plan, &record);
    (run, answers.into_inner().expect("no worker panics"))
}

fn answer_key(name: &str, view: &View) -> String {
    format!("{name} {view}")
}
