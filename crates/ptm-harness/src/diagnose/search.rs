//! Searches for a small set of mistakes that reproduces the decoder's responses.
//!
//! The set grows by one mistake at a time: the one that explains the most remaining failures with the fewest contradictions. If
//! no single mistake explains more failures, the set grows by a pair. Finally, redundant mistakes are dropped.

use std::any::Any;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

pub(super) use super::tuning::REFUSAL_SCORE;
use super::tuning::{
    CONTRADICTION_SCORE, CRASH_SCORE, IMAGE_SCORE, MAX_EDIT_PASSES, MAX_FALLBACK_CASES,
    MAX_FINALISTS, MAX_MISTAKES, MAX_PAIR_WORK, MAX_PAIRS, MAX_SAMPLE, MAX_SMALL_IMAGE_SAMPLES,
    MAX_TRIED_SAMPLES, MAX_WORK, MIN_SUPPORT, OTHER_LENIENT_ANSWER_SCORE, REFUSED_IMAGE_SCORE,
    SAMPLES_PER_WORK_UNIT, is_most, is_nearly_all, is_substantial,
};
use super::witness::{Agreement, Witness};
use super::words::{nondeterminism, uniform};
use super::{mistake::Mistake, pair::partial_credit};
use crate::session::run::Run;
use ptm_mistakes::{Change, Misreading};
use ptm_suite::cases::Expect;
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::Answer;

/// A mistake that was found, and the mistakes that are equivalent to it. Lists of members are in the order of discovery.
pub(super) struct Member {
    pub id: MistakeId,
    /// Mistakes that explain the same cases.
    pub equivalents: MistakeSet,
}

pub(super) struct Search<'a> {
    pub witnesses: &'a [Witness<'a>],
    /// All candidates: the misreadings in the catalog, and the mistakes that were added.
    pub mistakes: Vec<Mistake>,
    /// Mistakes that the user knows about. Every set includes them, and they are never reported.
    pub assumed: MistakeSet,
    pub threads: usize,
    /// True if many responses are nondeterministic or do not depend on the file, so that any common property is a coincidence.
    pub is_arbitrary: bool,
    stop: &'a AtomicBool,
    /// Units of work done so far. An answer is one unit, or several if the map is large.
    work: &'a AtomicUsize,
    /// Number of answers computed so far.
    answer_count: AtomicUsize,
    /// Cases that the decoder passes, smallest first.
    pub passing: Vec<usize>,
    /// Messages of panics, without duplicates.
    faults: Mutex<Vec<String>>,
    /// Clauses of the failing cases.
    clauses: HashSet<&'a str>,
    /// Failing files on which every edit was tried, each with the mistakes in effect at the time.
    probed_files: HashSet<(usize, MistakeSet)>,
    /// Effects of sets of mistakes, by case and by the mistakes that affect the case.
    effects: Mutex<HashMap<(usize, MistakeSet), SetEffect>>,
    /// Effect of each single mistake on each case, or `None` if the mistake does not change the answer.
    single_effects: Vec<Vec<OnceLock<Option<SetEffect>>>>,
}

/// The effect of a set of mistakes on one case.
#[derive(Clone, Copy, PartialEq)]
struct SetEffect {
    score: i64,
    agreement: Agreement,
    /// Hash of the answer, or of the answer with the highest score if several answers are possible.
    answer: u64,
}

impl SetEffect {
    /// Effect of the reference's answer, which explains no failure.
    const NO_EFFECT: SetEffect = SetEffect {
        score: 0,
        agreement: Agreement::None,
        answer: 0,
    };
}

/// Index of a mistake in [`Search::mistakes`].
pub(super) type MistakeId = usize;

/// Mistakes that a decoder makes together.
pub(super) type MistakeSet = Vec<MistakeId>;

impl<'a> Search<'a> {
    pub fn new(
        witnesses: &'a [Witness<'a>],
        catalog: &[&'static Misreading],
        assumed: &'a [&'static Misreading],
        threads: usize,
        run: &'a Run,
    ) -> Search<'a> {
        let passing = (0..witnesses.len()).filter(|&w| !witnesses[w].failed);
        let mut passing: Vec<usize> = passing.collect();
        passing.sort_by_key(|&w| witnesses[w].built.file.len());
        let failing = witnesses.iter().filter(|witness| witness.failed);
        let clauses = failing.flat_map(|witness| &witness.case.clauses);
        let mistakes: Vec<Mistake> = catalog.iter().copied().map(Mistake::unscoped).collect();
        let is_assumed = |mistake: &Mistake| {
            let slug = mistake.misreading.slug;
            assumed.iter().any(|other| other.slug == slug)
        };
        Search {
            single_effects: vec![vec![OnceLock::new(); witnesses.len()]; mistakes.len()],
            assumed: (0..mistakes.len())
                .filter(|&id| is_assumed(&mistakes[id]))
                .collect(),
            mistakes,
            clauses: clauses.map(String::as_str).collect(),
            witnesses,
            threads,
            is_arbitrary: nondeterminism::is_prevalent(run) || uniform::is_prevalent(witnesses),
            stop: &run.stop,
            work: &run.work,
            answer_count: AtomicUsize::new(0),
            probed_files: HashSet::new(),
            effects: Mutex::new(HashMap::new()),
            faults: Mutex::new(Vec::new()),
            passing,
        }
    }

    /// Adds a candidate and returns its id.
    pub fn add(&mut self, mistake: Mistake) -> MistakeId {
        self.mistakes.push(mistake);
        self.single_effects
            .push(vec![OnceLock::new(); self.witnesses.len()]);
        self.mistakes.len() - 1
    }

    /// Returns true on the first call for this case and these mistakes.
    pub fn is_new_probe(&mut self, w: usize, set: &[MistakeId]) -> bool {
        let visible_mistakes = self.visible_mistakes(w, set);
        self.probed_files.insert((w, visible_mistakes))
    }

    /// Returns the indices of the failing cases.
    pub fn failing(&self) -> Vec<usize> {
        let all = 0..self.witnesses.len();
        all.filter(|&w| self.witnesses[w].failed).collect()
    }

    /// Returns the failing cases that `set` does not explain.
    pub fn unexplained(&self, set: &MistakeSet) -> Vec<usize> {
        self.select(self.failing(), |w| self.set_score(w, set) < REFUSAL_SCORE)
    }

    /// Returns a small set of mistakes that explains the failures. `add_candidates` adds candidates that are not in the catalog.
    pub fn run(
        &mut self,
        add_candidates: impl Fn(&mut Search, &MistakeSet, &[usize]),
    ) -> Vec<Member> {
        let mut members: Vec<Member> = Vec::new();
        let mut are_pairs_tried = false;
        let mut edit_passes = 0;
        while members.len() < MAX_MISTAKES && !self.is_interrupted() {
            let set = ids_of(&members);
            let left = self.unexplained(&set);
            if left.is_empty() || self.is_budget_spent() {
                break;
            }
            let mut single = self.best_single_mistake(&set, &left);
            // An edit may explain failures that would require several misreadings. If one misreading explains nearly
            // all failures, edits are not needed.
            let explains = |single: &Option<Member>, is_enough: fn(usize, usize) -> bool| {
                single.as_ref().is_some_and(|member| {
                    let gain = self.gain(&set, &[member.id], &left);
                    is_enough(gain, left.len())
                        && self.refuting_files(&with_id(&set, member.id)).is_empty()
                })
            };
            let is_enough = explains(&single, is_substantial);
            if !explains(&single, is_nearly_all) && edit_passes < MAX_EDIT_PASSES {
                edit_passes += 1;
                let added = catch_unwind(AssertUnwindSafe(|| add_candidates(self, &set, &left)));
                if let Err(panic) = added {
                    self.record_panic(&*panic);
                }
                single = self.best_single_mistake(&set, &left);
            }
            let mut grown = single.map(|single| vec![single]);
            if grown.is_none() || !is_enough && !are_pairs_tried {
                are_pairs_tried = true;
                let gain = |more: &Vec<Member>| self.gain(&set, &ids_of(more), &left);
                let pair = self.best_pair_on_images(&set, &left);
                // A pair must explain more than twice as many failures as a single mistake.
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
        self.drop_redundant(&mut members);
        members
    }

    /// Returns the cost of a result. The cost grows with the number of mistakes and the number of unexplained failures.
    pub fn cost(&self, found: &[Member]) -> usize {
        self.unexplained(&ids_of(found)).len() + MIN_SUPPORT * found.len()
    }

    /// Returns the mistake with the largest gain when added to `set`.
    fn best_single_mistake(&self, set: &MistakeSet, left: &[usize]) -> Option<Member> {
        let mut all: MistakeSet = (0..self.mistakes.len())
            .filter(|&id| self.can_add(set, id))
            .collect();
        let best = self.pick_best(set, &mut all, &self.sample(left));
        best.or_else(|| {
            let mut smallest = self.smallest(left, MAX_TRIED_SAMPLES);
            smallest.truncate(MAX_FALLBACK_CASES);
            self.pick_best(set, &mut all, &smallest)
        })
    }

    fn can_add(&self, set: &MistakeSet, id: MistakeId) -> bool {
        !set.contains(&id) && !self.assumed.contains(&id)
    }

    /// Returns how well the answer of a decoder with the mistakes in `set` agrees with the response to case `w`.
    pub fn agreement(&self, w: usize, set: &[MistakeId]) -> Agreement {
        self.effect(w, set).agreement
    }

    /// Returns true if a decoder with the mistakes in `set` would fail case `w`, which the decoder under test passes.
    pub fn is_refuted(&self, w: usize, set: &[MistakeId]) -> bool {
        self.set_score(w, set) == CONTRADICTION_SCORE
    }

    /// Returns true if the two sets lead to different answers to case `w`.
    pub fn answers_differ(&self, w: usize, set: &[MistakeId], other: &[MistakeId]) -> bool {
        self.effect(w, set).answer != self.effect(w, other).answer
    }

    /// Returns the passing cases that a decoder with the mistakes in `set` would fail.
    pub fn contradictions(&self, set: &[MistakeId]) -> Vec<usize> {
        let mut passing = self.passing.clone();
        passing.sort_unstable();
        self.select(passing, |w| self.is_refuted(w, set))
    }

    /// Like `contradictions`, but only for small files.
    pub fn refuting_files(&self, set: &[MistakeId]) -> Vec<usize> {
        let small = self.passing.iter().copied().filter(|&w| self.is_small(w));
        self.select(small.collect(), |w| self.is_refuted(w, set))
    }

    /// Like `agreement`, but with one more mistake, which need not be a candidate.
    pub fn agreement_with(&self, w: usize, set: &[MistakeId], mistake: &Mistake) -> Agreement {
        let witness = &self.witnesses[w];
        match witness.can_explain(mistake) {
            true => witness.evidence(&self.answer_with(w, set, mistake)),
            false => Agreement::None,
        }
    }

    /// Returns true if one more mistake changes the answer of a decoder with the mistakes in `set`.
    pub fn changes_answer_with(&self, w: usize, set: &[MistakeId], mistake: &Mistake) -> bool {
        self.witnesses[w].can_affect(mistake)
            && self.fingerprint(w, &self.answer_with(w, set, mistake)) != self.effect(w, set).answer
    }

    /// Returns the small passing files that a decoder with `set` and one more mistake would fail. For an edit, ignores predicted
    /// refusals and files that need not be decoded, because an edit does not model the checks of a decoder.
    pub fn refuting_files_with(&self, set: &[MistakeId], mistake: &Mistake) -> Vec<usize> {
        let is_refuted = |&w: &usize| {
            let witness = &self.witnesses[w];
            if !self.is_small(w) || !witness.can_affect(mistake) {
                return false;
            }
            let answer = self.answer_with(w, set, mistake);
            let is_check = *answer == Answer::Rejected || witness.case.expect != Expect::Decode;
            let is_irrelevant = mistake.catalog_misreading().is_none() && is_check;
            !is_irrelevant && witness.contradicts(&answer)
        };
        self.passing.iter().copied().filter(is_refuted).collect()
    }

    pub fn answer_with(&self, w: usize, set: &[MistakeId], mistake: &Mistake) -> Cow<'_, Answer> {
        let mut mistakes = self.mistakes_in(&self.visible_mistakes(w, set));
        mistakes.push(mistake);
        self.count_work(w, 1);
        self.answer(w, &mistakes)
    }

    fn count_work(&self, w: usize, answers: usize) {
        let units = answers * (1 + self.sample_count(w) / SAMPLES_PER_WORK_UNIT);
        self.work.fetch_add(units, Ordering::Relaxed);
    }

    /// Returns the answer of a decoder with the mistakes in `set` and the assumed ones. If several answers are
    /// possible, returns the one that agrees best with the response.
    pub fn best_answer(&self, w: usize, set: &[MistakeId]) -> Cow<'_, Answer> {
        let mut answers = self.answers_of_variants(w, &self.visible_mistakes(w, set));
        let best = (0..answers.len())
            .min_by_key(|&i| -self.score_of_answer(w, &answers[i]))
            .unwrap_or(0);
        answers.swap_remove(best)
    }

    /// Returns true if `set` explains the response, possibly with mistakes that have an effect only in combination.
    pub fn explains(&self, w: usize, set: &[MistakeId]) -> bool {
        if self.agreement(w, set).explains() {
            return true;
        }
        let relevant_ids = self.relevant_ids(w, set);
        let visible_mistakes = self.visible_mistakes(w, set);
        if visible_mistakes.is_empty() || visible_mistakes.len() == relevant_ids.len() {
            return false;
        }
        let explains = |answer: &Cow<Answer>| self.witnesses[w].evidence(answer).explains();
        self.answers_of_variants(w, &relevant_ids)
            .iter()
            .any(explains)
    }

    /// Returns the mistakes in `set` and the assumed mistakes, except those that cannot change the answer.
    fn relevant_ids(&self, w: usize, set: &[MistakeId]) -> MistakeSet {
        let all = self.assumed.iter().chain(set).copied();
        all.filter(|&id| self.witnesses[w].can_affect(&self.mistakes[id]))
            .collect()
    }

    /// Returns all possible answers of a decoder with these mistakes. Tries conflicting mistakes one at a time.
    fn answers_of_variants(&self, w: usize, set: &[MistakeId]) -> Vec<Cow<'_, Answer>> {
        let mut variants: Vec<MistakeSet> = vec![Vec::new()];
        for &id in set {
            let mut grown = Vec::new();
            for variant in variants {
                let mut new = variant.clone();
                new.retain(|&other| self.can_combine(other, id));
                let replaces = new.len() < variant.len();
                new.push(id);
                for variant in replaces.then_some(variant).into_iter().chain([new]) {
                    if !grown.contains(&variant) {
                        grown.push(variant);
                    }
                }
            }
            variants = grown;
        }
        self.add_reversed_variants(&mut variants);
        self.count_work(w, variants.len());
        variants
            .iter()
            .map(|variant| self.answer(w, &self.mistakes_in(variant)))
            .collect()
    }

    /// Returns the answer of a decoder with these mistakes. If a bug makes the computation panic, returns the correct answer.
    fn answer(&self, w: usize, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let witness = &self.witnesses[w];
        self.answer_count.fetch_add(1, Ordering::Relaxed);
        let answer = catch_unwind(AssertUnwindSafe(|| {
            match witness.refuses_positions(mistakes) {
                true => Cow::Owned(Answer::Rejected),
                false => witness.answer(mistakes),
            }
        }));
        let answer = answer.map(|answer| match witness.matching_colors(mistakes, &answer) {
            Some(matching) => Cow::Owned(matching),
            None => answer,
        });
        answer.unwrap_or_else(|panic| {
            self.record_panic(&*panic);
            Cow::Borrowed(&witness.expected)
        })
    }

    /// Runs `work` and returns its result. If `work` panics, records the message and returns the default value.
    pub fn run_or_default<T: Default>(&self, work: impl FnOnce() -> T) -> T {
        catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
            self.record_panic(&*panic);
            T::default()
        })
    }

    /// Returns the number of answers computed so far.
    pub fn answer_count(&self) -> usize {
        self.answer_count.load(Ordering::Relaxed)
    }

    /// Returns the messages of all recorded panics.
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
        // Report a panic in a thread only once.
        let is_recorded = faults.contains(&text) || text == "a scoped thread panicked";
        if !is_recorded {
            faults.push(text);
        }
    }

    /// Adds the reverse of each variant in which the order of two mistakes matters. For example, a mistake that drops bytes at
    /// the start of a payload changes what another mistake finds at the end.
    fn add_reversed_variants(&self, variants: &mut Vec<MistakeSet>) {
        for i in 0..variants.len() {
            let variant = &variants[i];
            let is_ordered = |(i, &a): (usize, &MistakeId)| {
                let mut later = variant[i + 1..].iter();
                later.any(|&b| self.order_matters(a, b))
            };
            if variant.iter().enumerate().any(is_ordered) {
                variants.push(variant.iter().rev().copied().collect());
            }
        }
    }

    /// Returns true if both mistakes edit the bytes of the file, or both change the same formula.
    fn order_matters(&self, a: MistakeId, b: MistakeId) -> bool {
        let [one, other] = [a, b].map(|id| self.mistakes[id].misreading.formulas());
        self.edits_bytes(a) && self.edits_bytes(b)
            || one.iter().any(|formula| other.contains(formula))
    }

    fn edits_bytes(&self, id: MistakeId) -> bool {
        matches!(self.mistakes[id].misreading.change, Change::Bytes(_))
    }

    /// Returns the mistakes with the ids in `set`.
    pub fn mistakes_in(&self, set: &[MistakeId]) -> Vec<&Mistake> {
        set.iter().map(|&id| &self.mistakes[id]).collect()
    }

    /// Returns true if a decoder can make both mistakes. Two changes to the same decision exclude each other.
    fn can_combine(&self, a: MistakeId, b: MistakeId) -> bool {
        let [a, b] = [a, b].map(|id| self.mistakes[id].misreading);
        !(a.is_decision() && a.changes_same_step(b))
    }

    /// Returns true if the user interrupted the search. Results after an interrupt are meaningless.
    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns the score of `set` for case `w`.
    pub fn set_score(&self, w: usize, set: &[MistakeId]) -> i64 {
        self.effect(w, set).score
    }

    fn effect(&self, w: usize, set: &[MistakeId]) -> SetEffect {
        if self.is_interrupted() {
            return SetEffect::NO_EFFECT;
        }
        let visible_mistakes = self.visible_mistakes(w, set);
        if let [only] = visible_mistakes[..] {
            return self.effect_alone(w, only).unwrap_or(SetEffect::NO_EFFECT);
        }
        if visible_mistakes.is_empty() {
            return SetEffect::NO_EFFECT;
        }
        let cache = || self.effects.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (w, visible_mistakes);
        if let Some(&effect) = cache().get(&key) {
            return effect;
        }
        let answers = self.answers_of_variants(w, &key.1);
        let effects = answers.iter().map(|answer| self.answer_effect(w, answer));
        let best = effects.min_by_key(|effect| -effect.score);
        let effect = best.unwrap_or(SetEffect::NO_EFFECT);
        cache().insert(key, effect);
        effect
    }

    /// Returns the mistakes in `set` and the assumed mistakes, except those that do not change the answer on their own. Such
    /// mistakes rarely have an effect in combination. Edits of bytes may be kept, because they may have an effect only after
    /// another edit.
    fn visible_mistakes(&self, w: usize, set: &[MistakeId]) -> MistakeSet {
        let relevant_ids = self.relevant_ids(w, set);
        let alone = |&id: &MistakeId| Some((id, self.effect_alone(w, id)?));
        let visible: Vec<(MistakeId, SetEffect)> = relevant_ids.iter().filter_map(alone).collect();
        let is_explained = matches!(visible[..], [(_, effect)] if effect.score >= REFUSAL_SCORE);
        let are_bytes_changed = visible.iter().any(|&(id, _)| self.edits_bytes(id));
        let is_kept = |id: &MistakeId| {
            visible.iter().any(|(other, _)| other == id)
                || are_bytes_changed && !is_explained && self.edits_bytes(*id)
        };
        relevant_ids.into_iter().filter(is_kept).collect()
    }

    /// Returns the effect of one mistake without the assumed ones, or `None` if it does not change the answer.
    fn effect_alone(&self, w: usize, id: MistakeId) -> Option<SetEffect> {
        let witness = &self.witnesses[w];
        let mistake = &self.mistakes[id];
        *self.single_effects[id][w].get_or_init(|| {
            if !witness.can_affect(mistake) {
                return None;
            }
            self.count_work(w, 1);
            let answer = self.answer(w, &[mistake]);
            (*answer != witness.expected).then(|| self.answer_effect(w, &answer))
        })
    }

    fn answer_effect(&self, w: usize, answer: &Answer) -> SetEffect {
        SetEffect {
            score: self.score_of_answer(w, answer),
            agreement: self.witnesses[w].evidence(answer),
            answer: self.fingerprint(w, answer),
        }
    }

    /// Returns a hash of an answer, or 0 for the answer of a decoder without mistakes.
    fn fingerprint(&self, w: usize, answer: &Answer) -> u64 {
        if answer == self.witnesses[w].correct_answer() {
            return 0;
        }
        let mut hasher = DefaultHasher::new();
        std::mem::discriminant(answer).hash(&mut hasher);
        if let Answer::Decoded(frame) = answer {
            frame.hash(&mut hasher);
        }
        hasher.finish()
    }

    fn score_of_answer(&self, w: usize, answer: &Answer) -> i64 {
        let witness = &self.witnesses[w];
        let is_lenient = witness.case.expect.is_optional();
        if witness.failed {
            match witness.evidence(answer) {
                Agreement::None => partial_credit(witness, answer),
                agreement => agreement_score(agreement),
            }
        } else if witness.contradicts(answer) {
            CONTRADICTION_SCORE
        } else if is_lenient && witness.differs_from_lenient_response(answer) {
            OTHER_LENIENT_ANSWER_SCORE
        } else {
            0
        }
    }

    /// Returns the candidate in `all` that is the best addition to `set`. Tries every candidate on the cases in `tried`, and
    /// removes the finalists from `all`.
    fn pick_best(&self, set: &MistakeSet, all: &mut MistakeSet, tried: &[usize]) -> Option<Member> {
        let score: Vec<i64> = tried.iter().map(|&w| self.set_score(w, set)).collect();
        let gains = self.par_map(all, |&id| {
            let union = with_id(set, id);
            let gain = |(&w, &score): (&usize, &i64)| match self.can_explain(w, id) {
                true => (self.set_score(w, &union) - score).max(0),
                false => 0,
            };
            tried.iter().zip(&score).map(gain).sum::<i64>()
        });
        let mut promising: Vec<(i64, MistakeId)> =
            gains.into_iter().zip(all.iter().copied()).collect();
        promising.retain(|&(gain, _)| gain >= CRASH_SCORE);
        // Ties are broken in favor of misreadings of clauses that a failing case tests, then by the order of the catalog.
        promising.sort_by_key(|&(gain, id)| (-gain, !self.tests_misread_clause(id)));
        promising.truncate(MAX_FINALISTS);
        let finalists: MistakeSet = promising.into_iter().map(|(_, id)| id).collect();
        let best = self.pick_finalist(set, &finalists, &self.trial_flags(tried));
        all.retain(|id| !finalists.contains(id));
        best
    }

    fn can_explain(&self, w: usize, id: MistakeId) -> bool {
        self.witnesses[w].can_explain(&self.mistakes[id])
    }

    /// Returns one flag per case: true if mistakes should be tried on it. Skips large maps unless only large maps are left.
    fn trial_flags(&self, left: &[usize]) -> Vec<bool> {
        let with_large = left.iter().all(|&w| !self.is_small(w));
        let all = 0..self.witnesses.len();
        all.map(|w| with_large || self.is_small(w)).collect()
    }

    /// Returns the finalist with the highest total score on the cases marked in `tried`, and those that tie with it. Returns
    /// `None` if no score is high enough.
    fn pick_finalist(
        &self,
        set: &MistakeSet,
        finalists: &MistakeSet,
        tried: &[bool],
    ) -> Option<Member> {
        let score: Vec<i64> = (0..self.witnesses.len())
            .map(|w| if tried[w] { self.set_score(w, set) } else { 0 })
            .collect();
        let is_left = |&w: &usize| tried[w] && self.witnesses[w].failed && score[w] < REFUSAL_SCORE;
        let left: Vec<usize> = (0..score.len()).filter(is_left).collect();
        let gains = self.par_map(finalists, |&id| {
            let union = with_id(set, id);
            let gain = |&w: &usize| match self.can_explain(w, id) {
                true => self.set_score(w, &union) - score[w],
                false => 0,
            };
            left.iter().map(gain).collect::<Vec<i64>>()
        });
        let ranked = gains
            .iter()
            .enumerate()
            .map(|(index, gains)| (gains.iter().sum(), index));
        let mut ranked: Vec<(i64, usize)> = ranked.collect();
        ranked.sort_by_key(|&(gain, index)| (-gain, index));
        // Explained and passing cases can only contradict a mistake.
        let explained = (0..score.len()).filter(|&w| self.witnesses[w].failed && !is_left(&w));
        let others = explained
            .chain(self.passing.iter().copied())
            .filter(|&w| tried[w]);
        let others: Vec<usize> = others.collect();
        let mut scored: Vec<(i64, usize)> = Vec::new();
        for batch in ranked.chunks(self.threads.max(1) * 2) {
            let best = scored.iter().map(|&(total, _)| total).max();
            let min_score = best.map_or(CRASH_SCORE, |best| CRASH_SCORE.max(best - REFUSAL_SCORE));
            let totals = self.par_map(batch, |&(gain, index)| {
                self.total_score(set, finalists[index], &score, gain, min_score, &others)
            });
            let totals = totals.into_iter().zip(batch);
            scored.extend(totals.filter_map(|(total, &(_, index))| Some((total?, index))));
        }
        scored.sort_by_key(|&(total, index)| {
            (-total, !self.tests_misread_clause(finalists[index]), index)
        });
        let &(total, first) = scored.first()?;
        let ties = scored[1..].iter().filter(|&&(other, index)| {
            total - other < REFUSAL_SCORE && gains[index] == gains[first]
        });
        Some(Member {
            id: finalists[first],
            equivalents: ties.map(|&(_, index)| finalists[index]).collect(),
        })
    }

    fn tests_misread_clause(&self, id: MistakeId) -> bool {
        let listed = self.mistakes[id].catalog_misreading();
        listed.is_some_and(|misreading| self.clauses.contains(misreading.clause))
    }

    /// Returns the total score of a mistake with this `gain` on the unexplained cases, or `None` if the total is below
    /// `min_score`.
    fn total_score(
        &self,
        set: &MistakeSet,
        id: MistakeId,
        score: &[i64],
        gain: i64,
        min_score: i64,
        others: &[usize],
    ) -> Option<i64> {
        let union = with_id(set, id);
        let mut total = gain;
        for &w in others {
            if total < min_score {
                return None;
            }
            if self.witnesses[w].can_affect(&self.mistakes[id]) {
                total += self.set_score(w, &union) - score[w];
            }
        }
        (total >= min_score).then_some(total)
    }

    /// Returns the best pair of mistakes that together explain an image. On the smallest files, tries pairs of mistakes that each
    /// change the image.
    fn best_pair_on_images(&self, set: &MistakeSet, left: &[usize]) -> Option<Vec<Member>> {
        let mut images = self.comparable_images(left);
        images.sort_by_key(|&w| self.witnesses[w].built.file.len());
        let spent = || self.work.load(Ordering::Relaxed);
        let before_all = spent();
        let budget = || MAX_PAIR_WORK.saturating_sub(spent() - before_all);
        let format = |w: usize| self.witnesses[w].case.format();
        let mut best: Option<Vec<Member>> = None;
        let mut tried_formats = HashSet::new();
        for w in interleave_groups(&images, format) {
            // Try one file of each format, and more files only if no pair explains these.
            if budget() == 0 || best.is_some() && !tried_formats.insert(format(w)) {
                break;
            }
            tried_formats.insert(format(w));
            let pairs = self.explaining_pairs(w, set, budget());
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

    /// Counts the failures in `left` that `set` explains only with the additional mistakes in `more`.
    fn gain(&self, set: &[MistakeId], more: &[MistakeId], left: &[usize]) -> usize {
        let remaining = self.unexplained(&[set, more].concat());
        left.len().saturating_sub(remaining.len())
    }

    /// Returns pairs of mistakes that together explain case `w`. Tries at most `limit` pairs of mistakes that change the answer.
    fn explaining_pairs(&self, w: usize, set: &MistakeSet, limit: usize) -> Vec<[MistakeId; 2]> {
        let open: MistakeSet = (0..self.mistakes.len())
            .filter(|&id| self.can_add(set, id) && self.witnesses[w].can_affect(&self.mistakes[id]))
            .collect();
        let changing = self.select(open, |id| self.answers_differ(w, set, &with_id(set, id)));
        let pairs: Vec<[MistakeId; 2]> = changing
            .iter()
            .enumerate()
            .flat_map(|(i, &a)| changing[i + 1..].iter().map(move |&b| [a, b]))
            .filter(|&[a, b]| self.can_combine(a, b))
            .take(limit)
            .collect();
        let explains = |index: usize| {
            let union = [&set[..], &pairs[index]].concat();
            self.set_score(w, &union) >= REFUSAL_SCORE
        };
        let explaining = self.select((0..pairs.len()).collect(), explains);
        let explaining = explaining.into_iter().take(MAX_FALLBACK_CASES);
        explaining.map(|index| pairs[index]).collect()
    }

    /// Returns the pair that explains the most remaining failures. Tries all pairs on a sample, and the best ones on every case.
    fn best_pair(
        &self,
        set: &MistakeSet,
        pairs: Vec<[MistakeId; 2]>,
        left: &[usize],
    ) -> Option<Vec<Member>> {
        let is_tried = self.trial_flags(left);
        let all: Vec<usize> = (0..is_tried.len()).filter(|&w| is_tried[w]).collect();
        let mut pairs: Vec<([MistakeId; 2], i64)> =
            pairs.into_iter().map(|pair| (pair, 0)).collect();
        for tried in [&self.sample(left), &all] {
            let totals = self.par_map(&pairs, |&([a, b], _)| {
                let union = [&set[..], &[a, b]].concat();
                let gain = |&w: &usize| self.set_score(w, &union) - self.set_score(w, set);
                tried.iter().map(gain).sum::<i64>()
            });
            for (pair, total) in pairs.iter_mut().zip(totals) {
                pair.1 = total;
            }
            pairs.sort_by_key(|&(_, total)| -total);
            pairs.truncate(MAX_PAIRS);
        }
        let best = pairs.first();
        let &(pair, _) = best.filter(|&&(_, total)| total >= CRASH_SCORE)?;
        let member = |id| Member {
            id,
            equivalents: Vec::new(),
        };
        Some(pair.map(member).into())
    }

    /// Removes mistakes that add less than [`CRASH_SCORE`] to the total score, both on small maps and on large ones.
    fn drop_redundant(&self, members: &mut Vec<Member>) {
        let (small, large): (Vec<usize>, Vec<usize>) =
            (0..self.witnesses.len()).partition(|&w| self.is_small(w));
        let total = |set: &MistakeSet, cases: &[usize]| {
            let values = self.par_map(cases, |&w| self.set_score(w, set));
            values.iter().sum::<i64>()
        };
        for index in (0..members.len()).rev() {
            let all = ids_of(members);
            let mut rest = all.clone();
            rest.remove(index);
            let is_redundant =
                |cases: &[usize]| total(&rest, cases) + CRASH_SCORE > total(&all, cases);
            if !rest.is_empty() && is_redundant(&small) && is_redundant(&large) {
                members.remove(index);
            }
        }
    }

    /// Returns the cases in `left` with a wrong image that is small and has the correct shape.
    pub fn comparable_images(&self, left: &[usize]) -> Vec<usize> {
        let has_shape = |w: &usize| match (
            self.witnesses[*w].wrong_image(),
            &self.witnesses[*w].expected,
        ) {
            (Some(actual), Answer::Decoded(right)) => {
                actual.shape() == right.shape() && self.is_small(*w)
            }
            _ => false,
        };
        left.iter().copied().filter(has_shape).collect()
    }

    fn is_budget_spent(&self) -> bool {
        self.work.load(Ordering::Relaxed) > MAX_WORK
    }

    /// Returns a diverse sample of failing cases, small ones first.
    pub fn sample(&self, left: &[usize]) -> Vec<usize> {
        let kind = |w: usize| {
            let witness = &self.witnesses[w];
            (
                witness.observation.response.name(),
                witness.case.clauses.first().cloned(),
            )
        };
        let smallest = self.smallest(left, MAX_TRIED_SAMPLES);
        let mut sample = interleave_groups(&smallest, kind);
        sample.truncate(MAX_SAMPLE);
        sample
    }

    /// Returns the number of samples in the correct answer.
    pub fn sample_count(&self, w: usize) -> usize {
        match &self.witnesses[w].expected {
            Answer::Decoded(frame) => frame.samples.len(),
            _ => 0,
        }
    }

    /// Returns true if the image of witness `w` is small enough for every mistake to be tried on it.
    pub fn is_small(&self, w: usize) -> bool {
        self.sample_count(w) <= MAX_SMALL_IMAGE_SAMPLES
    }

    /// Returns the smallest of these cases: at least one, and otherwise as many as fit in `limit` samples and bytes in total.
    pub fn smallest(&self, left: &[usize], limit: usize) -> Vec<usize> {
        let mut smallest = left.to_vec();
        smallest.sort_by_key(|&w| (self.sample_count(w), self.witnesses[w].built.file.len()));
        let mut total = 0;
        let affordable = smallest.iter().enumerate().take_while(|&(i, &w)| {
            total += self.sample_count(w) + self.witnesses[w].built.file.len();
            i < 1 || total <= limit
        });
        let count = affordable.count();
        smallest.truncate(count);
        smallest
    }

    /// Returns the items that satisfy `predicate`, which is evaluated in parallel.
    pub fn select(&self, all: Vec<usize>, predicate: impl Fn(usize) -> bool + Sync) -> Vec<usize> {
        let flags = self.par_map(&all, |&item| predicate(item));
        let pairs = all.into_iter().zip(flags);
        pairs.filter_map(|(item, is)| is.then_some(item)).collect()
    }

    /// Maps `work` over all items in parallel. Preserves the order.
    pub fn par_map<T: Sync, R: Send>(&self, items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
        map_in_parallel(items.len(), self.threads, &|_, _| (), &|i| {
            let result = catch_unwind(AssertUnwindSafe(|| work(&items[i])));
            result.unwrap_or_else(|panic| {
                self.record_panic(&*panic);
                resume_unwind(panic)
            })
        })
    }
}

fn agreement_score(agreement: Agreement) -> i64 {
    match agreement {
        Agreement::Image => IMAGE_SCORE,
        Agreement::Outcome => REFUSAL_SCORE,
        Agreement::Crash => CRASH_SCORE,
        Agreement::None => 0,
        Agreement::Contradiction => REFUSED_IMAGE_SCORE,
    }
}

pub(super) fn ids_of(members: &[Member]) -> MistakeSet {
    members.iter().map(|member| member.id).collect()
}

pub(super) fn without_id(set: &[MistakeId], member: MistakeId) -> MistakeSet {
    let others = set.iter().copied().filter(|&other| other != member);
    others.collect()
}

fn with_id(set: &[MistakeId], id: MistakeId) -> MistakeSet {
    [set, &[id]].concat()
}

/// Groups items by kind, and interleaves the groups: the first item of each group, then the second of each, and so on.
pub(super) fn interleave_groups<K: Ord>(cases: &[usize], kind: impl Fn(usize) -> K) -> Vec<usize> {
    let mut kinds: BTreeMap<K, Vec<usize>> = BTreeMap::new();
    for &index in cases {
        kinds.entry(kind(index)).or_default().push(index);
    }
    let longest = kinds.values().map(Vec::len).max().unwrap_or_default();
    let mut order = Vec::with_capacity(cases.len());
    for round in 0..longest {
        order.extend(kinds.values().filter_map(|members| members.get(round)));
    }
    order
}
