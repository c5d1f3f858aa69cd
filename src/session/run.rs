//! One run: first contact, every case once, failures once more, verdicts.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

pub use crate::session::asking::Session;
use crate::session::asking::{Ask, Counting, is_hang};
use crate::session::contact::{Contact, First};
use crate::session::judge::{Judgement, judge};
use crate::session::lit_scene::LitScene;
use crate::session::observation::{Observation, Response};
use crate::session::offer::Offer;
use crate::session::outcome::Outcome;
use crate::session::plan::RunPlan;
use crate::session::remark::Remark;
use crate::session::scores::{Fraction, Scores};
use crate::session::tally::HangWatch;
use crate::suite::cases::{Case, Expect, Suite, TableSpelling};
use crate::suite::test_case::TestCase;

/// What a run showed.
#[derive(Clone, Debug)]
pub struct Run<C: TestCase = Case> {
    /// What was observed, a place for each case of the suite.
    pub observations: Vec<Option<Observation<C>>>,
    /// The verdicts.
    pub judgement: Judgement<C>,
    /// What the decoder did with the first files.
    pub first: Vec<First<C>>,
    /// What the decoder offers.
    pub offer: Offer<C>,
    /// How the tables' counts were spelled for it.
    pub table: TableSpelling,
    /// What is to be said of the run as a whole.
    pub remarks: Vec<Remark>,
    /// How many requests were sent, those that were asked again not counted.
    pub asked: usize,
    /// How many of them ended in neither a frame nor a refusal.
    pub violation: usize,
    /// Why the run ended before all cases were asked, if it did.
    pub ended_early: Option<&'static str>,
    /// Why the program is no decoder, if it is none.
    pub not_a_decoder: Option<String>,
    /// A scene for people to look at, where it was asked for.
    pub scene: Option<LitScene>,
    /// Set when the user wants the search for causes to end.
    pub stop: Arc<AtomicBool>,
    /// Units of work that the search for causes has done, of at most [`MAX_WORK`](crate::diagnose::MAX_WORK).
    pub searched: Arc<AtomicUsize>,
}

/// Is told of each case as it is done: what was observed, and how many of how many are done.
pub type Progress<'a, C = Case> = dyn Fn(&C, &Observation<C>, usize, usize) + Sync + 'a;

/// Runs `suite` against a decoder.
pub fn check<C: TestCase>(
    suite: &Suite<C>,
    plan: &RunPlan<C>,
    ask: &Ask<C>,
    progress: &Progress<C>,
) -> Run<C> {
    let session = Session::new(suite, plan, ask);
    let contact = session.first_contact();
    let observations = session.ask_cases(&contact, progress);
    session.verdicts(contact, observations, &|_, _| ())
}

impl<C: TestCase> Session<'_, C> {
    /// What there is to ask: every selected case and its twins, in the first of its views that is offered; nothing of a
    /// program that is no decoder. The cases that are to be asked soonest, and the others.
    #[must_use]
    pub fn agenda(&self, contact: &Contact<C>) -> (Vec<usize>, Vec<usize>) {
        let (suite, plan) = (self.suite, self.plan);
        let withheld = plan.withheld_in(suite, contact.table);
        let (wanted, soonest) = plan.with_twins(suite);
        let is_asked = |&i: &usize| {
            contact.is_ready()
                && wanted[i]
                && withheld[i].is_none()
                && contact.offer.chosen_view(&suite.cases[i]).is_some()
        };
        (0..suite.cases.len())
            .filter(is_asked)
            .partition(|&i| soonest[i])
    }

    /// Asks some cases once, each in the first of its views that is offered.
    ///
    /// Where the run ends because of hangs, what was asked side by side after the last of them is forgotten, so that the
    /// number of jobs makes no difference.
    pub fn ask_some(
        &self,
        contact: &Contact<C>,
        places: &[usize],
        observations: &mut [Option<Observation<C>>],
        progress: &Progress<C>,
    ) {
        let (cases, stop) = (&self.suite.cases, &self.plan.stop);
        if self.is_over() {
            return;
        }
        let is_legal = |&place: &usize| cases[places[place]].expect() == Expect::Decode;
        let watch = HangWatch::new((0..places.len()).filter(is_legal).collect());
        let done = AtomicUsize::new(0);
        let made = Mutex::new(observations);
        self.side_by_side(places.len(), |place, worker| {
            let i = places[place];
            let Some(view) = contact.offer.chosen_view(&cases[i]) else {
                return true;
            };
            if watch.is_over_at(place) || stop.load(Ordering::Relaxed) {
                return false;
            }
            let (observation, reply) = self.observe(&cases[i], view, contact.table, worker);
            if stop.load(Ordering::Relaxed) {
                return false;
            }
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress(&cases[i], &observation, done, places.len());
            made.lock().expect("no worker panics")[i] = Some(observation);
            watch.note(place, is_hang(&reply), &self.tally);
            true
        });
        let observations = made.into_inner().expect("no worker panics");
        let Some(last) = watch.last() else { return };
        for &i in &places[last + 1..] {
            if let Some(observation) = observations[i].take() {
                self.tally.forget(observation.is_violation());
            }
        }
    }

    /// Asks every case that is on the agenda.
    #[must_use]
    pub fn ask_cases(
        &self,
        contact: &Contact<C>,
        progress: &Progress<C>,
    ) -> Vec<Option<Observation<C>>> {
        let mut observations = vec![None; self.suite.cases.len()];
        let (soonest, others) = self.agenda(contact);
        let all = [soonest, others].concat();
        self.ask_some(contact, &all, &mut observations, progress);
        observations
    }

    /// Returns the run as it would stand if only these cases had been selected; nothing is repeated.
    #[must_use]
    pub fn so_far(
        &self,
        contact: &Contact<C>,
        places: &[usize],
        observations: &[Option<Observation<C>>],
    ) -> Run<C> {
        let selected = &self.plan.selected;
        let is_seen = |i: usize| selected[i] && places.contains(&i) && observations[i].is_some();
        let selected: Vec<bool> = (0..selected.len()).map(is_seen).collect();
        let judgement = judge(self.suite, &selected, observations, &contact.offer);
        self.run(contact.clone(), observations.to_vec(), judgement)
    }

    /// Judges, repeats failures, and judges again if a response differed. `again` is told of each repeated request: how
    /// many of how many are done.
    #[must_use]
    pub fn verdicts(
        self,
        contact: Contact<C>,
        mut observations: Vec<Option<Observation<C>>>,
        again: &Counting,
    ) -> Run<C> {
        let (suite, table) = (self.suite, contact.table);
        let nothing = vec![false; suite.cases.len()];
        let selected = match contact.not_a_decoder {
            Some(_) => &nothing,
            None => &self.plan.selected,
        };
        let mut judgement = judge(suite, selected, &observations, &contact.offer);
        let why_over = self.tally.why_over();
        let ended_early = match contact.not_a_decoder {
            Some(_) => why_over,
            None => contact.ends.or(why_over),
        };
        if ended_early.is_none() && self.ask_again(table, &mut observations, &judgement, again) {
            judgement = judge(suite, selected, &observations, &contact.offer);
        }
        let nothing_decoded = || nothing_decoded(suite, &observations);
        let not_a_decoder = contact.not_a_decoder.clone().or_else(nothing_decoded);
        let mut run = Run {
            ended_early,
            not_a_decoder,
            ..self.run(contact, observations, judgement)
        };
        run.explain_what_was_not_run(suite, &self.plan.withheld_in(suite, table));
        run.state_why_it_ended_early();
        run
    }

    /// Returns a run that did not end early, with these observations.
    fn run(
        &self,
        contact: Contact<C>,
        observations: Vec<Option<Observation<C>>>,
        judgement: Judgement<C>,
    ) -> Run<C> {
        let (asked, violation) = self.tally.counts();
        Run {
            observations,
            judgement,
            first: contact.first,
            offer: contact.offer,
            table: contact.table,
            remarks: contact.remarks,
            asked,
            violation,
            ended_early: None,
            not_a_decoder: None,
            scene: None,
            stop: Arc::clone(&self.plan.stop),
            searched: Arc::default(),
        }
    }
}

/// Whether every must-accept file was answered 69.
fn nothing_decoded<C: TestCase>(
    suite: &Suite<C>,
    observations: &[Option<Observation<C>>],
) -> Option<String> {
    let accepted = suite.cases.iter().zip(observations);
    let mut asked = accepted
        .filter(|(case, _)| case.expect() == Expect::Decode)
        .filter_map(|(_, observation)| observation.as_ref())
        .peekable();
    let unsupported =
        |observation: &Observation<C>| matches!(observation.response, Response::Unsupported);
    (asked.peek().is_some() && asked.all(unsupported))
        .then(|| "it exits with 69 (unsupported) on every file that it should decode".to_owned())
}

impl<C: TestCase> Run<C> {
    /// Cases that were not asked: on purpose, or because the run ended before.
    fn explain_what_was_not_run(&mut self, suite: &Suite<C>, withheld: &[Option<String>]) {
        let judged = suite.cases.iter().zip(&mut self.judgement.cases);
        for (((case, judged), observation), why) in judged.zip(&self.observations).zip(withheld) {
            let Some(judged) = judged else { continue };
            if let Some(why) = why {
                judged.outcome = Outcome::NotJudged;
                judged.says.clone_from(why);
            } else if observation.is_none() && self.offer.chosen_view(case).is_some() {
                judged.outcome = Outcome::NotRun;
                judged.says = self.ended_early.map(str::to_owned).unwrap_or_default();
            }
        }
    }

    /// Says why the run ended early where every form of the report shows it: in the reason why the program is no decoder, or
    /// else in a remark.
    fn state_why_it_ended_early(&mut self) {
        let Some(why) = self.ended_early else { return };
        if let Some(reason) = &mut self.not_a_decoder {
            *reason = format!("{reason}\n{why}");
            return;
        }
        let not_run = self.judgement.with(Outcome::NotRun).count();
        let says = format!(
            "{why}; {not_run} cases were not run, after {} requests",
            self.asked
        );
        self.remarks.push(Remark::failure(says));
    }

    /// The scores of this run.
    #[must_use]
    pub fn scores(&self, suite: &Suite<C>) -> Scores {
        let count = |outcome: Outcome| self.judgement.with(outcome).count();
        let judged = suite.cases.iter().zip(&self.judgement.cases);
        let judged = judged.filter(|(_, judged)| judged.is_some());
        let features: BTreeSet<C::Feature> = judged
            .flat_map(|(case, _)| case.views().iter().flat_map(|view| case.features(view)))
            .collect();
        let passed = count(Outcome::Pass);
        let decoded = self.judgement.decoded.intersection(&features).count();
        let fraction = |part, whole| Fraction { part, whole };
        Scores {
            correctness: fraction(passed, passed + count(Outcome::Fail)),
            breadth: fraction(decoded, features.len()),
            robustness: fraction(self.asked - self.violation, self.asked),
        }
    }

    /// The exit status of `check`: 0, 1 or 3.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        self.status(self.judgement.with(Outcome::Fail).next().is_some())
    }

    /// The same if not every failure counts: `failed` says whether one does.
    #[must_use]
    pub fn status(&self, failed: bool) -> u8 {
        match self.not_a_decoder {
            Some(_) => 3,
            None => u8::from(
                failed
                    || self.ended_early.is_some()
                    || self.remarks.iter().any(|remark| remark.failure)
                    || !self.decoded_something(),
            ),
        }
    }

    /// Whether a picture came of any file.
    fn decoded_something(&self) -> bool {
        let mut observed = self.observations.iter().flatten();
        observed.any(|observation| matches!(observation.response, Response::Picture { .. }))
    }
}
