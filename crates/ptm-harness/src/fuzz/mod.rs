//! Differential fuzzing of a decoder: random files of all formats are judged like cases, grouped by cause, and minimized.
//!
//! Files are generated in batches, and a batch is run like the suite, with the same verdicts, dialect and tolerances. Failures
//! are grouped by the misreadings that explain them. The first file of each group is minimized while it still fails in the same
//! way. Equal seeds produce equal files.

pub mod draft;
pub mod finding;
pub mod generator;
pub mod minimize;
pub mod properties;
pub mod reduce;
mod shrink;
pub mod write;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::diagnose::{diagnose, dialect_reading};
use crate::pipeline::judge_answers;
use crate::report::{document::LikelyCause, make::likely_causes};
use crate::session::plan::{Repeat, RunPlan};
use crate::session::{asking::DecoderFn, run::Run};
use draft::Draft;
use finding::{Explanation, Finding, KnownDecoder, MAX_WITNESSES};
use generator::DraftGenerator;
use ptm::Format;
use ptm_suite::cases::{Case, Expect, Suite};
use ptm_suite::protocol::capabilities::Capabilities;
use ptm_suite::protocol::frame::ViewKind;
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::outcome::Outcome;

/// Number of files that are generated and judged together.
const BATCH_SIZE: usize = 500;

/// The parameters of a fuzzing run.
#[derive(Clone, Debug)]
pub struct FuzzPlan {
    /// The seed of the file generator.
    pub seed: u64,
    /// Number of requests after which no further batch starts.
    pub executions: usize,
    /// Number of parallel requests, at least 1.
    pub jobs: usize,
    /// Requested views; if empty, all views that the decoder offers.
    pub views: Vec<ViewKind>,
    /// The declared capabilities of the decoder.
    pub declared: Capabilities,
    /// Formats to generate; if empty, all formats.
    pub formats: Vec<Format>,
    /// Number of requests so far that exceeded the higher time limit; see [`RunPlan::unanswered`].
    pub unanswered: Arc<AtomicUsize>,
    /// Set to true to stop the run.
    pub stop: Arc<AtomicBool>,
}

/// The results of a fuzzing run.
#[derive(Default)]
pub struct FuzzResult {
    /// Number of requests that were sent.
    pub executions: usize,
    /// Number of generated files.
    pub files: usize,
    /// Mistakes, in the order in which they were found.
    pub findings: Vec<Finding>,
    /// The reason why the program is not a decoder, if it is not one.
    pub not_a_decoder: Option<String>,
    /// The reason why the run ended before its limit, if it did.
    pub ended_early: Option<String>,
}

/// A progress message.
pub enum FuzzProgress<'a> {
    /// Number of requests so far.
    Executions(usize),
    /// A new finding, whose file is already minimized.
    Found(&'a Finding),
}

/// Fuzzes a decoder. Calls `report` for every request, and for every finding as soon as it is minimized.
pub fn fuzz(
    suite: &Suite,
    plan: &FuzzPlan,
    ask: &DecoderFn,
    report: &(impl Fn(FuzzProgress) + Sync),
) -> FuzzResult {
    let requests = AtomicUsize::new(0);
    let ask = |request: &Request, worker: usize| {
        let previous = requests.fetch_add(1, Ordering::Relaxed);
        report(FuzzProgress::Executions(previous + 1));
        ask(request, worker)
    };
    let opening_cases = opening_cases(suite);
    let generator = DraftGenerator::new(suite);
    let mut result = FuzzResult::default();
    let mut number = 0;
    while requests.load(Ordering::Relaxed) < plan.executions && !plan.stop.load(Ordering::Relaxed) {
        let batch = Batch::draw(plan, &opening_cases, &generator, number);
        number += 1;
        result.files += batch.drafts.len();
        let mut run = run(&batch.suite, plan, &ask);
        let reason = run.not_a_decoder.take();
        if reason.is_some() && number == 1 {
            result.not_a_decoder = reason;
            break;
        }
        let decoder = KnownDecoder {
            ask: &ask,
            offer: run.offer.clone(),
            table: run.table,
            reading: dialect_reading(&run),
        };
        batch.group_failures(&run, &decoder, &mut result.findings, report, plan);
        if run.ended_early.is_some() {
            result.ended_early = run.ended_early;
            break;
        }
    }
    result.executions = requests.into_inner();
    result
}

fn run(suite: &Suite, plan: &FuzzPlan, ask: &DecoderFn) -> Run {
    let plan = RunPlan {
        views: plan.views.clone(),
        repeat: Repeat::Failures,
        unanswered: Arc::clone(&plan.unanswered),
        stop: Arc::clone(&plan.stop),
        ..RunPlan::new(suite, plan.jobs).with_capabilities(&plan.declared)
    };
    judge_answers(suite, &plan, &ask)
}

/// Returns the cases at the beginning of every batch: the `first` cases, and the cases that spell the table count differently.
fn opening_cases(suite: &Suite) -> Vec<Case> {
    let is_opening = |case: &&Case| case.first || case.expect == Expect::Spelling;
    suite.cases.iter().filter(is_opening).cloned().collect()
}

/// Files that are generated and judged together.
struct Batch {
    suite: Suite,
    drafts: Vec<Draft>,
}

impl Batch {
    fn draw(plan: &FuzzPlan, opening: &[Case], generator: &DraftGenerator, number: u64) -> Batch {
        let mut cases = opening.to_vec();
        let mut drafts = Vec::new();
        for index in 0..BATCH_SIZE as u64 {
            let draft = generator.file(plan.seed, number * BATCH_SIZE as u64 + index);
            let is_selected =
                |draft: &Draft| plan.formats.is_empty() || plan.formats.contains(&draft.format);
            let Some(draft) = draft.filter(is_selected) else {
                continue;
            };
            // Drafts that cannot be written (for example, a damage that does not apply to the file) are skipped.
            if let Ok(drawn) = draft.cases(&format!("draft-{}", drafts.len())) {
                cases.extend(drawn);
                drafts.push(draft);
            }
        }
        let suite = Suite { cases };
        Batch { suite, drafts }
    }

    /// Adds every failure to the finding with the same cause, or creates a new finding.
    fn group_failures(
        &self,
        run: &Run,
        decoder: &KnownDecoder,
        findings: &mut Vec<Finding>,
        report: &impl Fn(FuzzProgress),
        plan: &FuzzPlan,
    ) {
        let passing = self.drafts_with_outcome(run, Outcome::Pass);
        let passing: Vec<&Draft> = passing.map(|(draft, _)| draft).collect();
        // Legal files come first: the causes of their failures often explain wrong acceptances, too.
        let (accepted, others): (Vec<_>, Vec<_>) = self
            .drafts_with_outcome(run, Outcome::Fail)
            .partition(|(draft, _)| draft.damage.is_some());
        for (draft, index) in others.into_iter().chain(accepted) {
            let Some(observation) = &run.observations[index] else {
                continue;
            };
            let explains = |f: &mut Finding| f.cause.extend_to_failure(draft, observation, decoder);
            if let Some(i) = findings.iter_mut().position(explains) {
                findings[i].count += 1;
                continue;
            }
            let cause = Explanation::find(draft, observation, &passing, decoder);
            let mut finding = Finding::new(draft, cause, decoder, &plan.stop);
            if let Explanation::Other(_) = finding.cause {
                finding.diagnosis = self.diagnosis(run, &finding.small, decoder, plan);
            }
            report(FuzzProgress::Found(&finding));
            findings.push(finding);
        }
    }

    /// Returns the cause that the diagnosis finds for a failing file, based on its answer and on passing files.
    fn diagnosis(
        &self,
        run: &Run,
        failing: &Draft,
        decoder: &KnownDecoder,
        plan: &FuzzPlan,
    ) -> Option<LikelyCause> {
        let mut cases = opening_cases(&self.suite);
        let passing = self.drafts_with_outcome(run, Outcome::Pass);
        let legal = passing.filter(|(draft, _)| draft.damage.is_none());
        let legal = legal.take(MAX_WITNESSES);
        cases.extend(legal.map(|(_, index)| self.suite.cases[index].clone()));
        cases.extend(failing.cases("found").ok()?);
        let suite = Suite { cases };
        let run = self::run(&suite, plan, decoder.ask);
        let causes = diagnose(&suite, &run, &[], plan.jobs);
        let causes = likely_causes(&suite, &causes.diagnoses).into_iter();
        let mut causes = causes.filter(|cause| cause.explains.iter().any(|id| id == "found"));
        causes.next()
    }

    fn drafts_with_outcome<'a>(
        &'a self,
        run: &'a Run,
        outcome: Outcome,
    ) -> impl Iterator<Item = (&'a Draft, usize)> {
        let indices = run.judgment.with_outcome(outcome);
        indices.filter_map(|index| {
            let id = self.suite.cases[index].id.strip_prefix("draft-")?;
            // The twin `-whole` of a damaged draft fails as a draft without damage.
            Some((&self.drafts[id.parse::<usize>().ok()?], index))
        })
    }
}
