//! The smallest set of mistakes that reproduces the decoder's responses.
//!
//! The set grows by one mistake at a time: the one that explains most of the remaining failures and is contradicted least. If no
//! single mistake explains more, it grows by a pair. At the end, mistakes that are not needed are dropped.

use std::any::Any;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::credit::credit;
use super::mistake::Mistake;
pub(super) use super::tuning::WORTH_OF_A_REFUSAL;
use super::tuning::{
    MAX_AFFORDABLE, MAX_EDIT_PASSES, MAX_FINALISTS, MAX_MISTAKES, MAX_PAIRS, MAX_SAMPLE,
    MAX_SAMPLES_OF_A_SMALL_IMAGE, MAX_SAMPLES_TRIED, MAX_WORK, MAX_WORK_ON_PAIRS, MIN_SUPPORT,
    SAMPLES_OF_A_UNIT_OF_WORK, WORTH_OF_A_CONTRADICTION, WORTH_OF_A_CRASH,
    WORTH_OF_A_REFUSAL_OF_AN_IMAGE, WORTH_OF_AN_IMAGE, WORTH_OF_ANOTHER_LENIENT_ANSWER, is_most,
    is_much, is_nearly_all,
};
use super::witness::{Agreement, Witness};
use super::words::{nondeterminism, uniform};
use crate::kit::parallel::in_parallel;
use crate::misreadings::{self, At, Misreading};
use crate::protocol::frame::Answer;
use crate::session::run::Run;
use crate::suite::cases::Expect;

/// Mistakes that together reproduce the decoder's responses.
#[derive(Default)]
pub(super) struct FoundMistakes {
    /// The mistakes in the order in which they were found, the one that explains most first.
    pub members: Vec<Member>,
}

impl FoundMistakes {
    /// Removes the members whose flag is false.
    pub fn keep(&mut self, keep: &[bool]) {
        let mut keep = keep.iter();
        self.members.retain(|_| keep.next() == Some(&true));
    }
}

/// A mistake of a set, and its equivalents.
pub(super) struct Member {
    pub id: Id,
    /// Mistakes that explain the same cases.
    pub alike: Set,
}

/// The search for the mistakes of one decoder.
pub(super) struct Search<'a> {
    pub witnesses: &'a [Witness<'a>],
    /// All candidates: the misreadings of the catalog, and the mistakes that were added.
    pub mistakes: Vec<Mistake>,
    /// Mistakes that the user takes as given: every set makes them, and they are never named.
    pub assumed: Set,
    pub threads: usize,
    /// True if most responses do not depend on the file, so that common properties are chance.
    pub is_arbitrary: bool,
    stop: &'a AtomicBool,
    /// Units of work so far. An answer is one unit, or several if the map is large.
    work: &'a AtomicUsize,
    /// Answers computed so far.
    answered: AtomicUsize,
    /// Cases that the decoder passes, the smallest first.
    pub passing: Vec<usize>,
    /// Messages of panics, each once.
    faults: Mutex<Vec<String>>,
    /// The clauses of the failing cases.
    clauses: HashSet<&'a str>,
    /// Failing files on which every edit was tried, with the mistakes that show there.
    probed: HashSet<(usize, Set)>,
    /// The effects of sets, by case and by the mistakes that show there.
    effects: Mutex<HashMap<(usize, Set), SetEffect>>,
    /// For each mistake and each case, the effect of the mistake alone, if it changes the answer.
    alone: Vec<Vec<OnceLock<Option<SetEffect>>>>,
}

/// The effect of a set of mistakes on one case.
#[derive(Clone, Copy, PartialEq)]
struct SetEffect {
    worth: i64,
    agreement: Agreement,
    /// A hash of the answer; of several possible answers the one with the greatest worth is used.
    answer: u64,
}

impl SetEffect {
    /// The reference's answer explains no failure.
    const NONE: SetEffect = SetEffect {
        worth: 0,
        agreement: Agreement::None,
        answer: 0,
    };
}

/// The place of a mistake in [`Search::mistakes`].
pub(super) type Id = usize;

/// Mistakes that are made together.
pub(super) type Set = Vec<Id>;

impl<'a> Search<'a> {
    pub fn new(
        witnesses: &'a [Witness<'a>],
        assumed: &'a [&'static Misreading],
        threads: usize,
        run: &'a Run,
    ) -> Search<'a> {
        let passing = (0..witnesses.len()).filter(|&w| !witnesses[w].failed);
        let mut passing: Vec<usize> = passing.collect();
        passing.sort_by_key(|&w| witnesses[w].built.file.len());
        let failing = witnesses.iter().filter(|witness| witness.failed);
        let clauses = failing.flat_map(|witness| &witness.case.clauses);
        let mistakes: Vec<Mistake> = misreadings::all().map(Mistake::everywhere).collect();
        let is_assumed = |mistake: &Mistake| {
            let slug = mistake.misreading.slug;
            assumed.iter().any(|other| other.slug == slug)
        };
        Search {
            alone: vec![vec![OnceLock::new(); witnesses.len()]; mistakes.len()],
            assumed: (0..mistakes.len())
                .filter(|&id| is_assumed(&mistakes[id]))
                .collect(),
            mistakes,
            clauses: clauses.map(String::as_str).collect(),
            witnesses,
            threads,
            is_arbitrary: nondeterminism::is_prevalent(run) || uniform::is_prevalent(witnesses),
            stop: &run.stop,
            work: &run.searched,
            answered: AtomicUsize::new(0),
            probed: HashSet::new(),
            effects: Mutex::new(HashMap::new()),
            faults: Mutex::new(Vec::new()),
            passing,
        }
    }

    /// Adds a candidate.
    pub fn add(&mut self, mistake: Mistake) -> Id {
        self.mistakes.push(mistake);
        self.alone.push(vec![OnceLock::new(); self.witnesses.len()]);
        self.mistakes.len() - 1
    }

    /// Returns true if no edits were tried before on this case with the same mistakes, and remembers it.
    pub fn is_new_probe(&mut self, w: usize, set: &[Id]) -> bool {
        let showing = self.showing(w, set);
        self.probed.insert((w, showing))
    }

    /// Returns the failing cases.
    pub fn failing(&self) -> Vec<usize> {
        let all = 0..self.witnesses.len();
        all.filter(|&w| self.witnesses[w].failed).collect()
    }

    /// Returns the failing cases that a set does not explain.
    pub fn unexplained(&self, set: &Set) -> Vec<usize> {
        self.select(self.failing(), |w| self.value(w, set) < WORTH_OF_A_REFUSAL)
    }

    /// Finds the mistakes that explain most, one after the other. `add_candidates` adds mistakes that the catalog lacks.
    pub fn run(&mut self, add_candidates: impl Fn(&mut Search, &Set, &[usize])) -> FoundMistakes {
        let mut members: Vec<Member> = Vec::new();
        let mut are_pairs_tried = false;
        let mut edit_passes = 0;
        while members.len() < MAX_MISTAKES && !self.is_interrupted() {
            let set = ids_of(&members);
            let left = self.unexplained(&set);
            if left.is_empty() || self.is_spent() {
                break;
            }
            let mut single = self.best_single(&set, &left);
            // An edit may explain failures that would take several misreadings. It is not needed if one misreading explains nearly all.
            let explains = |single: &Option<Member>, is_share: fn(usize, usize) -> bool| {
                single.as_ref().is_some_and(|member| {
                    let gain = self.gain(&set, &[member.id], &left);
                    is_share(gain, left.len()) && self.denied(&with_id(&set, member.id)).is_empty()
                })
            };
            let is_enough = explains(&single, is_much);
            if !explains(&single, is_nearly_all) && edit_passes < MAX_EDIT_PASSES {
                edit_passes += 1;
                let added = catch_unwind(AssertUnwindSafe(|| add_candidates(self, &set, &left)));
                if let Err(panic) = added {
                    self.record_panic(&*panic);
                }
                single = self.best_single(&set, &left);
            }
            let mut grown = single.map(|single| vec![single]);
            if grown.is_none() || !is_enough && !are_pairs_tried {
                are_pairs_tried = true;
                let gain = |more: &Vec<Member>| self.gain(&set, &ids_of(more), &left);
                let pair = self.two_more(&set, &left);
                // A pair must explain more than twice as much as one mistake.
                let is_better = |pair: &Vec<Member>| {
                    grown.as_ref().is_none_or(|single| {
                        is_most(gain(pair).saturating_sub(gain(single)), gain(pair))
                    })
                };
                grown = pair.filter(is_better).or(grown);
            }
            match grown {
                Some(more) => members.extend(more),
                None => break,
            }
        }
        self.drop_needless(&mut members);
        FoundMistakes { members }
    }

    /// Returns the cost of a result: its mistakes, and the failures that it leaves unexplained.
    pub fn cost(&self, found: &FoundMistakes) -> usize {
        self.unexplained(&ids_of(&found.members)).len() + MIN_SUPPORT * found.members.len()
    }

    /// Returns the mistake that adds most to `set`.
    fn best_single(&self, set: &Set, left: &[usize]) -> Option<Member> {
        let mut all: Set = (0..self.mistakes.len())
            .filter(|&id| self.is_open(set, id))
            .collect();
        let sample = self.one_more(set, &mut all, &self.sample(left));
        sample.or_else(|| {
            let mut affordable = self.smallest(left, MAX_SAMPLES_TRIED);
            affordable.truncate(MAX_AFFORDABLE);
            self.one_more(set, &mut all, &affordable)
        })
    }

    /// Returns true if a mistake may be added to a set.
    fn is_open(&self, set: &Set, id: Id) -> bool {
        !set.contains(&id) && !self.assumed.contains(&id)
    }

    /// Returns the best agreement of a set with the response to one case.
    pub fn agreement(&self, w: usize, set: &[Id]) -> Agreement {
        self.effect(w, set).agreement
    }

    /// Returns true if a set would fail a case that the decoder passes.
    pub fn contradicted(&self, w: usize, set: &[Id]) -> bool {
        self.value(w, set) == WORTH_OF_A_CONTRADICTION
    }

    /// Returns true if two sets have different answers.
    pub fn differ(&self, w: usize, set: &[Id], other: &[Id]) -> bool {
        self.effect(w, set).answer != self.effect(w, other).answer
    }

    /// Returns the cases that the decoder passes and a set would fail.
    pub fn contradictions(&self, set: &[Id]) -> Vec<usize> {
        let mut passing = self.passing.clone();
        passing.sort_unstable();
        self.select(passing, |w| self.contradicted(w, set))
    }

    /// Returns the small files that the decoder passes and a set would fail.
    pub fn denied(&self, set: &[Id]) -> Vec<usize> {
        let small = self.passing.iter().copied().filter(|&w| self.is_small(w));
        self.select(small.collect(), |w| self.contradicted(w, set))
    }

    /// Returns the agreement of a set and one more mistake, which need not be a candidate, with the response to one case.
    pub fn agreement_with(&self, w: usize, set: &[Id], mistake: &Mistake) -> Agreement {
        let witness = &self.witnesses[w];
        match witness.could_be(mistake) {
            true => witness.agreement(&self.answer_with(w, set, mistake)),
            false => Agreement::None,
        }
    }

    /// Returns true if one more mistake changes what a decoder with a set of mistakes answers.
    pub fn changes_with(&self, w: usize, set: &[Id], mistake: &Mistake) -> bool {
        self.witnesses[w].concerns(mistake)
            && self.fingerprint(w, &self.answer_with(w, set, mistake)) != self.effect(w, set).answer
    }

    /// Returns the small passing files that a set and one more mistake would fail. An edit does not describe the
    /// decoder's checks, so neither files that the edit refuses nor malformed files contradict it.
    pub fn denied_with(&self, set: &[Id], mistake: &Mistake) -> Vec<usize> {
        let is_denied = |&w: &usize| {
            let witness = &self.witnesses[w];
            if !self.is_small(w) || !witness.concerns(mistake) {
                return false;
            }
            let answer = self.answer_with(w, set, mistake);
            let is_check = *answer == Answer::Rejected || witness.case.expect != Expect::Decode;
            let is_unknown = mistake.listed().is_none() && is_check;
            !is_unknown && witness.contradicts(&answer)
        };
        self.passing.iter().copied().filter(is_denied).collect()
    }

    pub fn answer_with(&self, w: usize, set: &[Id], mistake: &Mistake) -> Cow<'_, Answer> {
        let mut mistakes = self.mistakes_of(&self.showing(w, set));
        mistakes.push(mistake);
        self.count_work(w, 1);
        self.answer(w, &mistakes)
    }

    fn count_work(&self, w: usize, answers: usize) {
        let units = answers * (1 + self.samples(w) / SAMPLES_OF_A_UNIT_OF_WORK);
        self.work.fetch_add(units, Ordering::Relaxed);
    }

    /// Returns what a decoder with these mistakes and the assumed ones answers; of several answers the one that agrees best.
    pub fn answer_of(&self, w: usize, set: &[Id]) -> Cow<'_, Answer> {
        let mut answers = self.answers(w, set);
        let best = (0..answers.len())
            .min_by_key(|&at| -self.worth_of(w, &answers[at]))
            .unwrap_or(0);
        answers.swap_remove(best)
    }

    /// Returns the possible answers of a decoder with these mistakes. Mistakes in one decision are made one at a time.
    fn answers(&self, w: usize, set: &[Id]) -> Vec<Cow<'_, Answer>> {
        self.answers_of(w, &self.showing(w, set))
    }

    /// Returns true if a set explains the response, or does so together with its mistakes that show only in combination.
    pub fn explains(&self, w: usize, set: &[Id]) -> bool {
        if self.agreement(w, set).explains() {
            return true;
        }
        let concerned = self.concerned(w, set);
        let showing = self.showing(w, set);
        if showing.is_empty() || showing.len() == concerned.len() {
            return false;
        }
        let explains = |answer: &Cow<Answer>| self.witnesses[w].agreement(answer).explains();
        self.answers_of(w, &concerned).iter().any(explains)
    }

    /// Returns the mistakes of a set, and those that are assumed, that can change the answer.
    fn concerned(&self, w: usize, set: &[Id]) -> Set {
        let all = self.assumed.iter().chain(set).copied();
        all.filter(|&id| self.witnesses[w].concerns(&self.mistakes[id]))
            .collect()
    }

    fn answers_of(&self, w: usize, set: &[Id]) -> Vec<Cow<'_, Answer>> {
        let mut variants: Vec<Set> = vec![Vec::new()];
        for &id in set {
            let mut grown = Vec::new();
            for variant in variants {
                let mut with = variant.clone();
                with.retain(|&other| self.stackable(other, id));
                let replaces = with.len() < variant.len();
                with.push(id);
                for variant in replaces.then_some(variant).into_iter().chain([with]) {
                    if !grown.contains(&variant) {
                        grown.push(variant);
                    }
                }
            }
            variants = grown;
        }
        self.add_other_order(&mut variants);
        self.count_work(w, variants.len());
        variants
            .iter()
            .map(|variant| self.answer(w, &self.mistakes_of(variant)))
            .collect()
    }

    /// Returns the answer of a decoder with these mistakes. A panic is a bug in this program, and counts as no mistake.
    fn answer(&self, w: usize, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let witness = &self.witnesses[w];
        self.answered.fetch_add(1, Ordering::Relaxed);
        let answer = catch_unwind(AssertUnwindSafe(|| {
            match witness.refuses_positions(mistakes) {
                true => Cow::Owned(Answer::Rejected),
                false => witness.answer(mistakes),
            }
        }));
        let answer = answer.map(|answer| match witness.shown_by(mistakes, &answer) {
            Some(shown) => Cow::Owned(shown),
            None => answer,
        });
        answer.unwrap_or_else(|panic| {
            self.record_panic(&*panic);
            Cow::Borrowed(&witness.right)
        })
    }

    /// Returns the result of `work`. If it panics, keeps the message and returns the default.
    pub fn guarded<T: Default>(&self, work: impl FnOnce() -> T) -> T {
        catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
            self.record_panic(&*panic);
            T::default()
        })
    }

    /// Returns the number of answers computed so far.
    pub fn answered(&self) -> usize {
        self.answered.load(Ordering::Relaxed)
    }

    /// Returns the messages of panics so far.
    pub fn faults(&self) -> Vec<String> {
        let faults = self.faults.lock();
        faults.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Records the message of a panic.
    pub fn record_panic(&self, panic: &(dyn Any + Send)) {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
        let mut faults = self.faults.lock().unwrap_or_else(PoisonError::into_inner);
        let text = text.unwrap_or_else(|| "a panic without a message".to_owned());
        // A panic of one thread is reported once.
        let is_told = faults.contains(&text) || text == "a scoped thread panicked";
        if !is_told {
            faults.push(text);
        }
    }

    /// Adds the opposite order of mistakes that depend on their order: bytes that are lost at the start of a payload are missing at
    /// its end.
    fn add_other_order(&self, variants: &mut Vec<Set>) {
        for at in 0..variants.len() {
            let variant = &variants[at];
            let is_ordered = |(i, &a): (usize, &Id)| {
                let mut later = variant[i + 1..].iter();
                later.any(|&b| self.depends_on_order(a, b))
            };
            if variant.iter().enumerate().any(is_ordered) {
                variants.push(variant.iter().rev().copied().collect());
            }
        }
    }

    /// Returns true if two mistakes act on the same bytes or on a common formula.
    fn depends_on_order(&self, a: Id, b: Id) -> bool {
        let [one, other] = [a, b].map(|id| self.mistakes[id].misreading.at.formulas());
        self.edits_bytes(a) && self.edits_bytes(b)
            || one.iter().any(|formula| other.contains(formula))
    }

    fn edits_bytes(&self, id: Id) -> bool {
        matches!(self.mistakes[id].misreading.at, At::Bytes(_))
    }

    /// Returns the mistakes of a set.
    pub fn mistakes_of(&self, set: &[Id]) -> Vec<&Mistake> {
        set.iter().map(|&id| &self.mistakes[id]).collect()
    }

    /// Returns true if both mistakes can act on one file. Two changes of one decision cannot.
    fn stackable(&self, a: Id, b: Id) -> bool {
        let [a, b] = [a, b].map(|id| &self.mistakes[id].misreading.at);
        !(a.is_decision() && a.is_at(b))
    }

    /// Returns true if the user interrupted the search. Results after that are meaningless.
    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns the worth of a set on one case.
    pub fn value(&self, w: usize, set: &[Id]) -> i64 {
        self.effect(w, set).worth
    }

    /// Returns the effect of a set on one case.
    fn effect(&self, w: usize, set: &[Id]) -> SetEffect {
        if self.is_interrupted() {
            return SetEffect::NONE;
        }
        let showing = self.showing(w, set);
        if let [only] = showing[..] {
            return self.alone(w, only).unwrap_or(SetEffect::NONE);
        }
        if showing.is_empty() {
            return SetEffect::NONE;
        }
        let known = || self.effects.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (w, showing);
        if let Some(&effect) = known().get(&key) {
            return effect;
        }
        let answers = self.answers(w, &key.1);
        let effects = answers.iter().map(|answer| self.effect_of(w, answer));
        let best = effects.min_by_key(|effect| -effect.worth);
        let effect = best.unwrap_or(SetEffect::NONE);
        known().insert(key, effect);
        effect
    }

    /// Returns the mistakes of a set, and those that are assumed, that change the answer alone. Others rarely show only in
    /// combination, except changes of the bytes of a file.
    fn showing(&self, w: usize, set: &[Id]) -> Set {
        let concerned = self.concerned(w, set);
        let alone = |&id: &Id| Some((id, self.alone(w, id)?));
        let shown: Vec<(Id, SetEffect)> = concerned.iter().filter_map(alone).collect();
        // Changes of the bytes of a file may show only after others.
        let is_explained = matches!(shown[..], [(_, effect)] if effect.worth >= WORTH_OF_A_REFUSAL);
        let are_bytes_changed = shown.iter().any(|&(id, _)| self.edits_bytes(id));
        let is_kept = |id: &Id| {
            shown.iter().any(|(shown, _)| shown == id)
                || are_bytes_changed && !is_explained && self.edits_bytes(*id)
        };
        concerned.into_iter().filter(is_kept).collect()
    }

    /// Returns the effect of one mistake, without the assumed mistakes, or `None` if it does not show in this case.
    fn alone(&self, w: usize, id: Id) -> Option<SetEffect> {
        let witness = &self.witnesses[w];
        let mistake = &self.mistakes[id];
        *self.alone[id][w].get_or_init(|| {
            if !witness.concerns(mistake) {
                return None;
            }
            self.count_work(w, 1);
            let answer = self.answer(w, &[mistake]);
            (*answer != witness.right).then(|| self.effect_of(w, &answer))
        })
    }

    fn effect_of(&self, w: usize, answer: &Answer) -> SetEffect {
        SetEffect {
            worth: self.worth_of(w, answer),
            agreement: self.witnesses[w].agreement(answer),
            answer: self.fingerprint(w, answer),
        }
    }

    /// Returns a hash of an answer, and 0 for the answer of a decoder without mistakes.
    fn fingerprint(&self, w: usize, answer: &Answer) -> u64 {
        if answer == self.witnesses[w].unmistaken() {
            return 0;
        }
        let mut hasher = DefaultHasher::new();
        std::mem::discriminant(answer).hash(&mut hasher);
        if let Answer::Decoded(frame) = answer {
            frame.hash(&mut hasher);
        }
        hasher.finish()
    }

    /// Returns the worth of an answer to one case.
    fn worth_of(&self, w: usize, answer: &Answer) -> i64 {
        let witness = &self.witnesses[w];
        let is_open = matches!(
            witness.case.expect,
            Expect::Lenient | Expect::Robust | Expect::Spelling
        );
        if witness.failed {
            match witness.agreement(answer) {
                Agreement::None => credit(witness, answer),
                agreement => worth(agreement),
            }
        } else if witness.contradicts(answer) {
            WORTH_OF_A_CONTRADICTION
        } else if is_open && witness.leans_away(answer) {
            WORTH_OF_ANOTHER_LENIENT_ANSWER
        } else {
            0
        }
    }

    /// Returns the mistake that adds most to `set`, among those that explain one of `tried`. If none adds anything, removes the
    /// finalists from `all`.
    fn one_more(&self, set: &Set, all: &mut Set, tried: &[usize]) -> Option<Member> {
        let now: Vec<i64> = tried.iter().map(|&w| self.value(w, set)).collect();
        let promise = self.each(all, |&id| {
            let with = with_id(set, id);
            let gain = |(&w, &now): (&usize, &i64)| match self.could_be(w, id) {
                true => (self.value(w, &with) - now).max(0),
                false => 0,
            };
            tried.iter().zip(&now).map(gain).sum::<i64>()
        });
        let mut promising: Vec<(i64, Id)> = promise.into_iter().zip(all.iter().copied()).collect();
        promising.retain(|&(gain, _)| gain >= WORTH_OF_A_CRASH);
        // Among equals, misreadings of the clauses under test come first, then the order of the catalog.
        promising.sort_by_key(|&(gain, id)| (-gain, !self.is_about(id)));
        promising.truncate(MAX_FINALISTS);
        let finalists: Set = promising.into_iter().map(|(_, id)| id).collect();
        let best = self.best(set, &finalists, &self.tried_for(tried));
        all.retain(|id| !finalists.contains(id));
        best
    }

    fn could_be(&self, w: usize, id: Id) -> bool {
        self.witnesses[w].could_be(&self.mistakes[id])
    }

    /// Marks the cases on which mistakes are tried: all but large maps, or all if only large maps are left.
    fn tried_for(&self, left: &[usize]) -> Vec<bool> {
        let with_large = left.iter().all(|&w| !self.is_small(w));
        let all = 0..self.witnesses.len();
        all.map(|w| with_large || self.is_small(w)).collect()
    }

    /// Returns the best of `finalists` on every case that is marked in `tried`, with the equally good ones.
    fn best(&self, set: &Set, finalists: &Set, tried: &[bool]) -> Option<Member> {
        let now: Vec<i64> = (0..self.witnesses.len())
            .map(|w| if tried[w] { self.value(w, set) } else { 0 })
            .collect();
        let is_left =
            |&w: &usize| tried[w] && self.witnesses[w].failed && now[w] < WORTH_OF_A_REFUSAL;
        let left: Vec<usize> = (0..now.len()).filter(is_left).collect();
        let gains = self.each(finalists, |&id| {
            let with = with_id(set, id);
            let gain = |&w: &usize| match self.could_be(w, id) {
                true => self.value(w, &with) - now[w],
                false => 0,
            };
            left.iter().map(gain).collect::<Vec<i64>>()
        });
        let mut ranked: Vec<(i64, usize)> = gains
            .iter()
            .enumerate()
            .map(|(place, gains)| (gains.iter().sum(), place))
            .collect();
        ranked.sort_by_key(|&(gain, place)| (-gain, place));
        // Explained and passing cases can only contradict a mistake.
        let explained = (0..now.len()).filter(|&w| self.witnesses[w].failed && !is_left(&w));
        let others: Vec<usize> = explained
            .chain(self.passing.iter().copied())
            .filter(|&w| tried[w])
            .collect();
        let mut scored: Vec<(i64, usize)> = Vec::new();
        for batch in ranked.chunks(self.threads.max(1) * 2) {
            let best = scored.iter().map(|&(total, _)| total).max();
            let least = best.map_or(WORTH_OF_A_CRASH, |best| {
                WORTH_OF_A_CRASH.max(best - WORTH_OF_A_REFUSAL)
            });
            let totals = self.each(batch, |&(gain, place)| {
                self.total(set, finalists[place], &now, gain, least, &others)
            });
            let totals = totals.into_iter().zip(batch);
            scored.extend(totals.filter_map(|(total, &(_, place))| Some((total?, place))));
        }
        scored.sort_by_key(|&(total, place)| (-total, !self.is_about(finalists[place]), place));
        let &(total, first) = scored.first()?;
        let as_good = scored[1..].iter().filter(|&&(other, place)| {
            total - other < WORTH_OF_A_REFUSAL && gains[place] == gains[first]
        });
        Some(Member {
            id: finalists[first],
            alike: as_good.map(|&(_, place)| finalists[place]).collect(),
        })
    }

    /// Returns true if a failing case is about the misread clause.
    fn is_about(&self, id: Id) -> bool {
        let listed = self.mistakes[id].listed();
        listed.is_some_and(|misreading| self.clauses.contains(misreading.clause))
    }

    /// Returns the total worth of a mistake that adds `gain` on the remaining cases, or `None` if it is less than `least`.
    fn total(
        &self,
        set: &Set,
        id: Id,
        now: &[i64],
        gain: i64,
        least: i64,
        others: &[usize],
    ) -> Option<i64> {
        let with = with_id(set, id);
        let mut total = gain;
        for &w in others {
            if total < least {
                return None;
            }
            if self.witnesses[w].concerns(&self.mistakes[id]) {
                total += self.value(w, &with) - now[w];
            }
        }
        (total >= least).then_some(total)
    }

    /// Returns two mistakes that explain an image only together. Tries pairs of mistakes that change it, on the smallest files.
    fn two_more(&self, set: &Set, left: &[usize]) -> Option<Vec<Member>> {
        let mut pictures = self.solvable(left);
        pictures.sort_by_key(|&w| self.witnesses[w].built.file.len());
        let spent = || self.work.load(Ordering::Relaxed);
        let before_all = spent();
        let budget = || MAX_WORK_ON_PAIRS.saturating_sub(spent() - before_all);
        let format = |w: usize| self.witnesses[w].case.format();
        let mut best: Option<Vec<Member>> = None;
        let mut asked = HashSet::new();
        for w in spread(&pictures, format) {
            // One file of each format is tried, and more if no pair explains these.
            if budget() == 0 || best.is_some() && !asked.insert(format(w)) {
                break;
            }
            asked.insert(format(w));
            let pairs = self.pairs_for(w, set, budget());
            let Some(pair) = self.best_pair(set, pairs, left) else {
                continue;
            };
            let gain = |pair: &Vec<Member>| self.gain(set, &ids_of(pair), left);
            if best.as_ref().is_none_or(|best| gain(&pair) > gain(best)) {
                best = Some(pair);
            }
        }
        best
    }

    /// Counts the failures in `left`, unexplained by a set, that it explains with more mistakes.
    fn gain(&self, set: &[Id], more: &[Id], left: &[usize]) -> usize {
        let still = self.unexplained(&[set, more].concat());
        left.len().saturating_sub(still.len())
    }

    /// Returns pairs of mistakes that together explain `w`. Tries at most `most` pairs of mistakes that change its answer.
    fn pairs_for(&self, w: usize, set: &Set, most: usize) -> Vec<[Id; 2]> {
        let concerned: Set = (0..self.mistakes.len())
            .filter(|&id| self.is_open(set, id) && self.witnesses[w].concerns(&self.mistakes[id]))
            .collect();
        let acting = self.select(concerned, |id| self.differ(w, set, &with_id(set, id)));
        let pairs: Vec<[Id; 2]> = acting
            .iter()
            .enumerate()
            .flat_map(|(i, &a)| acting[i + 1..].iter().map(move |&b| [a, b]))
            .filter(|&[a, b]| self.stackable(a, b))
            .take(most)
            .collect();
        let explains = |place: usize| {
            let with = [&set[..], &pairs[place]].concat();
            self.value(w, &with) >= WORTH_OF_A_REFUSAL
        };
        let explaining = self.select((0..pairs.len()).collect(), explains);
        let explaining = explaining.into_iter().take(MAX_AFFORDABLE);
        explaining.map(|place| pairs[place]).collect()
    }

    /// Returns the pair that explains most of the remaining failures. Tries all on a sample, and the best on every case.
    fn best_pair(&self, set: &Set, pairs: Vec<[Id; 2]>, left: &[usize]) -> Option<Vec<Member>> {
        let wanted = self.tried_for(left);
        let all: Vec<usize> = (0..wanted.len()).filter(|&w| wanted[w]).collect();
        let mut pairs: Vec<([Id; 2], i64)> = pairs.into_iter().map(|pair| (pair, 0)).collect();
        for tried in [&self.sample(left), &all] {
            let totals = self.each(&pairs, |&([a, b], _)| {
                let with = [&set[..], &[a, b]].concat();
                let gain = |&w: &usize| self.value(w, &with) - self.value(w, set);
                tried.iter().map(gain).sum::<i64>()
            });
            for (pair, total) in pairs.iter_mut().zip(totals) {
                pair.1 = total;
            }
            pairs.sort_by_key(|&(_, total)| -total);
            pairs.truncate(MAX_PAIRS);
        }
        let best = pairs.first();
        let &(pair, _) = best.filter(|&&(_, total)| total >= WORTH_OF_A_CRASH)?;
        let member = |id| Member {
            id,
            alike: Vec::new(),
        };
        Some(pair.map(member).into())
    }

    /// Removes every mistake without which as much is explained, including large maps.
    fn drop_needless(&self, members: &mut Vec<Member>) {
        let (small, large): (Vec<usize>, Vec<usize>) =
            (0..self.witnesses.len()).partition(|&w| self.is_small(w));
        let total = |set: &Set, places: &[usize]| {
            let values = self.each(places, |&w| self.value(w, set));
            values.iter().sum::<i64>()
        };
        for place in (0..members.len()).rev() {
            let with = ids_of(members);
            let mut without = with.clone();
            without.remove(place);
            let needless = |places: &[usize]| {
                total(&without, places) + WORTH_OF_A_CRASH > total(&with, places)
            };
            if !without.is_empty() && needless(&small) && needless(&large) {
                members.remove(place);
            }
        }
    }

    /// Returns the small images of the correct shape.
    pub fn solvable(&self, left: &[usize]) -> Vec<usize> {
        let has_shape = |w: &usize| match (self.witnesses[*w].shown(), &self.witnesses[*w].right) {
            (Some(shown), Answer::Decoded(right)) => {
                shown.shape() == right.shape() && self.is_small(*w)
            }
            _ => false,
        };
        left.iter().copied().filter(has_shape).collect()
    }

    /// Returns true if the budget of work is used up.
    fn is_spent(&self) -> bool {
        self.work.load(Ordering::Relaxed) > MAX_WORK
    }

    /// Returns a sample of failing cases of different kinds, small ones first.
    pub fn sample(&self, left: &[usize]) -> Vec<usize> {
        let kind = |w: usize| {
            let witness = &self.witnesses[w];
            (
                witness.observation.response.name(),
                witness.case.clauses.first().cloned(),
            )
        };
        let smallest = self.smallest(left, MAX_SAMPLES_TRIED);
        let mut sample = spread(&smallest, kind);
        sample.truncate(MAX_SAMPLE);
        sample
    }

    /// Returns the number of samples of the correct answer.
    pub fn samples(&self, w: usize) -> usize {
        match &self.witnesses[w].right {
            Answer::Decoded(frame) => {
                frame.width as usize * frame.height as usize * frame.channels as usize
            }
            _ => 0,
        }
    }

    /// Returns true if every mistake is tried on this image.
    pub fn is_small(&self, w: usize) -> bool {
        self.samples(w) <= MAX_SAMPLES_OF_A_SMALL_IMAGE
    }

    /// Returns the smallest of these cases, with at most `most` samples and bytes together, but at least one.
    pub fn smallest(&self, left: &[usize], most: usize) -> Vec<usize> {
        let mut smallest = left.to_vec();
        smallest.sort_by_key(|&w| (self.samples(w), self.witnesses[w].built.file.len()));
        let mut all = 0;
        let taken = smallest.iter().enumerate().take_while(|&(i, &w)| {
            all += self.samples(w) + self.witnesses[w].built.file.len();
            i < 1 || all <= most
        });
        let count = taken.count();
        smallest.truncate(count);
        smallest
    }

    /// Returns the cases or mistakes for which `holds` returns true.
    pub fn select(&self, all: Vec<usize>, holds: impl Fn(usize) -> bool + Sync) -> Vec<usize> {
        let flags = self.each(&all, |&one| holds(one));
        let pairs = all.into_iter().zip(flags);
        pairs.filter_map(|(one, is)| is.then_some(one)).collect()
    }

    /// Returns `work` of every item, in order, computed on all threads.
    pub fn each<T: Sync, R: Send>(&self, items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
        in_parallel(items.len(), self.threads, &|_, _| (), &|i| {
            let done = catch_unwind(AssertUnwindSafe(|| work(&items[i])));
            done.unwrap_or_else(|panic| {
                self.record_panic(&*panic);
                resume_unwind(panic)
            })
        })
    }
}

fn worth(agreement: Agreement) -> i64 {
    match agreement {
        Agreement::Image => WORTH_OF_AN_IMAGE,
        Agreement::Word => WORTH_OF_A_REFUSAL,
        Agreement::Crash => WORTH_OF_A_CRASH,
        Agreement::None => 0,
        Agreement::Against => WORTH_OF_A_REFUSAL_OF_AN_IMAGE,
    }
}

pub(super) fn ids_of(members: &[Member]) -> Set {
    members.iter().map(|member| member.id).collect()
}

/// Returns the other members of a set.
pub(super) fn without_id(set: &[Id], member: Id) -> Set {
    let others = set.iter().copied().filter(|&other| other != member);
    others.collect()
}

fn with_id(set: &[Id], id: Id) -> Set {
    [set, &[id]].concat()
}

/// Returns the first of each kind, then the second of each, and so on.
pub(super) fn spread<K: Ord>(places: &[usize], kind: impl Fn(usize) -> K) -> Vec<usize> {
    let mut kinds: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for &place in places {
        kinds.entry(kind(place)).or_default().push(place);
    }
    let longest = kinds.values().map(Vec::len).max().unwrap_or_default();
    let mut order = Vec::with_capacity(places.len());
    for turn in 0..longest {
        order.extend(kinds.values().filter_map(|members| members.get(turn)));
    }
    order
}
