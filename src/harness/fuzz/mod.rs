//! Differential fuzzing of a decoder: random files of all formats, judged as cases are, grouped by cause, made small.
//!
//! Files are drawn in batches, and a batch is run as the suite is: the same verdicts, the same dialect, the same
//! tolerance. What fails is grouped by the misreadings that would have failed alike, not by its bytes, and the first of
//! each group is made as small as it can be while it fails alike. The same seed draws the same files.

pub mod draft;
pub mod find;
pub mod minimise;
pub mod reduce;
pub mod write;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use arbitrary::Unstructured;

use crate::harness::capabilities::Capabilities;
use crate::harness::cases::{Case, Expect, Suite};
use crate::harness::check::{self, Repeat, Run, check};
use crate::harness::diagnose::spoken;
use crate::harness::judge::Outcome;
use crate::harness::run::{Reply, Request};
use crate::ptm::Format;
use draft::{Damage, Draft};
use find::{Cause, Decoder, Find};

/// Files drawn and judged together.
const BATCH: usize = 500;
/// One file in so many is damaged, and must be refused.
const DAMAGED: u32 = 6;
/// Random bytes behind one file.
const BYTES: usize = 2048;

/// What is drawn, and how much of it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Where the draws start.
    pub seed: u64,
    /// Requests after which no further batch is begun.
    pub executions: usize,
    /// Requests at a time, at least 1.
    pub jobs: usize,
    /// Views to ask for; all that the decoder offers if empty.
    pub views: Vec<&'static str>,
    /// What the decoder says of itself.
    pub declared: Capabilities,
    /// Only these formats; all if empty.
    pub formats: Vec<Format>,
    /// Set when the run is to end.
    pub stop: Arc<AtomicBool>,
}

/// What came of it.
#[derive(Default)]
pub struct Outcomes {
    /// Requests sent.
    pub executions: usize,
    /// Files drawn.
    pub files: usize,
    /// Mistakes, in the order in which they were found.
    pub finds: Vec<Find>,
    /// Why the program is no decoder, if it is none.
    pub not_a_decoder: Option<String>,
    /// Why the run ended before its bound, if it did.
    pub ended_early: Option<&'static str>,
}

/// What is told while the run goes on.
pub enum News<'a> {
    /// Requests so far.
    Executions(usize),
    /// A mistake not seen before, already made small.
    Found(&'a Find),
}

/// Fuzzes a decoder. `tell` hears of every find as soon as it is made small.
pub fn fuzz(
    suite: &Suite,
    plan: &Plan,
    ask: &(impl Fn(&Request, usize) -> Reply + Sync),
    tell: &(impl Fn(News) + Sync),
) -> Outcomes {
    let counted = AtomicUsize::new(0);
    let ask = |request: &Request, worker: usize| {
        tell(News::Executions(
            counted.fetch_add(1, Ordering::Relaxed) + 1,
        ));
        ask(request, worker)
    };
    let opening = opening(suite);
    let draws = Draws::of(suite);
    let mut outcomes = Outcomes::default();
    let mut number = 0;
    while counted.load(Ordering::Relaxed) < plan.executions && !plan.stop.load(Ordering::Relaxed) {
        let batch = Batch::draw(plan, &opening, &draws, number);
        number += 1;
        outcomes.files += batch.drafts.len();
        let run = run(&batch.suite, plan, &ask);
        if let Some(why) = run.not_a_decoder.filter(|_| number == 1) {
            outcomes.not_a_decoder = Some(why);
            break;
        }
        let run = Run {
            not_a_decoder: None,
            ..run
        };
        let decoder = Decoder {
            ask: &ask,
            offer: run.offer.clone(),
            table: run.table,
            reading: spoken(&run),
        };
        batch.sort(&run, &decoder, &mut outcomes.finds, tell, &plan.stop);
        if run.ended_early.is_some() {
            outcomes.ended_early = run.ended_early;
            break;
        }
    }
    outcomes.executions = counted.into_inner();
    outcomes
}

fn run(suite: &Suite, plan: &Plan, ask: &(impl Fn(&Request, usize) -> Reply + Sync)) -> Run {
    let plan = check::Plan {
        views: plan.views.clone(),
        declared: plan.declared.clone(),
        repeat: Repeat::Failures,
        stop: Arc::clone(&plan.stop),
        ..check::Plan::of(suite, plan.jobs)
    };
    check(suite, &plan, ask, &|_, _, _, _| ())
}

/// The cases that every batch begins with: first files and the spellings of a table.
fn opening(suite: &Suite) -> Vec<Case> {
    let opens = |case: &&Case| case.first || case.expect == Expect::Spelling;
    suite.cases.iter().filter(opens).cloned().collect()
}

/// Where files are drawn from.
pub struct Draws {
    /// What makes a file of a format one that must be refused, whatever else is in it.
    damages: Vec<(Format, Damage)>,
}

impl Draws {
    /// Draws damages besides legal files: those of which the suite expects the same wherever it uses them.
    #[must_use]
    pub fn of(suite: &Suite) -> Draws {
        let mut expected: BTreeMap<(Format, &'static str), Vec<Expect>> = BTreeMap::new();
        for case in &suite.cases {
            if let Some(damage) = case.damage() {
                let place = expected.entry((case.format(), damage.name));
                place.or_default().push(case.expect);
            }
        }
        let damage = |((format, name), expects): (_, Vec<Expect>)| {
            let expect = expects[0];
            let settled = matches!(expect, Expect::Reject | Expect::Refuse)
                && expects.iter().all(|&other| other == expect);
            settled.then_some((format, Damage { name, expect }))
        };
        Draws {
            damages: expected.into_iter().filter_map(damage).collect(),
        }
    }

    /// The `number`th file: a legal one, or one with a damage.
    #[must_use]
    pub fn file(&self, seed: u64, number: u64) -> Option<Draft> {
        let bytes = random_bytes(seed, number);
        self.draw(&mut Unstructured::new(&bytes)).ok()
    }

    fn draw(&self, u: &mut Unstructured) -> arbitrary::Result<Draft> {
        let mut draft = Draft::draw(u)?;
        if u.ratio(1, DAMAGED)? {
            let fitting: Vec<Damage> = self
                .damages
                .iter()
                .filter(|(format, _)| *format == draft.format)
                .map(|&(_, damage)| damage)
                .collect();
            if !fitting.is_empty() {
                draft.damage = Some(*u.choose(&fitting)?);
            }
        }
        Ok(draft)
    }
}

/// Files that are drawn and judged together.
struct Batch {
    suite: Suite,
    drafts: Vec<Draft>,
}

impl Batch {
    fn draw(plan: &Plan, opening: &[Case], draws: &Draws, number: u64) -> Batch {
        let mut cases = opening.to_vec();
        let mut drafts = Vec::new();
        for place in 0..BATCH as u64 {
            let Some(draft) = draws.file(plan.seed, number * BATCH as u64 + place) else {
                continue;
            };
            if !plan.formats.is_empty() && !plan.formats.contains(&draft.format) {
                continue;
            }
            // What the writer cannot write (a damage without a place in the file, say) is not drawn.
            if let Ok(drawn) = draft.cases(&format!("draft-{}", drafts.len())) {
                cases.extend(drawn);
                drafts.push(draft);
            }
        }
        Batch {
            suite: Suite { cases },
            drafts,
        }
    }

    /// Puts every failure to the find whose cause it has, or makes a new find of it.
    fn sort<F: Fn(&Request, usize) -> Reply + Sync>(
        &self,
        run: &Run,
        decoder: &Decoder<F>,
        finds: &mut Vec<Find>,
        tell: &impl Fn(News),
        stop: &AtomicBool,
    ) {
        let passed: Vec<&Draft> = self
            .with(run, Outcome::Pass)
            .map(|(draft, _)| draft)
            .collect();
        // Wrong pictures first: what is wrong with them often explains what is accepted, too.
        let (accepted, others): (Vec<_>, Vec<_>) = self
            .with(run, Outcome::Fail)
            .partition(|(draft, _)| draft.damage.is_some());
        for (draft, place) in others.into_iter().chain(accepted) {
            let Some(finding) = &run.findings[place] else {
                continue;
            };
            if let Some(known) = finds
                .iter_mut()
                .find(|find| find.cause.also_of(draft, finding, decoder))
            {
                known.cause.narrow(draft, finding, decoder);
                known.seen += 1;
                continue;
            }
            let says = run.judgement.cases[place]
                .as_ref()
                .map(|judged| judged.says.clone())
                .unwrap_or_default();
            let cause = Cause::of(draft, finding, &passed, decoder);
            let find = Find::new(draft, cause, says, decoder, stop);
            tell(News::Found(&find));
            finds.push(find);
        }
    }

    /// Drafts with this outcome, and the places of their cases.
    fn with<'a>(
        &'a self,
        run: &'a Run,
        outcome: Outcome,
    ) -> impl Iterator<Item = (&'a Draft, usize)> {
        let judged = run.judgement.cases.iter().enumerate();
        judged
            .filter(move |(_, judged)| judged.as_ref().is_some_and(|j| j.outcome == outcome))
            .filter_map(|(place, _)| {
                let id = self.suite.cases[place].id.strip_prefix("draft-")?;
                // The twin of a damaged draft fails as a draft without damage.
                let number: usize = id.trim_end_matches("-whole").parse().ok()?;
                (!id.ends_with("-whole")).then(|| (&self.drafts[number], place))
            })
    }
}

/// The bytes behind the `number`th file: `SplitMix64` from a start of its own.
fn random_bytes(seed: u64, number: u64) -> Vec<u8> {
    let mut state = seed ^ number.wrapping_mul(0xd134_2543_de82_ef95);
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    };
    (0..BYTES / 8).flat_map(|_| next().to_le_bytes()).collect()
}
