//! Differential fuzzing of a decoder: random files of all formats are judged like cases, grouped by cause, and minimized.
//!
//! Files are generated in batches, and a batch runs like the suite, with the same verdicts, dialect and tolerances.
//! Failures are grouped by the misreadings that explain them, not by their bytes, and the first of each group is minimized
//! while it fails in the same way. Equal seeds give equal files.

pub mod draft;
pub mod draws;
pub mod find;
pub mod minimise;
pub mod properties;
pub mod reduce;
mod shrink;
pub mod write;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::diagnose::{diagnose, dialect_reading};
use crate::protocol::capabilities::Capabilities;
use crate::ptm::Format;
use crate::report::document::LikelyCause;
use crate::report::make::likely_causes;
use crate::runner::run::Request;
use crate::session::asking::Ask;
use crate::session::outcome::Outcome;
use crate::session::plan::{Repeat, RunPlan};
use crate::session::run::{Run, check};
use crate::suite::cases::{Case, Expect, Suite};
use draft::Draft;
use draws::DraftGenerator;
use find::{Explanation, Find, KnownDecoder, MAX_WITNESSES};

/// Number of files that are generated and judged together.
const BATCH_SIZE: usize = 500;

/// The plan of a run.
#[derive(Clone, Debug)]
pub struct FuzzPlan {
    /// The seed.
    pub seed: u64,
    /// Number of requests after which no further batch is started.
    pub executions: usize,
    /// Number of parallel requests, at least 1.
    pub jobs: usize,
    /// Requested views; if empty, all views that the decoder offers.
    pub views: Vec<String>,
    /// The declared capabilities of the decoder.
    pub declared: Capabilities,
    /// Formats to generate; if empty, all formats.
    pub formats: Vec<Format>,
    /// Set when the run is to end.
    pub stop: Arc<AtomicBool>,
}

/// The results of a run.
#[derive(Default)]
pub struct FuzzResult {
    /// Number of requests.
    pub executions: usize,
    /// Number of generated files.
    pub files: usize,
    /// Mistakes, in the order in which they were found.
    pub finds: Vec<Find>,
    /// The reason why the program is not a decoder, if it is not.
    pub not_a_decoder: Option<String>,
    /// The reason why the run ended before its limit, if it did.
    pub ended_early: Option<&'static str>,
}

/// A progress message.
pub enum FuzzProgress<'a> {
    /// Number of requests so far.
    Executions(usize),
    /// A new mistake, already minimized.
    Found(&'a Find),
}

/// Fuzzes a decoder. Calls `tell` for every find as soon as it is minimized.
pub fn fuzz(
    suite: &Suite,
    plan: &FuzzPlan,
    ask: &Ask,
    tell: &(impl Fn(FuzzProgress) + Sync),
) -> FuzzResult {
    let counted = AtomicUsize::new(0);
    let ask = |request: &Request, worker: usize| {
        let before = counted.fetch_add(1, Ordering::Relaxed);
        tell(FuzzProgress::Executions(before + 1));
        ask(request, worker)
    };
    let opening_cases = opening_cases(suite);
    let draws = DraftGenerator::new(suite);
    let mut outcomes = FuzzResult::default();
    let mut number = 0;
    while counted.load(Ordering::Relaxed) < plan.executions && !plan.stop.load(Ordering::Relaxed) {
        let batch = Batch::draw(plan, &opening_cases, &draws, number);
        number += 1;
        outcomes.files += batch.drafts.len();
        let mut run = run(&batch.suite, plan, &ask);
        let why = run.not_a_decoder.take();
        if why.is_some() && number == 1 {
            outcomes.not_a_decoder = why;
            break;
        }
        let decoder = KnownDecoder {
            ask: &ask,
            offer: run.offer.clone(),
            table: run.table,
            reading: dialect_reading(&run),
        };
        batch.sort(&run, &decoder, &mut outcomes.finds, tell, plan);
        if run.ended_early.is_some() {
            outcomes.ended_early = run.ended_early;
            break;
        }
    }
    outcomes.executions = counted.into_inner();
    outcomes
}

fn run(suite: &Suite, plan: &FuzzPlan, ask: &Ask) -> Run {
    let plan = RunPlan {
        views: plan.views.clone(),
        repeat: Repeat::Failures,
        stop: Arc::clone(&plan.stop),
        ..RunPlan::new(suite, plan.jobs).declared_by(&plan.declared)
    };
    check(suite, &plan, &ask, &|_, _, _, _| ())
}

/// Returns the cases at the beginning of every batch: first files and the spellings of a table.
fn opening_cases(suite: &Suite) -> Vec<Case> {
    let opens = |case: &&Case| case.first || case.expect == Expect::Spelling;
    suite.cases.iter().filter(opens).cloned().collect()
}

/// Files that are generated and judged together.
struct Batch {
    suite: Suite,
    drafts: Vec<Draft>,
}

impl Batch {
    fn draw(plan: &FuzzPlan, opening_cases: &[Case], draws: &DraftGenerator, number: u64) -> Batch {
        let mut cases = opening_cases.to_vec();
        let mut drafts = Vec::new();
        for place in 0..BATCH_SIZE as u64 {
            let draft = draws.file(plan.seed, number * BATCH_SIZE as u64 + place);
            let wanted =
                |draft: &Draft| plan.formats.is_empty() || plan.formats.contains(&draft.format);
            let Some(draft) = draft.filter(wanted) else {
                continue;
            };
            // Drafts that cannot be written (for example, a damage without a place in the file) are skipped.
            if let Ok(drawn) = draft.cases(&format!("draft-{}", drafts.len())) {
                cases.extend(drawn);
                drafts.push(draft);
            }
        }
        let suite = Suite { cases };
        Batch { suite, drafts }
    }

    /// Adds every failure to the find with the same cause, or makes a new find.
    fn sort(
        &self,
        run: &Run,
        decoder: &KnownDecoder,
        finds: &mut Vec<Find>,
        tell: &impl Fn(FuzzProgress),
        plan: &FuzzPlan,
    ) {
        let passed = self.with_outcome(run, Outcome::Pass);
        let passed: Vec<&Draft> = passed.map(|(draft, _)| draft).collect();
        // Wrong images first: their causes often explain wrong acceptances, too.
        let (accepted, others): (Vec<_>, Vec<_>) = self
            .with_outcome(run, Outcome::Fail)
            .partition(|(draft, _)| draft.damage.is_some());
        for (draft, place) in others.into_iter().chain(accepted) {
            let Some(observation) = &run.observations[place] else {
                continue;
            };
            let mut places = 0..finds.len();
            let explains =
                |&i: &usize| finds[i].cause.explains_failure(draft, observation, decoder);
            if let Some(known) = places.find(explains) {
                finds[known].seen += 1;
                continue;
            }
            let cause = Explanation::find(draft, observation, &passed, decoder);
            let mut find = Find::new(draft, cause, decoder, &plan.stop);
            if let Explanation::Other(_) = find.cause {
                find.diagnosis = self.diagnosis(run, &find.small, decoder, plan);
            }
            tell(FuzzProgress::Found(&find));
            finds.push(find);
        }
    }

    /// Returns the cause that the diagnosis finds for a failing file, from its answer and from files that pass.
    fn diagnosis(
        &self,
        run: &Run,
        failing: &Draft,
        decoder: &KnownDecoder,
        plan: &FuzzPlan,
    ) -> Option<LikelyCause> {
        let mut cases = opening_cases(&self.suite);
        let passed = self.with_outcome(run, Outcome::Pass);
        let legal = passed.filter(|(draft, _)| draft.damage.is_none());
        let legal = legal.take(MAX_WITNESSES);
        cases.extend(legal.map(|(_, place)| self.suite.cases[place].clone()));
        cases.extend(failing.cases("found").ok()?);
        let suite = Suite { cases };
        let run = self::run(&suite, plan, decoder.ask);
        let causes = diagnose(&suite, &run, &[], plan.jobs);
        let causes = likely_causes(&suite, &causes.diagnoses).into_iter();
        let mut causes = causes.filter(|cause| cause.explains.iter().any(|id| id == "found"));
        causes.next()
    }

    /// Returns the drafts with this outcome, and the indices of their cases.
    fn with_outcome<'a>(
        &'a self,
        run: &'a Run,
        outcome: Outcome,
    ) -> impl Iterator<Item = (&'a Draft, usize)> {
        let places = run.judgement.with_outcome(outcome);
        places.filter_map(|place| {
            let id = self.suite.cases[place].id.strip_prefix("draft-")?;
            // The twin `-whole` of a damaged draft fails as a draft without damage.
            Some((&self.drafts[id.parse::<usize>().ok()?], place))
        })
    }
}
