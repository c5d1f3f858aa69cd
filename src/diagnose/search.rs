//! The smallest set of misreadings that answers as the decoder did.
//!
//! Sets grow by one mistake at a time, the one that explains most of what is left and is contradicted by least; where no
//! single mistake explains anything more, by two at once. At the end, mistakes without which as much is explained are
//! dropped.

use std::any::Any;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::credit::credit;
use super::mistake::Mistake;
use super::witness::{Agreement, Witness, is_after_decoding};
use crate::kit::parallel::in_parallel;
use crate::misreadings::{self, At, Misreading};
use crate::protocol::frame::{Answer, Frame};
use crate::session::observation::Response;
use crate::suite::cases::Expect;

/// Most mistakes of a diagnosis.
const MOST: usize = 8;
/// Failing cases that a mistake is first tried on.
const SAMPLE: usize = 40;
/// Mistakes that are tried on every case.
const FINALISTS: usize = 64;
/// Answers made for each case that was asked, after which no more mistakes are searched; and fewer, where the last one
/// explains less than one in so many of the failures: the next will explain still less.
const WORK: usize = 1000;
const LEAST_WORK: usize = 20;
/// The same, after which no mistake is looked for that explains more than one that was found.
const WIDER: usize = 60;
const LITTLE: i64 = 200;
/// Samples of the failing cases that a mistake is first tried on, all together.
const SAMPLES: usize = 1 << 20;
/// Samples of a map that is large: what passes there, or fails as smaller ones do, need not be tried with every mistake.
const LARGE: usize = 1 << 16;
/// Samples of a map that is cheap to try any mistake on.
const SMALL: usize = 1 << 13;
/// Samples of an ordinary map.
const MAP: usize = 512;
/// Mistakes that agree by chance, after which the search ends: more of them say nothing.
const CHANCES: usize = 2;
/// Nearly all are all but one in so many.
const NEARLY_ALL: usize = 20;
/// So many failures must a mistake, or another reading, explain to be believed rather than that these are of other causes.
pub(super) const FACT: usize = 4;
/// Faults of ours that are kept.
const FAULTS: usize = 8;
/// Answers made in search of two mistakes that hide each other.
const TIMEOUT_FACTOR: usize = 40_000;

/// What agreement is worth. A picture reproduced to the byte is no accident, a refusal may be one.
const PICTURE: i64 = 16;
pub(super) const WORD: i64 = 8;
const CRASH: i64 = 3;
const AGAINST: i64 = -8;
const CONTRADICTED: i64 = -16;
const LEANING: i64 = -1;
/// A mistake must be worth this much, or it is not named: one refusal.
const LEAST: i64 = CRASH;

/// Mistakes that, made together, answer as the decoder did.
#[derive(Default)]
pub(super) struct Found {
    /// In the order in which they were found, the one that explains most first.
    pub members: Vec<Member>,
}

impl Found {
    /// Those members that are to be kept.
    pub fn keep(&mut self, keep: &[bool]) {
        let mut keep = keep.iter();
        self.members.retain(|_| keep.next() == Some(&true));
    }
}

/// One of them.
pub(super) struct Member {
    pub id: Id,
    /// What it is worth in all.
    worth: i64,
    /// Others that would explain the same cases.
    pub alike: Set,
}

/// The search for the mistakes of one decoder.
pub(super) struct Search<'a> {
    pub witnesses: &'a [Witness<'a>],
    /// All mistakes that may be made: those of the catalog, and those that were solved.
    pub mistakes: Vec<Mistake>,
    /// Mistakes taken for granted: made by every set, and never named.
    pub assumed: Set,
    pub threads: usize,
    stop: &'a AtomicBool,
    /// Answers that were made so far; those of large maps count more.
    effort: AtomicUsize,
    /// How often slips in the decoders of streams were looked for.
    pub looked_for_slips: usize,
    /// The same, each counted once.
    answered: AtomicUsize,
    /// Cases that the decoder passes, the smallest first.
    pub passing: Vec<usize>,
    /// What panicked, each once.
    faults: Mutex<Vec<String>>,
    /// What the failing cases are about.
    clauses: HashSet<&'a str>,
    /// What sets of several that show are worth on a case.
    together: Mutex<HashMap<(usize, Set), i64>>,
    /// For each mistake and each case, what the mistake is worth alone, if it changes the answer.
    alone: Vec<Vec<OnceLock<Option<i64>>>>,
}

/// The place of a mistake in [`Search::mistakes`].
pub(super) type Id = usize;

/// Mistakes that are made at once.
pub(super) type Set = Vec<Id>;

impl<'a> Search<'a> {
    pub fn new(
        witnesses: &'a [Witness<'a>],
        assumed: &'a [&'static Misreading],
        threads: usize,
        stop: &'a AtomicBool,
    ) -> Search<'a> {
        let mut passing: Vec<usize> = (0..witnesses.len())
            .filter(|&w| !witnesses[w].failed)
            .collect();
        passing.sort_by_key(|&w| witnesses[w].built.file.len());
        let failing = witnesses.iter().filter(|witness| witness.failed);
        let clauses = failing.flat_map(|witness| &witness.case.clauses);
        let mistakes: Vec<Mistake> = misreadings::all().map(Mistake::Listed).collect();
        let is_assumed = |mistake: &Mistake| {
            let slug = mistake.listed().map(|misreading| misreading.slug);
            assumed.iter().any(|other| Some(other.slug) == slug)
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
            stop,
            effort: AtomicUsize::new(0),
            looked_for_slips: 0,
            answered: AtomicUsize::new(0),
            together: Mutex::new(HashMap::new()),
            faults: Mutex::new(Vec::new()),
            passing,
        }
    }

    /// Adds a mistake that was solved.
    pub fn add(&mut self, mistake: Mistake) -> Id {
        self.mistakes.push(mistake);
        self.alone.push(vec![OnceLock::new(); self.witnesses.len()]);
        self.mistakes.len() - 1
    }

    /// Takes away what was added last.
    pub fn truncate(&mut self, count: usize) {
        self.mistakes.truncate(count);
        let mut together = self.together.lock().unwrap_or_else(PoisonError::into_inner);
        together.retain(|(_, set), _| set.iter().all(|&id| id < count));
        drop(together);
        self.alone.truncate(count);
    }

    /// The failing cases that a set does not explain.
    pub fn unexplained(&self, set: &Set) -> Vec<usize> {
        let failing = (0..self.witnesses.len()).filter(|&w| self.witnesses[w].failed);
        let failing: Vec<usize> = failing.collect();
        let values = self.each(&failing, |&w| self.value(w, set));
        let pairs = failing.into_iter().zip(values);
        pairs
            .filter_map(|(w, value)| (value < WORD).then_some(w))
            .collect()
    }

    /// The mistakes that explain most, found one after the other. `solve` is asked for mistakes that the catalog lacks.
    pub fn run(&mut self, solve: impl Fn(&mut Search, &Set, &[usize]) -> Vec<Set>) -> Found {
        let mut members: Vec<Member> = Vec::new();
        while members.len() < MOST && !self.is_interrupted() {
            let set = of(&members);
            let left = self.unexplained(&set);
            let little = members
                .last()
                .is_some_and(|last| last.worth * LITTLE < WORD * left.len() as i64);
            if left.is_empty() || self.is_spent(little) {
                break;
            }
            let mut single = self.best_single(&set, &left);
            let mut groups = Vec::new();
            // What explains nearly all that is left needs no solving.
            let explains_all = |member: &Member| {
                let unexplained = self.unexplained(&plus(&set, member.id));
                unexplained.len() * NEARLY_ALL <= left.len()
                    && self.denied(&plus(&set, member.id)).is_empty()
                    && !self.is_denied_by_large(member.id)
            };
            if !single.as_ref().is_some_and(explains_all) {
                groups = self.solved(&solve, &set, &left);
                single = self.best_single(&set, &left);
            }
            let group = self.group(&set, &groups, &left);
            let grown = match (single, group) {
                // What explains twice as much is no slip more than it needs.
                (Some(single), Some(group)) if group[0].worth > 2 * single.worth => Some(group),
                (Some(single), _) => Some(vec![single]),
                (None, group) => group.or_else(|| self.two_more(&set, &left)),
            };
            match grown {
                Some(more) => members.extend(more),
                None => break,
            }
            let chances = members.iter().filter(|member| self.is_chance(member));
            if chances.count() >= CHANCES {
                break;
            }
        }
        self.drop_needless(&mut members);
        for place in 0..members.len() {
            if let Some(wider) = self.wider(&members, place, &solve) {
                members[place] = wider;
            }
        }
        Found { members }
    }

    /// What `solve` adds that explains some of `left` beside `set`: those that are made together. A fault in it is noted.
    fn solved(
        &mut self,
        solve: &impl Fn(&mut Search, &Set, &[usize]) -> Vec<Set>,
        set: &Set,
        left: &[usize],
    ) -> Vec<Set> {
        let solved = catch_unwind(AssertUnwindSafe(|| solve(self, set, left)));
        solved.unwrap_or_else(|panic| {
            self.note(&*panic);
            Vec::new()
        })
    }

    /// A mistake that explains all that one member does beside the others, and some of what is left too: what was made is that,
    /// and looks like the member in some files.
    fn wider(
        &mut self,
        members: &[Member],
        place: usize,
        solve: &impl Fn(&mut Search, &Set, &[usize]) -> Vec<Set>,
    ) -> Option<Member> {
        let member = members[place].id;
        let left = self.unexplained(&of(members));
        let spent = self.answered.load(Ordering::Relaxed);
        if left.is_empty() || self.is_interrupted() || spent > WIDER * self.witnesses.len() {
            return None;
        }
        let others = without(&of(members), member);
        let format = |w: &usize| self.witnesses[*w].case.format();
        let (mut akin, mine): (Vec<usize>, Vec<usize>) =
            (self.unexplained(&others).into_iter()).partition(|w| left.contains(w));
        akin.retain(|w| mine.iter().any(|other| format(other) == format(w)));
        if akin.is_empty() {
            return None;
        }
        let all = [mine, akin].concat();
        self.solved(solve, &others, &all);
        let wider = self.best_single(&others, &all)?;
        let with = plus(&others, wider.id);
        let still = self.unexplained(&with);
        let is_wider = still.len() < left.len() && still.iter().all(|w| left.contains(w));
        (is_wider && self.denied(&with).len() <= self.denied(&of(members)).len()).then_some(wider)
    }

    /// What mistakes cost that are to be believed: themselves, and what they leave unexplained.
    pub fn cost(&self, found: &Found) -> usize {
        self.unexplained(&of(&found.members)).len() + FACT * found.members.len()
    }

    /// The one mistake that is worth most beside `set`.
    fn best_single(&self, set: &Set, left: &[usize]) -> Option<Member> {
        let mut all: Set = (0..self.mistakes.len())
            .filter(|id| !set.contains(id) && !self.assumed.contains(id))
            .collect();
        self.one_more(set, &mut all, &self.sample(left))
            .or_else(|| self.one_more(set, &mut all, &self.affordable(left)))
    }

    /// Of several mistakes that were solved together, those that explain most.
    fn group(&self, set: &Set, groups: &[Set], left: &[usize]) -> Option<Vec<Member>> {
        let gains = self.each(groups, |group| {
            let with = [&set[..], group].concat();
            let gain = |&w: &usize| self.value(w, &with) - self.value(w, set);
            let against = self.denied(&with).len();
            left.iter().map(gain).sum::<i64>() + CONTRADICTED * against as i64
        });
        let best = (0..groups.len()).max_by_key(|&place| (gains[place], groups.len() - place))?;
        let member = |&id: &Id| Member {
            id,
            worth: gains[best],
            alike: Vec::new(),
        };
        (gains[best] >= LEAST).then(|| groups[best].iter().map(member).collect())
    }

    /// Whether a mistake in computing is spoken against by cases that pass. Colors are rounded, and agree by chance with
    /// many a mistake.
    fn is_chance(&self, member: &Member) -> bool {
        let contradicts = |&w: &usize| self.alone(w, member.id) == Some(CONTRADICTED);
        let listed = self.mistakes[member.id].listed();
        listed.is_some_and(is_after_decoding) && self.passing.iter().any(contradicts)
    }

    /// How well a set explains one case, for those who name what each of its members explains.
    pub fn agreement(&self, w: usize, set: &[Id]) -> Agreement {
        let agreements = self
            .answers(w, set)
            .into_iter()
            .map(|answer| self.witnesses[w].agreement(&answer));
        agreements
            .max_by_key(|&agreement| worth(agreement))
            .unwrap_or(Agreement::None)
    }

    /// Whether a set would fail a case that the decoder passes.
    pub fn contradicted(&self, w: usize, set: &[Id]) -> bool {
        let witness = &self.witnesses[w];
        !witness.failed
            && self
                .answers(w, set)
                .iter()
                .any(|answer| witness.contradicts(answer))
    }

    /// The cases that the decoder passes and a set would fail.
    pub fn contradictions(&self, set: &[Id]) -> Vec<usize> {
        let passing: Vec<usize> = (0..self.witnesses.len())
            .filter(|&w| !self.witnesses[w].failed)
            .collect();
        let contradicted = self.each(&passing, |&w| self.contradicted(w, set));
        let pairs = passing.into_iter().zip(contradicted);
        pairs.filter_map(|(w, is)| is.then_some(w)).collect()
    }

    /// Whether large files that the decoder passes deny a mistake in side information, whose high bytes only these use.
    fn is_denied_by_large(&self, id: Id) -> bool {
        let listed = self.mistakes[id].listed();
        let is_of_records = listed.is_some_and(|one| one.clause.starts_with("2.9.8/"));
        let large = |&&w: &&usize| self.samples(w) > SMALL;
        is_of_records && (self.passing.iter().filter(large)).any(|&w| self.contradicted(w, &[id]))
    }

    /// Of the small files that the decoder passes, those that a set would fail.
    pub fn denied(&self, set: &[Id]) -> Vec<usize> {
        let small = self.passing.iter().copied();
        let small: Vec<usize> = small.filter(|&w| self.samples(w) <= SMALL).collect();
        let denied = self.each(&small, |&w| self.contradicted(w, set));
        let pairs = small.into_iter().zip(denied);
        pairs.filter_map(|(w, is)| is.then_some(w)).collect()
    }

    /// What a decoder with these mistakes answers, and the assumed ones.
    pub fn made(&self, w: usize, set: &[Id]) -> Cow<'_, Answer> {
        let mut answers = self.answers(w, set);
        answers.swap_remove(0)
    }

    /// What a decoder with these mistakes may answer: mistakes in one decision are made one at a time.
    fn answers(&self, w: usize, set: &[Id]) -> Vec<Cow<'_, Answer>> {
        let witness = &self.witnesses[w];
        let concerned = self
            .assumed
            .iter()
            .chain(set)
            .filter(|&&id| witness.concerns(&self.mistakes[id]));
        let mut variants: Vec<Set> = vec![Vec::new()];
        for &id in concerned {
            let mut grown = Vec::new();
            for variant in variants {
                let mut with = variant.clone();
                with.retain(|&other| self.stackable(other, id));
                let replaces = with.len() < variant.len();
                with.push(id);
                for variant in [replaces.then_some(variant), Some(with)]
                    .into_iter()
                    .flatten()
                {
                    if !grown.contains(&variant) {
                        grown.push(variant);
                    }
                }
            }
            variants = grown;
        }
        self.add_other_order(&mut variants);
        let effort = variants.len() * (1 + self.samples(w) / MAP);
        self.effort.fetch_add(effort, Ordering::Relaxed);
        variants
            .iter()
            .map(|variant| self.answer(w, &self.mistakes_of(variant)))
            .collect()
    }

    /// What a decoder with these mistakes answers. One that panics here is a fault of ours, and taken for no mistake.
    fn answer(&self, w: usize, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let witness = &self.witnesses[w];
        self.answered.fetch_add(1, Ordering::Relaxed);
        let answer = catch_unwind(AssertUnwindSafe(|| {
            match witness.refuses_positions(mistakes) {
                true => Cow::Owned(Answer::Rejected),
                false => witness.answer(mistakes),
            }
        }));
        answer.unwrap_or_else(|panic| {
            self.note(&*panic);
            Cow::Borrowed(&witness.right)
        })
    }

    /// What `work` returns; nothing, and the words are kept, where it panics.
    pub fn guarded<T: Default>(&self, work: impl FnOnce() -> T) -> T {
        catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
            self.note(&*panic);
            T::default()
        })
    }

    /// How many answers were made so far.
    pub fn answered(&self) -> usize {
        self.answered.load(Ordering::Relaxed)
    }

    /// What panicked so far.
    pub fn faults(&self) -> Vec<String> {
        let faults = self.faults.lock();
        faults.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Keeps the words of a panic.
    pub fn note(&self, panic: &(dyn Any + Send)) {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
        let mut faults = self.faults.lock().unwrap_or_else(PoisonError::into_inner);
        let text = text.unwrap_or_else(|| "a panic without words".to_owned());
        // What one of several threads said is told once.
        let is_told = faults.contains(&text) || text == "a scoped thread panicked";
        if faults.len() < FAULTS && !is_told {
            faults.push(text);
        }
    }

    /// Edits of bytes may hide each other in one order and not in the other: what is lost at the beginning of a payload
    /// is missing at its end.
    fn add_other_order(&self, variants: &mut Vec<Set>) {
        for at in 0..variants.len() {
            if variants[at]
                .iter()
                .filter(|&&id| self.edits_bytes(id))
                .count()
                == 2
            {
                let mut other = variants[at].clone();
                other.reverse();
                variants.push(other);
            }
        }
    }

    fn edits_bytes(&self, id: Id) -> bool {
        let listed = self.mistakes[id].listed();
        listed.is_some_and(|misreading| matches!(misreading.at, At::Bytes(_)))
    }

    /// The mistakes of a set.
    pub fn mistakes_of(&self, set: &[Id]) -> Vec<&Mistake> {
        set.iter().map(|&id| &self.mistakes[id]).collect()
    }

    /// Whether both can act on one file: two changes of one decision cannot.
    fn stackable(&self, a: Id, b: Id) -> bool {
        let at = |id: Id| self.mistakes[id].listed().map(|misreading| &misreading.at);
        !matches!((at(a), at(b)), (Some(a), Some(b)) if a.is_decision() && a.is_at(b))
    }

    /// Whether the user wants the search to end; what it finds from then on means nothing.
    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// What a set is worth on one case. Of mistakes of which at most one shows there alone, that one's worth: that others
    /// show beside it only is rare, and to try it for every set takes most of the time.
    pub fn value(&self, w: usize, set: &[Id]) -> i64 {
        if self.is_interrupted() {
            return 0;
        }
        let all = self.assumed.iter().chain(set);
        let mut shown = all.filter_map(|&id| self.alone(w, id));
        let edits = set.iter().filter(|&&id| self.edits_bytes(id)).count();
        match (shown.next(), shown.next()) {
            // What the reference shows is right, and no failure.
            (None, _) => 0,
            (Some(worth), None) if edits < 2 || worth >= WORD => worth,
            _ => self.value_together(w, set),
        }
    }

    /// What mistakes of which several show are worth on one case.
    fn value_together(&self, w: usize, set: &[Id]) -> i64 {
        let concerned = set.iter().copied();
        let concerned = concerned.filter(|&id| self.witnesses[w].concerns(&self.mistakes[id]));
        let key = (w, concerned.collect::<Set>());
        let known = || self.together.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&value) = known().get(&key) {
            return value;
        }
        let value = self.value_of(w, &self.answers(w, set));
        known().insert(key, value);
        value
    }

    /// What one mistake is worth alone on one case, the assumed ones aside; nothing if it does not show there.
    fn alone(&self, w: usize, id: Id) -> Option<i64> {
        let witness = &self.witnesses[w];
        let mistake = &self.mistakes[id];
        *self.alone[id][w].get_or_init(|| {
            if !witness.concerns(mistake) {
                return None;
            }
            self.effort
                .fetch_add(1 + self.samples(w) / MAP, Ordering::Relaxed);
            let answer = self.answer(w, &[mistake]);
            (*answer != witness.right).then(|| self.value_of(w, &[answer]))
        })
    }

    /// What these answers are worth, of which the decoder may give any.
    fn value_of(&self, w: usize, answers: &[Cow<'_, Answer>]) -> i64 {
        let witness = &self.witnesses[w];
        if witness.failed {
            let worths = answers
                .iter()
                .map(|answer| match witness.agreement(answer) {
                    Agreement::None => credit(witness, answer),
                    agreement => worth(agreement),
                });
            worths.max().unwrap_or_default()
        } else if answers.iter().any(|answer| witness.contradicts(answer)) {
            CONTRADICTED
        } else if matches!(witness.case.expect, Expect::Lenient | Expect::Spelling)
            && answers.iter().all(|answer| witness.leans_away(answer))
        {
            LEANING
        } else {
            0
        }
    }

    /// The one mistake that is worth most besides `set`, of those that explain one of `tried`. If none is worth anything,
    /// those that seemed to be are taken out of `all`.
    fn one_more(&self, set: &Set, all: &mut Set, tried: &[usize]) -> Option<Member> {
        let now: Vec<i64> = tried.iter().map(|&w| self.value(w, set)).collect();
        let promise = self.each(all, |&id| {
            let with = plus(set, id);
            let gain = |(&w, &now): (&usize, &i64)| {
                if self.witnesses[w].could_be(&self.mistakes[id]) {
                    (self.value(w, &with) - now).max(0)
                } else {
                    0
                }
            };
            tried.iter().zip(&now).map(gain).sum::<i64>()
        });
        let mut promising: Vec<(i64, Id)> = promise
            .into_iter()
            .zip(all.iter().copied())
            .filter(|&(gain, _)| gain >= LEAST)
            .collect();
        // Among equals what the cases are about, then the catalogue's order, from the general to the particular.
        promising.sort_by_key(|&(gain, id)| (-gain, !self.is_about(id)));
        promising.truncate(FINALISTS);
        let finalists: Set = promising.into_iter().map(|(_, id)| id).collect();
        let best = self.best(set, &finalists, &self.tried_for(tried));
        all.retain(|id| !finalists.contains(id));
        best
    }

    /// The cases on which mistakes are tried that shall explain some of `left`: all but large maps, unless these are all
    /// that is left.
    fn tried_for(&self, left: &[usize]) -> Vec<bool> {
        let with_large = left.iter().all(|&w| self.samples(w) > LARGE);
        (0..self.witnesses.len())
            .map(|w| with_large || self.samples(w) <= LARGE)
            .collect()
    }

    /// The best of `finalists`, tried on every case that is to be tried, and those that do as well.
    fn best(&self, set: &Set, finalists: &Set, tried: &[bool]) -> Option<Member> {
        let now: Vec<i64> = (0..self.witnesses.len())
            .map(|w| if tried[w] { self.value(w, set) } else { 0 })
            .collect();
        let is_left = |&w: &usize| tried[w] && self.witnesses[w].failed && now[w] < WORD;
        let left: Vec<usize> = (0..now.len()).filter(is_left).collect();
        let gains = self.each(finalists, |&id| {
            let with = plus(set, id);
            let gain = |&w: &usize| match self.witnesses[w].could_be(&self.mistakes[id]) {
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
        // What is explained already, and then what passes, can only speak against a mistake.
        let explained = (0..now.len()).filter(|&w| self.witnesses[w].failed && !is_left(&w));
        let others: Vec<usize> = explained
            .chain(self.passing.iter().copied())
            .filter(|&w| tried[w])
            .collect();
        let mut scored: Vec<(i64, usize)> = Vec::new();
        for batch in ranked.chunks(self.threads.max(1) * 2) {
            let best = scored.iter().map(|&(total, _)| total).max();
            let least = best.map_or(LEAST, |best| LEAST.max(best - WORD));
            let totals = self.each(batch, |&(gain, place)| {
                self.total(set, finalists[place], &now, gain, least, &others)
            });
            let totals = totals.into_iter().zip(batch);
            scored.extend(totals.filter_map(|(total, &(_, place))| Some((total?, place))));
        }
        scored.sort_by_key(|&(total, place)| (-total, !self.is_about(finalists[place]), place));
        let &(total, first) = scored.first()?;
        let as_good = scored[1..]
            .iter()
            .filter(|&&(other, place)| total - other < WORD && gains[place] == gains[first]);
        Some(Member {
            id: finalists[first],
            worth: total,
            alike: as_good.map(|&(_, place)| finalists[place]).collect(),
        })
    }

    /// Whether a failing case is about the clause that is misread.
    fn is_about(&self, id: Id) -> bool {
        let listed = self.mistakes[id].listed();
        listed.is_some_and(|misreading| self.clauses.contains(misreading.clause))
    }

    /// What it is worth in all, if it adds `gain` on the cases that are left; nothing if that is less than `least`.
    fn total(
        &self,
        set: &Set,
        id: Id,
        now: &[i64],
        gain: i64,
        least: i64,
        others: &[usize],
    ) -> Option<i64> {
        let with = plus(set, id);
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

    /// Two mistakes that only together explain a picture: of those that change it, every pair, on the smallest files.
    fn two_more(&self, set: &Set, left: &[usize]) -> Option<Vec<Member>> {
        let mut pictures = self.solvable(left);
        pictures.sort_by_key(|&w| self.witnesses[w].built.file.len());
        let spent = || self.effort.load(Ordering::Relaxed);
        let before_all = spent();
        let timeout_factor = || TIMEOUT_FACTOR.saturating_sub(spent() - before_all);
        for w in spread(&pictures, |w| self.witnesses[w].case.format()) {
            let pairs = self.pairs_for(w, set, timeout_factor());
            if let Some(members) = self.best_pair(set, pairs, left) {
                return Some(members);
            }
            if timeout_factor() == 0 {
                break;
            }
        }
        None
    }

    /// Pairs of mistakes that together explain `w`, of those that change its answer; no more than `most` are tried.
    fn pairs_for(&self, w: usize, set: &Set, most: usize) -> Vec<[Id; 2]> {
        let before = self.answers(w, set);
        let concerned: Set = (0..self.mistakes.len())
            .filter(|id| {
                !set.contains(id)
                    && !self.assumed.contains(id)
                    && self.witnesses[w].concerns(&self.mistakes[*id])
            })
            .collect();
        let acts = self.each(&concerned, |&id| self.answers(w, &plus(set, id)) != before);
        let acting = concerned.into_iter().zip(acts);
        let acting: Set = acting.filter_map(|(id, acts)| acts.then_some(id)).collect();
        let pairs: Vec<[Id; 2]> = acting
            .iter()
            .enumerate()
            .flat_map(|(i, &a)| acting[i + 1..].iter().map(move |&b| [a, b]))
            .filter(|&[a, b]| self.stackable(a, b))
            .take(most)
            .collect();
        let explain = self.each(&pairs, |&[a, b]| {
            self.value(w, &plus(&plus(set, a), b)) >= WORD
        });
        let explaining = pairs.into_iter().zip(explain);
        explaining
            .filter_map(|(pair, explains)| explains.then_some(pair))
            .take(FINALISTS * 4)
            .collect()
    }

    /// The pair that explains most of the rest, roughly and then exactly.
    fn best_pair(&self, set: &Set, pairs: Vec<[Id; 2]>, left: &[usize]) -> Option<Vec<Member>> {
        let wanted = self.tried_for(left);
        let all: Vec<usize> = (0..wanted.len()).filter(|&w| wanted[w]).collect();
        let mut pairs: Vec<([Id; 2], i64)> = pairs.into_iter().map(|pair| (pair, 0)).collect();
        for tried in [&self.sample(left), &all] {
            let totals = self.each(&pairs, |&([a, b], _)| {
                let with = plus(&plus(set, a), b);
                let gain = |&w: &usize| self.value(w, &with) - self.value(w, set);
                tried.iter().map(gain).sum::<i64>()
            });
            for (pair, total) in pairs.iter_mut().zip(totals) {
                pair.1 = total;
            }
            pairs.sort_by_key(|&(_, total)| -total);
            pairs.truncate(8);
        }
        let &(pair, worth) = pairs.first().filter(|&&(_, total)| total >= LEAST)?;
        let member = |id| Member {
            id,
            worth,
            alike: Vec::new(),
        };
        Some(pair.map(member).into())
    }

    /// Takes away every mistake without which as much is explained, of large maps too.
    fn drop_needless(&self, members: &mut Vec<Member>) {
        let (small, large): (Vec<usize>, Vec<usize>) =
            (0..self.witnesses.len()).partition(|&w| self.samples(w) <= LARGE);
        let total = |set: &Set, places: &[usize]| {
            let values = self.each(places, |&w| self.value(w, set));
            values.iter().sum::<i64>()
        };
        for place in (0..members.len()).rev() {
            let with = of(members);
            let mut without = with.clone();
            without.remove(place);
            let needless =
                |places: &[usize]| total(&without, places) + LEAST > total(&with, places);
            if !without.is_empty() && needless(&small) && needless(&large) {
                members.remove(place);
            }
        }
    }

    /// Pictures of the right shape that are not large: of others nothing can be solved.
    pub fn solvable(&self, left: &[usize]) -> Vec<usize> {
        let has_shape = |w: &usize| match (
            &self.witnesses[*w].observation.response,
            &self.witnesses[*w].right,
        ) {
            (
                Response::Picture {
                    frame: Some(shown), ..
                },
                Answer::Decoded(right),
            ) => {
                let shape = |frame: &Frame| (frame.view, frame.width, frame.height, frame.channels);
                shape(shown) == shape(right) && self.samples(*w) <= LARGE
            }
            _ => false,
        };
        left.iter().copied().filter(has_shape).collect()
    }

    /// Whether more work was done than a search is worth that last explained but a `little`.
    fn is_spent(&self, little: bool) -> bool {
        let most = if little { LEAST_WORK } else { WORK };
        self.answered.load(Ordering::Relaxed) > most * self.witnesses.len()
    }

    /// Failing cases unlike each other, small ones first.
    fn sample(&self, left: &[usize]) -> Vec<usize> {
        self.unlike(&self.smallest(left, SAMPLES), SAMPLE)
    }

    /// So many of these cases, unlike each other.
    fn unlike(&self, cases: &[usize], most: usize) -> Vec<usize> {
        let kind = |w: usize| {
            let witness = &self.witnesses[w];
            (
                witness.observation.response.name(),
                witness.case.clauses.first().cloned(),
            )
        };
        let mut unlike = spread(cases, kind);
        unlike.truncate(most);
        unlike
    }

    /// As many failing cases as there is time for.
    fn affordable(&self, left: &[usize]) -> Vec<usize> {
        let mut smallest = self.smallest(left, SAMPLES);
        smallest.truncate(4 * SAMPLE);
        smallest
    }

    /// How many samples the right answer has.
    pub fn samples(&self, w: usize) -> usize {
        match &self.witnesses[w].right {
            Answer::Decoded(frame) => {
                frame.width as usize * frame.height as usize * frame.channels as usize
            }
            _ => 0,
        }
    }

    /// The smallest of these, so that all together they have no more samples than `most`; at least one.
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

    /// `work` of every item, on all threads, in order.
    pub fn each<T: Sync, R: Send>(&self, items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
        in_parallel(items.len(), self.threads, &|_, _| (), &|i| {
            let done = catch_unwind(AssertUnwindSafe(|| work(&items[i])));
            done.unwrap_or_else(|panic| {
                self.note(&*panic);
                resume_unwind(panic)
            })
        })
    }
}

fn worth(agreement: Agreement) -> i64 {
    match agreement {
        Agreement::Picture => PICTURE,
        Agreement::Word => WORD,
        Agreement::Crash => CRASH,
        Agreement::None => 0,
        Agreement::Against => AGAINST,
    }
}

pub(super) fn of(members: &[Member]) -> Set {
    members.iter().map(|member| member.id).collect()
}

/// The other members of a set.
pub(super) fn without(set: &[Id], member: Id) -> Set {
    let others = set.iter().copied().filter(|&other| other != member);
    others.collect()
}

fn plus(set: &[Id], id: Id) -> Set {
    [set, &[id]].concat()
}

/// The first of each kind, then the second of each, and so on.
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
