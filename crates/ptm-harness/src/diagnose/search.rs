//! Covers the failures: searches for a small set of mistakes that reproduces the decoder's responses.
//!
//! The set grows by one mistake at a time: the one that reproduces the most remaining failures, and that no response contradicts.
//! Once, if no single mistake reproduces enough, the set may grow by a pair.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::{BTreeMap, HashSet};
use std::hash::{BuildHasher, Hash, Hasher};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use foldhash::quality::FixedState;
use foldhash::{HashMap, HashMapExt};

use super::mistake::Mistake;
use super::rules;
use super::tuning::{
    IMAGE_WEIGHT, MAX_EDIT_PASSES, MAX_FALLBACK_CASES, MAX_FINALISTS, MAX_MISTAKES, MAX_PAIR_WORK,
    MAX_PAIRS, MAX_SAMPLE, MAX_SMALL_IMAGE_SAMPLES, MAX_TRIED_SAMPLES, MAX_WORK, MIN_WEIGHT,
    NO_IMAGE_WEIGHT, REFUSAL_WEIGHT, SAMPLES_PER_WORK_UNIT, is_most, is_nearly_all, is_substantial,
};
use super::witness::{Agreement, Witness, count_equal_samples};
use super::words::{nondeterminism, uniform};
use crate::session::run::Run;
use ptm::Format;
use ptm_mistakes::{Change, Misreading};
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::{Answer, Frame};

/// A mistake that was found. Lists of members are in the order of discovery.
pub(super) struct Member {
    pub id: MistakeId,
    /// Mistakes that reproduce the same failures. Their answers may differ in other cases.
    pub alternatives: MistakeSet,
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
    /// Clauses of the failing cases.
    clauses: HashSet<&'a str>,
    /// Failing files on which every edit was tried, each with the mistakes in effect at the time.
    probed_files: HashSet<(usize, MistakeSet)>,
    /// Edits of some channels that did not explain enough. They are tried again when other mistakes are known.
    pub weak_edits: Vec<Mistake>,
    /// Effects of sets of mistakes, by case and by the mistakes that affect the case.
    effects: Mutex<HashMap<(usize, MistakeSet), Effect>>,
    /// Effect of each single mistake on each case, or `None` if the mistake does not change the answer.
    single_effects: Vec<Vec<OnceLock<Option<Effect>>>>,
    /// Effect of a decoder without mistakes on each case.
    no_effects: Vec<OnceLock<Effect>>,
}

/// The answer of a decoder with a set of mistakes to one case, compared with the response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Effect {
    pub agreement: Agreement,
    /// Hash of the answer, or 0 for the answer of a decoder without mistakes.
    pub answer: u64,
    /// Number of samples that equal those of a wrong image.
    pub equal_samples: usize,
    /// Number of samples that differ from those of the correct image.
    pub changed_samples: usize,
}

impl Effect {
    /// Returns the rank of an answer among several possible ones: the larger, the better it agrees with the response.
    fn rank(&self) -> (bool, bool, usize) {
        let is_neutral = self.agreement != Agreement::Contradiction;
        (self.agreement.explains(), is_neutral, self.equal_samples)
    }

    fn weight(&self) -> i64 {
        match self.agreement {
            Agreement::Image => IMAGE_WEIGHT,
            Agreement::TwinImage | Agreement::Refusal => REFUSAL_WEIGHT,
            Agreement::NoImage => NO_IMAGE_WEIGHT,
            Agreement::BlankImage | Agreement::None | Agreement::Contradiction => 0,
        }
    }
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
        let failing = witnesses.iter().filter(|witness| witness.failed);
        let clauses = failing.flat_map(|witness| &witness.case.clauses);
        let mistakes: Vec<Mistake> = catalog.iter().copied().map(Mistake::unrestricted).collect();
        let is_assumed = |mistake: &Mistake| {
            let slug = mistake.misreading.slug;
            assumed.iter().any(|other| other.slug == slug)
        };
        Search {
            single_effects: vec![vec![OnceLock::new(); witnesses.len()]; mistakes.len()],
            no_effects: vec![OnceLock::new(); witnesses.len()],
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
            weak_edits: Vec::new(),
            effects: Mutex::new(HashMap::new()),
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

    /// Returns the indices in the suite of these cases.
    pub fn case_indices(&self, cases: &[usize]) -> Vec<usize> {
        cases
            .iter()
            .map(|&w| self.witnesses[w].case_index)
            .collect()
    }

    /// Returns the failing cases that `set` does not reproduce.
    pub fn unexplained(&self, set: &MistakeSet) -> Vec<usize> {
        self.select(self.failing(), |w| !self.agreement(w, set).explains())
    }

    /// Returns the failing cases among `tried` that `set` does not reproduce.
    fn unexplained_among(&self, tried: &[usize], set: &[MistakeId]) -> Vec<usize> {
        let is_left = |w: &usize| self.witnesses[*w].failed && !self.agreement(*w, set).explains();
        tried.iter().copied().filter(is_left).collect()
    }

    /// Returns a small set of mistakes that reproduces failures. `add_candidates` adds candidates that are not in the catalog.
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
            if let ([member], 0) = (&members[..], edit_passes) {
                edit_passes += 1;
                add_candidates(self, &Vec::new(), &left);
                if let Some(better) = self.better_single_mistake(member.id) {
                    members = vec![better];
                    continue;
                }
            }
            let mut single = self.best_single_mistake(&set, &left);
            let share_of = |single: &Option<Member>, is_enough: fn(usize, usize) -> bool| {
                single.as_ref().is_some_and(|member| {
                    is_enough(self.gain(&set, &[member.id], &left), left.len())
                })
            };
            let is_enough = share_of(&single, is_substantial);
            // An edit may explain failures that would require several misreadings.
            if !share_of(&single, is_nearly_all) && edit_passes < MAX_EDIT_PASSES {
                edit_passes += 1;
                add_candidates(self, &set, &left);
                single = self.best_single_mistake(&set, &left);
            }
            let mut grown = single.map(|single| vec![single]);
            if !is_enough && !are_pairs_tried {
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
        self.lift_restrictions(&mut members);
        members
    }

    /// Returns a mistake that alone reproduces more failures than `id`, which was chosen before the edits were tried.
    fn better_single_mistake(&self, id: MistakeId) -> Option<Member> {
        let none = Vec::new();
        let all = self.unexplained(&none);
        let better = self.best_single_mistake(&none, &all)?;
        let is_better = self.gain(&none, &[better.id], &all) > self.gain(&none, &[id], &all);
        is_better.then_some(better)
    }

    /// Replaces misreadings that are restricted to some formats by the whole misreading, unless a response contradicts it. Another
    /// mistake, which was found later, may have hidden it in the other formats.
    fn lift_restrictions(&self, members: &mut Vec<Member>) {
        for index in (0..members.len()).rev() {
            let mistake = &self.mistakes[members[index].id];
            let is_whole = |id: &MistakeId| {
                let whole = self.mistakes[*id].unrestricted_misreading();
                whole.is_some_and(|whole| whole.slug == mistake.misreading.slug)
            };
            let whole = (0..self.mistakes.len()).find(is_whole);
            let Some(whole) = whole.filter(|&whole| whole != members[index].id) else {
                continue;
            };
            let mut others = ids_of(members);
            others.remove(index);
            if others.contains(&whole) {
                members.remove(index);
            } else if !self.is_contradicted_in(&self.trial_cases(&[]), &others, whole) {
                members[index].id = whole;
            }
        }
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

    /// Returns the agreement of the answer of a decoder with the mistakes in `set` with the response to case `w`.
    pub fn agreement(&self, w: usize, set: &[MistakeId]) -> Agreement {
        self.effect(w, set).agreement
    }

    /// Returns true if the two sets lead to different answers to case `w`.
    pub fn answers_differ(&self, w: usize, set: &[MistakeId], other: &[MistakeId]) -> bool {
        self.effect(w, set).answer != self.effect(w, other).answer
    }

    /// Returns true if the response to case `w` contradicts the mistake `id` of a decoder that also makes the mistakes in `set`. A
    /// mistake in `set` that excludes `id` does not explain the response of a decoder with `id`.
    pub fn is_contradicted(&self, w: usize, set: &[MistakeId], id: MistakeId) -> bool {
        let mistake = &self.mistakes[id];
        let mut both = set.to_vec();
        both.retain(|&other| self.can_combine(other, id));
        both.push(id);
        let contradicts = |without: Effect, with: Effect| {
            self.witnesses[w].can_contradict(mistake, with.agreement)
                && rules::contradicts(without, with)
        };
        // Mistakes that have an effect only in combination take long to try.
        self.witnesses[w].can_affect(mistake)
            && contradicts(self.effect(w, set), self.effect(w, &both))
            && contradicts(self.whole_effect(w, set), self.whole_effect(w, &both))
    }

    /// Like [`effect`](Self::effect), but also of mistakes that have an effect only in combination.
    fn whole_effect(&self, w: usize, set: &[MistakeId]) -> Effect {
        self.combined_effect(w, self.relevant_ids(w, set))
    }

    /// Like [`agreement`](Self::agreement), but with one more mistake, which need not be a candidate.
    pub fn agreement_with(&self, w: usize, set: &[MistakeId], mistake: &Mistake) -> Agreement {
        let witness = &self.witnesses[w];
        match witness.can_explain(mistake) {
            true => witness.agreement(&self.answer_with(w, set, mistake)),
            false => Agreement::None,
        }
    }

    /// Returns the agreement of a decoder with one more mistake, if the mistake changes the answer of a decoder with the mistakes in
    /// `set`.
    pub fn changed_agreement_with(
        &self,
        w: usize,
        set: &[MistakeId],
        mistake: &Mistake,
    ) -> Option<Agreement> {
        if !self.witnesses[w].can_affect(mistake) {
            return None;
        }
        let answer = self.answer_with(w, set, mistake);
        let is_changed = self.fingerprint(w, &answer) != self.effect(w, set).answer;
        is_changed.then(|| self.witnesses[w].agreement(&answer))
    }

    /// Returns the formats of small files whose responses contradict one more mistake, which need not be a candidate.
    pub fn contradicted_formats(&self, set: &[MistakeId], mistake: &Mistake) -> Vec<Format> {
        let mut formats = Vec::new();
        for (w, witness) in self.witnesses.iter().enumerate() {
            let format = witness.case.format();
            if formats.contains(&format) || !self.is_small(w) || !witness.can_affect(mistake) {
                continue;
            }
            let with = self.compare(w, &self.answer_with(w, set, mistake));
            if witness.can_contradict(mistake, with.agreement)
                && rules::contradicts(self.effect(w, set), with)
            {
                formats.push(format);
            }
        }
        formats.sort_unstable();
        formats
    }

    /// Returns the answer of a decoder with one more mistake, which need not be a candidate. If several answers are possible, returns
    /// the one that agrees best with the response.
    pub fn answer_with(&self, w: usize, set: &[MistakeId], mistake: &Mistake) -> Cow<'_, Answer> {
        let mut mistakes = self.mistakes_in(&self.visible_mistakes(w, set));
        mistakes.push(mistake);
        self.count_work(w, 1);
        self.best_of(w, self.answers(w, &mistakes))
    }

    fn count_work(&self, w: usize, answers: usize) {
        let units = answers * (1 + self.sample_count(w) / SAMPLES_PER_WORK_UNIT);
        self.work.fetch_add(units, Ordering::Relaxed);
    }

    /// Returns the answer of a decoder with the mistakes in `set` and the assumed ones. If several answers are
    /// possible, returns the one that agrees best with the response.
    pub fn best_answer(&self, w: usize, set: &[MistakeId]) -> Cow<'_, Answer> {
        let answers = self.answers_of_variants(w, &self.visible_mistakes(w, set));
        self.best_of(w, answers)
    }

    /// Returns the answer that agrees best with the response.
    fn best_of<'b>(&self, w: usize, mut answers: Vec<Cow<'b, Answer>>) -> Cow<'b, Answer> {
        if answers.len() == 1 {
            return answers.swap_remove(0);
        }
        // `max_by_key` returns the last maximum, but the first answer is the one in the decoder's dialect.
        let best = (0..answers.len())
            .rev()
            .max_by_key(|&i| self.compare(w, &answers[i]).rank());
        answers.swap_remove(best.unwrap_or(0))
    }

    /// Returns true if `set` reproduces the response, possibly with mistakes that have an effect only in combination.
    pub fn explains(&self, w: usize, set: &[MistakeId]) -> bool {
        if self.agreement(w, set).explains() {
            return true;
        }
        let relevant_ids = self.relevant_ids(w, set);
        let visible_mistakes = self.visible_mistakes(w, set);
        if visible_mistakes.is_empty() || visible_mistakes.len() == relevant_ids.len() {
            return false;
        }
        let explains = |answer: &Cow<Answer>| self.witnesses[w].agreement(answer).explains();
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
        // A decoder reads a file from its start, so a mistake in an earlier section comes first.
        let mut in_order = set.to_vec();
        in_order.sort_by_key(|&id| self.mistakes[id].section());
        for id in in_order {
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
            .flat_map(|variant| self.answers(w, &self.mistakes_in(variant)))
            .collect()
    }

    /// Returns the answers of a decoder with these mistakes: in its dialect and, if the mistakes may look like an answer to an open
    /// question, in the reading of the reference.
    fn answers(&self, w: usize, mistakes: &[&Mistake]) -> Vec<Cow<'_, Answer>> {
        let witness = &self.witnesses[w];
        self.answer_count.fetch_add(1, Ordering::Relaxed);
        let mut answer = witness.answer(mistakes);
        if *answer == Answer::Rejected
            && let Some(image) = witness.answer_beyond_data(mistakes)
        {
            answer = Cow::Owned(image);
        }
        let beyond_texel = witness.answer_beyond_texel(mistakes, &answer);
        let mut answers = match witness.matching_colors(mistakes, &answer) {
            Some(matching) => vec![Cow::Owned(matching)],
            None => vec![answer],
        };
        answers.extend(beyond_texel.map(Cow::Owned));
        if mistakes.is_empty() {
            return answers;
        }
        answers.extend(witness.answer_in_other_reading(mistakes).map(Cow::Owned));
        answers
    }

    /// Returns the effect of the answer that agrees best with the response.
    fn best_effect(&self, w: usize, answers: &[Cow<Answer>]) -> Effect {
        let effects = answers.iter().map(|answer| self.compare(w, answer));
        let best = effects.rev().max_by_key(Effect::rank);
        best.unwrap_or(self.no_effect(w))
    }

    /// Returns the number of answers computed so far.
    pub fn answer_count(&self) -> usize {
        self.answer_count.load(Ordering::Relaxed)
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
        self.edits_bytes(a) && self.edits_bytes(b) || self.change_same_formula(a, b)
    }

    fn change_same_formula(&self, a: MistakeId, b: MistakeId) -> bool {
        let [one, other] = [a, b].map(|id| self.mistakes[id].misreading.formulas());
        one.iter().any(|formula| other.contains(formula))
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

    /// Returns true if both are different mistakes that change the same value in the files of some format.
    pub fn change_same_value(&self, a: MistakeId, b: MistakeId) -> bool {
        let [one, other] = [a, b].map(|id| &self.mistakes[id]);
        let changes_values = |mistake: &Mistake| !mistake.misreading.may_refuse();
        let share_formats = Format::ALL
            .into_iter()
            .any(|format| one.affects(format) && other.affects(format));
        let make_same_decision =
            || changes_values(one) && changes_values(other) && !self.can_combine(a, b);
        a != b && share_formats && (self.change_same_formula(a, b) || make_same_decision())
    }

    /// Returns true if the user interrupted the search. Results after an interrupt are meaningless.
    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Returns the effect of `set` on case `w`. If several answers are possible, returns the effect of the one that agrees best.
    pub fn effect(&self, w: usize, set: &[MistakeId]) -> Effect {
        if self.is_interrupted() {
            return self.no_effect(w);
        }
        self.combined_effect(w, self.visible_mistakes(w, set))
    }

    /// Returns the effect of mistakes that change the answer, alone or together.
    fn combined_effect(&self, w: usize, visible_mistakes: MistakeSet) -> Effect {
        match visible_mistakes[..] {
            [] => return self.no_effect(w),
            [only] => return self.effect_alone(w, only).unwrap_or(self.no_effect(w)),
            _ => {}
        }
        let cache = || self.effects.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (w, visible_mistakes);
        if let Some(&effect) = cache().get(&key) {
            return effect;
        }
        let effect = self.best_effect(w, &self.answers_of_variants(w, &key.1));
        cache().insert(key, effect);
        effect
    }

    fn no_effect(&self, w: usize) -> Effect {
        *self.no_effects[w].get_or_init(|| self.compare(w, &self.witnesses[w].expected))
    }

    /// Returns the mistakes in `set` and the assumed mistakes that change the answer on their own, and then those that change it
    /// only together with the former: mistakes about a malformed file that another mistake makes readable, and edits of bytes after
    /// another edit.
    fn visible_mistakes(&self, w: usize, set: &[MistakeId]) -> MistakeSet {
        let alone = |id: MistakeId| Some((id, self.effect_alone(w, id)?));
        let all = self.assumed.iter().chain(set).copied();
        let (mut visible, effects): (MistakeSet, Vec<Effect>) = all.filter_map(alone).unzip();
        let is_explained = matches!(effects[..], [effect] if effect.agreement.explains());
        let is_readable = !visible.is_empty() && self.witnesses[w].expected == Answer::Rejected;
        let are_bytes_changed = !is_explained && visible.iter().any(|&id| self.edits_bytes(id));
        if !is_readable && !are_bytes_changed {
            return visible;
        }
        let unchanged = self.combined_effect(w, visible.clone()).answer;
        let is_seen_together = |&id: &MistakeId| {
            !visible.contains(&id)
                && (is_readable || self.edits_bytes(id))
                && self.combined_effect(w, with_id(&visible, id)).answer != unchanged
        };
        let mut others = self.relevant_ids(w, set);
        others.retain(is_seen_together);
        visible.extend(others);
        visible
    }

    /// Returns the effect of one mistake without the assumed ones, or `None` if it does not change the answer.
    pub fn effect_alone(&self, w: usize, id: MistakeId) -> Option<Effect> {
        let witness = &self.witnesses[w];
        let mistake = &self.mistakes[id];
        *self.single_effects[id][w].get_or_init(|| {
            if !witness.can_affect(mistake) {
                return None;
            }
            self.count_work(w, 1);
            let answers = self.answers(w, &[mistake]);
            let is_changed = answers.iter().any(|answer| **answer != witness.expected);
            is_changed.then(|| self.best_effect(w, &answers))
        })
    }

    /// Compares an answer with the response to case `w`.
    fn compare(&self, w: usize, answer: &Answer) -> Effect {
        let witness = &self.witnesses[w];
        let count_equal = |other: Option<&Frame>| match (answer, other) {
            (Answer::Decoded(image), Some(other)) => count_equal_samples(image, other),
            _ => 0,
        };
        let (received, samples) = match (witness.wrong_image(), answer) {
            (received, Answer::Decoded(image)) => (received, image.samples.len()),
            _ => (None, 0),
        };
        let fingerprint = self.fingerprint(w, answer);
        let correct = match &witness.expected {
            Answer::Decoded(image) if received.is_some() => Some(image),
            _ => None,
        };
        let unchanged = match fingerprint {
            0 if correct.is_some() => samples,
            _ => count_equal(correct),
        };
        Effect {
            agreement: witness.agreement(answer),
            answer: fingerprint,
            equal_samples: count_equal(received),
            changed_samples: samples - unchanged,
        }
    }

    /// Returns a hash of an answer, or 0 for the answer of a decoder without mistakes.
    fn fingerprint(&self, w: usize, answer: &Answer) -> u64 {
        if *answer == self.witnesses[w].expected {
            return 0;
        }
        let mut hasher = FixedState::default().build_hasher();
        std::mem::discriminant(answer).hash(&mut hasher);
        if let Answer::Decoded(frame) = answer {
            frame.hash(&mut hasher);
        }
        hasher.finish()
    }

    /// Returns the weight of each failure in `left` that `set` reproduces with `more`. None may be reproduced by `set` alone.
    fn added_weight(&self, set: &[MistakeId], more: &[MistakeId], left: &[usize]) -> Vec<i64> {
        let union = [set, more].concat();
        let added = |&w: &usize| match more.iter().any(|&id| self.can_explain(w, id)) {
            true => self.effect(w, &union).weight(),
            false => 0,
        };
        left.iter().map(added).collect()
    }

    /// Returns the number of received samples that `set` with `id` gives exactly, in the failures in `left` that it reproduces.
    fn equal_samples(&self, set: &[MistakeId], id: MistakeId, left: &[usize]) -> usize {
        let union = with_id(set, id);
        let can_explain = |w: &&usize| self.can_explain(**w, id);
        let effects = left
            .iter()
            .filter(can_explain)
            .map(|&w| self.effect(w, &union));
        let reproduced = effects.filter(|effect| effect.agreement.explains());
        reproduced.map(|effect| effect.equal_samples).sum()
    }

    /// Returns the candidate in `all` that is the best addition to `set`. Tries every candidate on the cases in `tried`, and
    /// removes the finalists from `all`.
    fn pick_best(&self, set: &MistakeSet, all: &mut MistakeSet, tried: &[usize]) -> Option<Member> {
        let weights = self.par_map(all, |&id| {
            let added = self.added_weight(set, &[id], tried);
            added.iter().sum::<i64>()
        });
        let mut promising: Vec<(i64, MistakeId)> =
            weights.into_iter().zip(all.iter().copied()).collect();
        promising.retain(|&(weight, _)| weight >= MIN_WEIGHT);
        // Ties are broken in favor of misreadings of clauses that a failing case tests, then by the order of the catalog.
        promising.sort_by_key(|&(weight, id)| (-weight, !self.tests_misread_clause(id)));
        promising.truncate(MAX_FINALISTS);
        let finalists: MistakeSet = promising.into_iter().map(|(_, id)| id).collect();
        let best = self.pick_finalist(set, &finalists, &self.trial_cases(tried));
        all.retain(|id| !finalists.contains(id));
        best
    }

    fn can_explain(&self, w: usize, id: MistakeId) -> bool {
        self.witnesses[w].can_explain(&self.mistakes[id])
    }

    /// Returns the cases on which finalists are tried, with small files first. Skips large maps unless only large maps are left.
    fn trial_cases(&self, left: &[usize]) -> Vec<usize> {
        let with_large = !left.is_empty() && left.iter().all(|&w| !self.is_small(w));
        let is_tried = |w: &usize| with_large || self.is_small(*w);
        let mut cases: Vec<usize> = (0..self.witnesses.len()).filter(is_tried).collect();
        cases.sort_by_key(|&w| self.witnesses[w].built.file.len());
        cases
    }

    /// Returns the finalist that reproduces the most failures and that no response contradicts, and the alternatives to it.
    fn pick_finalist(
        &self,
        set: &MistakeSet,
        finalists: &MistakeSet,
        tried: &[usize],
    ) -> Option<Member> {
        let left = self.unexplained_among(tried, set);
        let added = self.par_map(finalists, |&id| self.added_weight(set, &[id], &left));
        let mut ranked: Vec<(i64, usize)> = added
            .iter()
            .enumerate()
            .map(|(index, added)| (added.iter().sum(), index))
            .collect();
        // Of mistakes that reproduce the same colors up to rounding, the one that gives more of them exactly comes first.
        let most = ranked.iter().map(|&(weight, _)| weight).max();
        let equal = self.par_map(&ranked, |&(weight, index)| {
            let is_tied = Some(weight) == most;
            is_tied.then(|| self.equal_samples(set, finalists[index], &left))
        });
        ranked.sort_by_key(|&(weight, index)| {
            let is_tested = self.tests_misread_clause(finalists[index]);
            (-weight, !is_tested, Reverse(equal[index]), index)
        });
        let is_possible = |&&(weight, index): &&(i64, usize)| {
            weight >= MIN_WEIGHT && !self.is_contradicted_in(tried, set, finalists[index])
        };
        for batch in ranked.chunks(self.threads.max(1)) {
            let possible = self.par_map(batch, |ranked| is_possible(&ranked));
            let Some(first) = possible.iter().position(|&possible| possible) else {
                continue;
            };
            let (_, first) = batch[first];
            let ties = ranked
                .iter()
                .filter(|&&(_, other)| other != first && added[other] == added[first]);
            let ties: MistakeSet = ties.map(|&(_, index)| finalists[index]).collect();
            let possible = self.select(ties, |id| !self.is_contradicted_in(tried, set, id));
            return Some(Member {
                id: finalists[first],
                alternatives: possible,
            });
        }
        None
    }

    /// Returns true if any response, also to a large file, contradicts the mistake. Tries small files first, because large ones are
    /// slow.
    pub fn is_contradicted_anywhere(&self, set: &[MistakeId], id: MistakeId) -> bool {
        let (small, large): (Vec<usize>, Vec<usize>) =
            (0..self.witnesses.len()).partition(|&w| self.is_small(w));
        self.is_contradicted_in(&small, set, id) || self.is_contradicted_in(&large, set, id)
    }

    /// Returns true if the response to one of these cases contradicts the mistake.
    fn is_contradicted_in(&self, tried: &[usize], set: &[MistakeId], id: MistakeId) -> bool {
        tried.iter().any(|&w| self.is_contradicted(w, set, id))
    }

    fn tests_misread_clause(&self, id: MistakeId) -> bool {
        let listed = self.mistakes[id].catalog_misreading();
        listed.is_some_and(|misreading| self.clauses.contains(misreading.clause))
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
            self.agreement(w, &union) == Agreement::Image
        };
        let explaining = self.select((0..pairs.len()).collect(), explains);
        let explaining = explaining.into_iter().take(MAX_FALLBACK_CASES);
        explaining.map(|index| pairs[index]).collect()
    }

    /// Returns the pair that reproduces the most failures and that no response contradicts. Tries all pairs on a sample, and the
    /// best ones on every case.
    fn best_pair(
        &self,
        set: &MistakeSet,
        pairs: Vec<[MistakeId; 2]>,
        left: &[usize],
    ) -> Option<Vec<Member>> {
        let sample = self.sample(left);
        let weights = self.par_map(&pairs, |pair| {
            let added = self.added_weight(set, pair, &sample);
            added.iter().sum::<i64>()
        });
        let mut ranked: Vec<(i64, [MistakeId; 2])> = weights.into_iter().zip(pairs).collect();
        ranked.sort_by_key(|&(weight, _)| -weight);
        ranked.truncate(MAX_PAIRS);
        let tried = self.trial_cases(left);
        let is_possible = |[a, b]: [MistakeId; 2]| {
            let contradicts = |&w: &usize| {
                let both = self.effect(w, &[set, &[a, b][..]].concat());
                let others = [&set[..], &with_id(set, a), &with_id(set, b)];
                let mut others = others.into_iter().map(|other| self.effect(w, other));
                others.any(|other| rules::contradicts(other, both))
            };
            !tried.iter().any(contradicts)
        };
        let possible = self.select((0..ranked.len()).collect(), |i| is_possible(ranked[i].1));
        let left = self.unexplained_among(&tried, set);
        let best = possible.into_iter().max_by_key(|&i| {
            let added = self.added_weight(set, &ranked[i].1, &left);
            (added.iter().sum::<i64>(), std::cmp::Reverse(i))
        })?;
        let member = |id| Member {
            id,
            alternatives: Vec::new(),
        };
        Some(ranked[best].1.map(member).into())
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
        map_in_parallel(items.len(), self.threads, &|_, _| (), &|i| work(&items[i]))
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
