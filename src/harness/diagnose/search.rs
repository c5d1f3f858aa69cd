//! The smallest set of misreadings that answers as the decoder did.
//!
//! Sets grow by one mistake at a time, the one that explains most of what is left and is contradicted by least; where no
//! single mistake explains anything more, by two at once. At the end, mistakes without which as much is explained are
//! dropped.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::witness::{Agreement, Witness, is_after_decoding};
use crate::harness::cases::Expect;
use crate::harness::corpus::in_parallel;
use crate::harness::judge::Shown;
use crate::harness::misreadings::{self, At, Misreading};
use crate::harness::protocol::Answer;

/// Most mistakes of a diagnosis.
const MOST: usize = 8;
/// Failing cases that a mistake is first tried on.
const SAMPLE: usize = 40;
/// Mistakes that are tried on every case.
const FINALISTS: usize = 64;
/// Samples of the failing cases that a mistake is first tried on, all together.
const SAMPLES: usize = 1 << 20;
/// Samples of a map that is large: what passes there, or fails as smaller ones do, need not be tried with every mistake.
const LARGE: usize = 1 << 16;
/// Samples of an ordinary map.
const MAP: usize = 512;
/// Mistakes that agree by chance, after which the search ends: more of them say nothing.
const CHANCES: usize = 2;
/// Answers made in search of two mistakes that hide each other.
const PATIENCE: usize = 40_000;

/// What agreement is worth. A picture reproduced to the byte is no accident, a refusal may be one.
const PICTURE: i64 = 16;
const WORD: i64 = 8;
const CRASH: i64 = 3;
const AGAINST: i64 = -8;
const CONTRADICTED: i64 = -16;
const LEANING: i64 = -1;
/// A mistake must be worth this much, or it is not named: one refusal.
const LEAST: i64 = CRASH;

/// Mistakes that, made together, answer as the decoder did.
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
    pub misreading: &'static Misreading,
    /// Others that would explain the same cases.
    pub alike: Vec<&'static Misreading>,
}

/// The search for the mistakes of one decoder.
pub(super) struct Search<'a> {
    pub witnesses: &'a [Witness<'a>],
    /// Mistakes taken for granted: made by every set, and never named.
    pub assumed: &'a [&'static Misreading],
    pub threads: usize,
    stop: &'a AtomicBool,
    /// Answers that were made so far; those of large maps count more.
    effort: AtomicUsize,
    /// Cases that the decoder passes, the smallest first.
    passing: Vec<usize>,
    /// What the failing cases are about.
    clauses: HashSet<&'a str>,
    /// By name, the place of each mistake in `alone`.
    places: HashMap<&'static str, usize>,
    /// For each case and each mistake, what the mistake is worth alone, if it changes the answer.
    alone: Vec<OnceLock<Option<i64>>>,
}

type Set = Vec<&'static Misreading>;

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
        let places: HashMap<&'static str, usize> = misreadings::all()
            .enumerate()
            .map(|(place, misreading)| (misreading.slug, place))
            .collect();
        Search {
            alone: vec![OnceLock::new(); witnesses.len() * places.len()],
            places,
            clauses: clauses.map(String::as_str).collect(),
            witnesses,
            assumed,
            threads,
            stop,
            effort: AtomicUsize::new(0),
            passing,
        }
    }

    pub fn run(&self) -> Found {
        let mut members: Vec<Member> = Vec::new();
        while members.len() < MOST && !self.is_interrupted() {
            let set = of(&members);
            let left: Vec<usize> = (0..self.witnesses.len())
                .filter(|&w| self.witnesses[w].failed && self.value(w, &set) < WORD)
                .collect();
            if left.is_empty() {
                break;
            }
            let mut all: Set = misreadings::all()
                .filter(|&other| !named(&set, other) && !named(self.assumed, other))
                .collect();
            let grown = self
                .one_more(&set, &mut all, &self.sample(&left))
                .or_else(|| self.one_more(&set, &mut all, &self.affordable(&left)))
                .map(|member| vec![member])
                .or_else(|| self.two_more(&set, &left));
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
        Found { members }
    }

    /// Whether a mistake in computing is spoken against by cases that pass. Colors are rounded, and agree by chance with
    /// many a mistake.
    fn is_chance(&self, member: &Member) -> bool {
        let contradicts = |&w: &usize| self.alone(w, member.misreading) == Some(CONTRADICTED);
        is_after_decoding(member.misreading) && self.passing.iter().any(contradicts)
    }

    /// How well a set explains one case, for those who name what each of its members explains.
    pub fn agreement(&self, w: usize, set: &[&'static Misreading]) -> Agreement {
        let agreements = self
            .answers(w, set)
            .into_iter()
            .map(|answer| self.witnesses[w].agreement(&answer));
        agreements
            .max_by_key(|&agreement| worth(agreement))
            .unwrap_or(Agreement::None)
    }

    /// Whether a set would fail a case that the decoder passes.
    pub fn contradicted(&self, w: usize, set: &[&'static Misreading]) -> bool {
        let witness = &self.witnesses[w];
        !witness.failed
            && self
                .answers(w, set)
                .iter()
                .any(|answer| witness.contradicts(answer))
    }

    /// What a decoder with these mistakes answers, and the assumed ones.
    pub fn made(&self, w: usize, set: &[&'static Misreading]) -> Cow<'_, Answer> {
        let mut answers = self.answers(w, set);
        answers.swap_remove(0)
    }

    /// What a decoder with these mistakes may answer: mistakes in one decision are made one at a time.
    fn answers(&self, w: usize, set: &[&'static Misreading]) -> Vec<Cow<'_, Answer>> {
        let witness = &self.witnesses[w];
        let concerned = self
            .assumed
            .iter()
            .chain(set)
            .filter(|misreading| witness.concerns(misreading));
        let mut variants: Vec<Set> = vec![Vec::new()];
        for &misreading in concerned {
            let mut grown = Vec::new();
            for variant in variants {
                let mut with = variant.clone();
                with.retain(|other| stackable(other, misreading));
                let replaces = with.len() < variant.len();
                with.push(misreading);
                for variant in [replaces.then_some(variant), Some(with)]
                    .into_iter()
                    .flatten()
                {
                    if !grown.iter().any(|known| same(known, &variant)) {
                        grown.push(variant);
                    }
                }
            }
            variants = grown;
        }
        let effort = variants.len() * (1 + self.samples(w) / MAP);
        self.effort.fetch_add(effort, Ordering::Relaxed);
        variants
            .iter()
            .map(|variant| witness.answer(variant))
            .collect()
    }

    /// Whether the user wants the search to end; what it finds from then on means nothing.
    pub fn is_interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// What a set is worth on one case. Of mistakes of which at most one shows there alone, that one's worth: that others
    /// show beside it only is rare, and to try it for every set takes most of the time.
    fn value(&self, w: usize, set: &[&'static Misreading]) -> i64 {
        if self.is_interrupted() {
            return 0;
        }
        let all = self.assumed.iter().chain(set);
        let mut shown = all.filter_map(|&misreading| self.alone(w, misreading));
        match (shown.next(), shown.next()) {
            // What the reference shows is right, and no failure.
            (None, _) => 0,
            (Some(worth), None) => worth,
            _ => self.value_of(w, &self.answers(w, set)),
        }
    }

    /// What one mistake is worth alone on one case, the assumed ones aside; nothing if it does not show there.
    fn alone(&self, w: usize, misreading: &'static Misreading) -> Option<i64> {
        let witness = &self.witnesses[w];
        let place = w * self.places.len() + self.places[misreading.slug];
        *self.alone[place].get_or_init(|| {
            if !witness.concerns(misreading) {
                return None;
            }
            self.effort
                .fetch_add(1 + self.samples(w) / MAP, Ordering::Relaxed);
            let answer = witness.answer(&[misreading]);
            (*answer != witness.right).then(|| self.value_of(w, &[answer]))
        })
    }

    /// What these answers are worth, of which the decoder may give any.
    fn value_of(&self, w: usize, answers: &[Cow<'_, Answer>]) -> i64 {
        let witness = &self.witnesses[w];
        if witness.failed {
            let worths = answers
                .iter()
                .map(|answer| worth(witness.agreement(answer)));
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
        let promise = self.each(all, |misreading| {
            let with = plus(set, misreading);
            let gain = |(&w, &now): (&usize, &i64)| {
                if self.witnesses[w].could_be(misreading) {
                    (self.value(w, &with) - now).max(0)
                } else {
                    0
                }
            };
            tried.iter().zip(&now).map(gain).sum::<i64>()
        });
        let mut promising: Vec<(i64, &'static Misreading)> = promise
            .into_iter()
            .zip(all.iter().copied())
            .filter(|&(gain, _)| gain >= LEAST)
            .collect();
        // Among equals what the cases are about, then the catalogue's order, from the general to the particular.
        promising.sort_by_key(|&(gain, misreading)| (-gain, !self.is_about(misreading)));
        promising.truncate(FINALISTS);
        let finalists: Set = promising
            .into_iter()
            .map(|(_, misreading)| misreading)
            .collect();
        let best = self.best(set, &finalists, &self.tried_for(tried));
        all.retain(|other| !named(&finalists, other));
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
        let gains = self.each(finalists, |misreading| {
            let with = plus(set, misreading);
            let gain = |&w: &usize| match self.witnesses[w].could_be(misreading) {
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
            misreading: finalists[first],
            alike: as_good.map(|&(_, place)| finalists[place]).collect(),
        })
    }

    /// Whether a failing case is about the clause that is misread.
    fn is_about(&self, misreading: &Misreading) -> bool {
        self.clauses.contains(misreading.clause)
    }

    /// What it is worth in all, if it adds `gain` on the cases that are left; nothing if that is less than `least`.
    fn total(
        &self,
        set: &Set,
        misreading: &'static Misreading,
        now: &[i64],
        gain: i64,
        least: i64,
        others: &[usize],
    ) -> Option<i64> {
        let with = plus(set, misreading);
        let mut total = gain;
        for &w in others {
            if total < least {
                return None;
            }
            if self.witnesses[w].concerns(misreading) {
                total += self.value(w, &with) - now[w];
            }
        }
        (total >= least).then_some(total)
    }

    /// Two mistakes that only together explain a picture: of those that change it, every pair, on the smallest files.
    fn two_more(&self, set: &Set, left: &[usize]) -> Option<Vec<Member>> {
        let mut pictures: Vec<usize> = left
            .iter()
            .copied()
            .filter(|&w| {
                matches!(
                    self.witnesses[w].finding.shown,
                    Shown::Picture { frame: Some(_), .. }
                )
            })
            .collect();
        pictures.sort_by_key(|&w| self.witnesses[w].built.file.len());
        let spent = || self.effort.load(Ordering::Relaxed);
        let before_all = spent();
        let patience = || PATIENCE.saturating_sub(spent() - before_all);
        for w in spread(&pictures, |w| self.witnesses[w].case.format()) {
            let witness = &self.witnesses[w];
            let before = self.answers(w, set);
            let concerned: Set = misreadings::all()
                .filter(|&misreading| {
                    !named(set, misreading)
                        && !named(self.assumed, misreading)
                        && witness.concerns(misreading)
                })
                .collect();
            let acts = self.each(&concerned, |misreading| {
                self.answers(w, &plus(set, misreading)) != before
            });
            let acting: Set = concerned
                .into_iter()
                .zip(acts)
                .filter_map(|(misreading, acts)| acts.then_some(misreading))
                .collect();
            let pairs: Vec<[&'static Misreading; 2]> = acting
                .iter()
                .enumerate()
                .flat_map(|(i, &a)| acting[i + 1..].iter().map(move |&b| [a, b]))
                .filter(|[a, b]| stackable(a, b))
                .take(patience())
                .collect();
            let explain = self.each(&pairs, |&[a, b]| {
                self.value(w, &plus(&plus(set, a), b)) >= WORD
            });
            let mut pairs: Vec<([&'static Misreading; 2], i64)> = pairs
                .into_iter()
                .zip(explain)
                .filter(|&(_, explains)| explains)
                .map(|(pair, _)| (pair, 0))
                .take(FINALISTS * 4)
                .collect();
            // By what they explain of the rest, roughly and then exactly.
            let sample = self.sample(left);
            let wanted = self.tried_for(left);
            let all: Vec<usize> = (0..wanted.len()).filter(|&w| wanted[w]).collect();
            for tried in [&sample, &all] {
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
            if let Some(&([a, b], total)) = pairs.first()
                && total >= LEAST
            {
                let member = |misreading| Member {
                    misreading,
                    alike: Vec::new(),
                };
                return Some(vec![member(a), member(b)]);
            }
            if patience() == 0 {
                break;
            }
        }
        None
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

    /// Failing cases unlike each other, small ones first.
    fn sample(&self, left: &[usize]) -> Vec<usize> {
        let kind = |w: usize| {
            let witness = &self.witnesses[w];
            (
                witness.finding.shown.name(),
                witness.case.clauses.first().cloned(),
            )
        };
        let mut sample = spread(&self.smallest(left, SAMPLES), kind);
        sample.truncate(SAMPLE);
        sample
    }

    /// As many failing cases as there is time for.
    fn affordable(&self, left: &[usize]) -> Vec<usize> {
        let mut smallest = self.smallest(left, SAMPLES);
        smallest.truncate(4 * SAMPLE);
        smallest
    }

    /// How many samples the right answer has.
    fn samples(&self, w: usize) -> usize {
        match &self.witnesses[w].right {
            Answer::Decoded(frame) => {
                frame.width as usize * frame.height as usize * frame.channels as usize
            }
            _ => 0,
        }
    }

    /// The smallest of these, so that all together they have no more samples than `most`; at least four.
    fn smallest(&self, left: &[usize], most: usize) -> Vec<usize> {
        let mut smallest = left.to_vec();
        smallest.sort_by_key(|&w| (self.samples(w), self.witnesses[w].built.file.len()));
        let mut all = 0;
        let taken = smallest.iter().enumerate().take_while(|&(i, &w)| {
            all += self.samples(w) + self.witnesses[w].built.file.len();
            i < 4 || all <= most
        });
        let count = taken.count();
        smallest.truncate(count);
        smallest
    }

    /// `work` of every item, on all threads, in order.
    pub fn each<T: Sync, R: Send>(&self, items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
        in_parallel(items.len(), self.threads, &|_, _| (), &|i| work(&items[i]))
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

/// Whether both can act on one file: two changes of one decision cannot.
fn stackable(a: &Misreading, b: &Misreading) -> bool {
    !matches!((&a.at, &b.at), (At::Reading(a, _), At::Reading(b, _)) if a == b)
}

pub(super) fn of(members: &[Member]) -> Set {
    members.iter().map(|member| member.misreading).collect()
}

fn plus(set: &[&'static Misreading], misreading: &'static Misreading) -> Set {
    [set, &[misreading]].concat()
}

fn same(a: &Set, b: &Set) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.slug == b.slug)
}

fn named(set: &[&'static Misreading], misreading: &Misreading) -> bool {
    set.iter().any(|other| other.slug == misreading.slug)
}

/// The first of each kind, then the second of each, and so on.
fn spread<K: Ord>(places: &[usize], kind: impl Fn(usize) -> K) -> Vec<usize> {
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
