//! The matrix of cases and misreadings: which cases catch which misreadings, and which misreadings the suite distinguishes.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Mutex;

use crate::diagnose::{can_affect_file, decode_stream_cached};
use crate::pipeline::{Explain, judge_answers};
use crate::session::{plan::RunPlan, run::Run};
use ptm::reading::Reading;
use ptm_mistakes::Misreading;
use ptm_mistakes::texture::Change;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::outcome::Outcome;
use ptm_suite::{test_case::TestCase, texture::cases::TextureCase};
use ptm_texture::Rules;

/// Results of a suite for a decoder with one mistake.
pub struct MatrixRow<A: 'static = ptm_mistakes::Change> {
    /// Mistake of the decoder.
    pub misreading: &'static Misreading<A>,
    /// Indices of the failing cases, in suite order.
    pub killed_by: Vec<usize>,
    /// Hash of the answer to each case.
    pub answers: Vec<u64>,
}

/// Answers, indexed by case and view.
pub type KnownAnswers<C> = HashMap<String, Answer<<C as TestCase>::Output>>;

/// Runs the suite of PTM files against every misreading. `progress` receives the number of finished misreadings and the total.
#[must_use]
pub fn matrix(suite: &Suite, jobs: usize, progress: &dyn Fn(usize, usize)) -> Vec<MatrixRow> {
    let (_, correct) = run_with_mistakes(suite, &[], &[], jobs, &HashMap::new());
    let all = ptm_mistakes::all().count();
    let rows = ptm_mistakes::all().enumerate().map(|(i, misreading)| {
        let results = run_with_mistakes(suite, &[misreading], &[], jobs, &correct);
        progress(i + 1, all);
        matrix_row(suite, misreading, results, Frame::hash)
    });
    rows.collect()
}

/// Runs the suite of texture questions against every misreading.
#[must_use]
pub fn texture_matrix(suite: &Suite<TextureCase>, jobs: usize) -> Vec<MatrixRow<Change>> {
    let rows = ptm_mistakes::texture::all().map(|misreading| {
        let rules = misreading.apply_to(Rules::SPEC);
        let ask = |request: &Request<'_, _>| {
            let case = suite.case(request.name).expect("the case exists");
            case.answer(&rules)
        };
        let results = run_and_answers(suite, &RunPlan::new(suite, jobs), &ask);
        let digest = |answer: &_, hasher: &mut _| ToString::to_string(answer).hash(hasher);
        matrix_row(suite, misreading, results, digest)
    });
    rows.collect()
}

fn matrix_row<C: TestCase, A: 'static>(
    suite: &Suite<C>,
    misreading: &'static Misreading<A>,
    (run, answers): (Run<C>, KnownAnswers<C>),
    digest: impl Fn(&C::Output, &mut DefaultHasher),
) -> MatrixRow<A> {
    let digest = |answer: &Answer<C::Output>| {
        let mut hasher = DefaultHasher::new();
        answer.name().hash(&mut hasher);
        if let Answer::Decoded(output) = answer {
            digest(output, &mut hasher);
        }
        hasher.finish()
    };
    let observed = suite.cases.iter().zip(&run.observations);
    let digests = observed.map(|(case, observation)| {
        let view = &observation.as_ref()?.view;
        answers.get(&answer_key::<C>(case.id(), view)).map(digest)
    });
    MatrixRow {
        misreading,
        killed_by: run.judgment.with_outcome(Outcome::Fail).collect(),
        answers: digests.map(Option::unwrap_or_default).collect(),
    }
}

/// Runs the suite against a decoder with these mistakes. Requests only `views`, or all views if the list is empty. Returns the
/// run and the answers. For files that no mistake can affect, reuses the answers in `correct`, if available.
#[must_use]
pub fn run_with_mistakes(
    suite: &Suite,
    mistakes: &[&Misreading],
    views: &[ViewKind],
    jobs: usize,
    correct: &KnownAnswers<Case>,
) -> (Run, KnownAnswers<Case>) {
    let reading = Reading {
        stream: decode_stream_cached,
        ..Reading::SPEC
    };
    let ask = |request: &Request<'_>| {
        let known = correct.get(&answer_key::<Case>(request.name, request.view));
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
fn run_and_answers<C: Explain>(
    suite: &Suite<C>,
    plan: &RunPlan,
    ask: &(dyn Fn(&Request<'_, C::View>) -> Answer<C::Output> + Sync),
) -> (Run<C>, KnownAnswers<C>) {
    let answers = Mutex::new(HashMap::new());
    let record = |request: &Request<'_, C::View>, _: usize| {
        let answer = ask(request);
        let key = answer_key::<C>(request.name, request.view);
        let mut answers = answers.lock().expect("no worker panics");
        answers.insert(key, answer.clone());
        answer.into()
    };
    let run = judge_answers(suite, plan, &record);
    (run, answers.into_inner().expect("no worker panics"))
}

fn answer_key<C: TestCase>(name: &str, view: &C::View) -> String {
    format!("{name} {view}")
}
