//! Asking again: failures and a sample of the rest, of processes of their own.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use crate::protocol::frame::Answer;
use crate::session::asking::{Asking, Counting, after, side_by_side};
use crate::session::judge::Judgement;
use crate::session::observation::{Nondeterminism, Observation, Response};
use crate::session::outcome::Outcome;
use crate::session::plan::{Repeat, RunPlan, SAMPLE};
use crate::suite::cases::{Expect, Suite, TableSpelling};
use crate::suite::test_case::TestCase;

/// Of failures of one kind that look alike, so many are asked again.
const ALIKE: usize = 8;

/// A run of few requests may be asked again as a whole.
const FEW: usize = 24;

/// Asks again some of what failed, and a sample of the rest, of processes of their own; returns whether an answer differed.
///
/// What fails alike would fail alike again, so a few of each kind are asked, in all no more than a tenth of the run. Where
/// one of them differs, the rest is asked too: such an answer proves nothing of the format.
pub(super) fn ask_again<C: TestCase>(
    suite: &Suite<C>,
    plan: &RunPlan<C>,
    table: TableSpelling,
    observations: &mut [Option<Observation<C>>],
    judgement: &Judgement<C>,
    asking: &Asking<C>,
    progress: &Counting,
) -> bool {
    if plan.repeat == Repeat::Nothing {
        return false;
    }
    let wanted: Vec<usize> = (0..suite.cases.len())
        .filter(|&i| is_asked_again(suite, plan.repeat, observations, judgement, i))
        .collect();
    let (some, rest) = some_of_each_kind(suite, observations, wanted);
    let mut repeat = |places: &[usize]| {
        let asking = (asking, progress);
        let repeated = repeat_alone(suite, plan, table, observations, places, asking);
        note_differences(plan.repeat, observations, repeated)
    };
    let differs = repeat(&some);
    if differs {
        repeat(&rest);
    }
    differs
}

/// Of places that failed alike a few, spread over the suite; and the others.
fn some_of_each_kind<C: TestCase>(
    suite: &Suite<C>,
    observations: &[Option<Observation<C>>],
    wanted: Vec<usize>,
) -> (Vec<usize>, Vec<usize>) {
    let asked = observations.iter().flatten().count();
    let most = (asked / 10).max(FEW);
    let mut kinds: BTreeMap<(C::Feature, &str), Vec<usize>> = BTreeMap::new();
    for &i in &wanted {
        let response = (observations[i].as_ref()).map_or("", |seen| seen.response.name());
        kinds
            .entry((suite.cases[i].kind(), response))
            .or_default()
            .push(i);
    }
    let spread = kinds.values().flat_map(|alike| {
        let step = alike.len().div_ceil(ALIKE).max(1);
        alike.iter().copied().step_by(step)
    });
    let some: BTreeSet<usize> = spread.take(most).collect();
    wanted.into_iter().partition(|i| some.contains(i))
}

/// Two more answers to a request, the second where the first two are of different kinds.
struct Repeated<C: TestCase> {
    place: usize,
    alone: Observation<C>,
    once_more: Option<Observation<C>>,
}

/// Asks processes of their own.
fn repeat_alone<C: TestCase>(
    suite: &Suite<C>,
    plan: &RunPlan<C>,
    table: TableSpelling,
    observations: &[Option<Observation<C>>],
    places: &[usize],
    (asking, progress): (&Asking<C>, &Counting),
) -> Vec<Repeated<C>> {
    let repeated = Mutex::new(Vec::new());
    side_by_side(plan, places.len(), |at, worker| {
        let place = places[at];
        let first = observations[place]
            .as_ref()
            .expect("only observations are repeated");
        let ask = || asking.observe_alone(&suite.cases[place], &first.view, table, worker);
        let alone = ask();
        // A crash, a hang or a cut output may be a matter of that one process.
        let is_no_answer = |seen: &Observation<C>| matches!(seen.response, Response::Violation(_));
        let once_more = (is_no_answer(&alone) != is_no_answer(first)).then(ask);
        if asking.is_over() {
            return false;
        }
        let mut repeated = repeated.lock().expect("no worker panics");
        repeated.push(Repeated {
            place,
            alone,
            once_more,
        });
        progress(repeated.len(), places.len());
        true
    });
    repeated.into_inner().expect("no worker panics")
}

/// Notes where two answers differ; returns whether any did.
fn note_differences<C: TestCase>(
    repeat: Repeat,
    observations: &mut [Option<Observation<C>>],
    repeated: Vec<Repeated<C>>,
) -> bool {
    let mut any = false;
    for repeated in repeated {
        let first = observations[repeated.place]
            .as_mut()
            .expect("only observations are repeated");
        if !repeated.alone.response.is_like(&first.response) {
            first.nondeterminism = Some(repeated.difference(repeat, first));
            any = true;
        }
        // A serving process may have said nothing of it yet.
        if first.stderr.is_empty() {
            first.stderr = repeated.alone.stderr;
        }
    }
    any
}

fn is_asked_again<C: TestCase>(
    suite: &Suite<C>,
    repeat: Repeat,
    observations: &[Option<Observation<C>>],
    judgement: &Judgement<C>,
    i: usize,
) -> bool {
    let (Some(observation), Some(judged)) = (&observations[i], &judgement.cases[i]) else {
        return false;
    };
    // Who hangs once hangs again, and that takes time; of two answers that differ already the case is settled.
    let is_settled = observation.nondeterminism.is_some()
        || matches!(observation.response, Response::Violation(Answer::Hung(_)));
    let sampled = repeat == Repeat::FailuresAndSample
        && (i % SAMPLE == SAMPLE / 2 || is_first_unsupported(suite, judgement, i));
    !is_settled && (judged.outcome == Outcome::Fail || sampled)
}

/// Returns true if a case is the first legal one of its kind that is called unsupported.
fn is_first_unsupported<C: TestCase>(suite: &Suite<C>, judgement: &Judgement<C>, i: usize) -> bool {
    let kind = suite.cases[i].kind();
    let mut unsupported = judgement.with(Outcome::Unsupported);
    unsupported.find(|&place| {
        let case = &suite.cases[place];
        case.kind() == kind && case.expect() == Expect::Decode
    }) == Some(i)
}

impl<C: TestCase> Repeated<C> {
    /// How the answers to one request differ.
    fn difference(&self, repeat: Repeat, first: &Observation<C>) -> Nondeterminism {
        let (one, other) = (first.response.describe(), self.alone.response.describe());
        let served = repeat == Repeat::FailuresAndSample;
        let says = match &self.once_more {
            Some(once_more) if once_more.response.is_like(&first.response) => format!(
                "answers with {one}; asked again, one process ended with {other}; asked once more it answers as before"
            ),
            Some(_) if served => format!(
                "in serve mode{}, it answers with {one}; a process of its own ends with {other}",
                after(first.after.as_ref())
            ),
            None if served => format!(
                "in serve mode{}, it answers with {one}; asked alone with {other}: state leaks between files",
                after(first.after.as_ref())
            ),
            _ => {
                format!("answers differently each time: first with {one}, asked again with {other}")
            }
        };
        Nondeterminism { served, says }
    }
}
