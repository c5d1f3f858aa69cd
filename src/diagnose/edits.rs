//! Mistakes that the catalog lacks: one edit of one formula, or a mistake that is made in some files only.
//!
//! Every edit is tried on a few small failing files of each format. One that reproduces an image becomes a mistake that the
//! search compares with all files. If passing files contradict it, it is kept only for formats in which none does.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::learned;
use super::mistake::{ChannelSubset, Mistake, misreading_of};
use super::scope::{FileScope, scope_between};
use super::search::{Id, Search, Set, WORTH_OF_A_REFUSAL, spread};
use super::tuning::{
    MAX_EDITS, MAX_PROBES, MAX_SCOPED_MISREADINGS, MIN_PROBE_SIZE, MIN_SUPPORT, is_much,
};
use super::witness::{Agreement, explains_a_view};
use super::words::place::wrong_channels;
use crate::formula::{EditedForm, Expression, Formula, edits};
use crate::misreadings::{At, Misreading};
use crate::protocol::frame::Answer;

/// Every edit of every formula as a misreading, the most natural edits first.
static EDITS: LazyLock<Vec<Misreading>> = LazyLock::new(|| {
    let formulas = Formula::ALL.iter();
    let ranked = formulas.flat_map(|&(formula, ..)| edits::all(formula).iter().enumerate());
    let mut all: Vec<_> = ranked.collect();
    all.sort_by_key(|(rank, _)| *rank);
    all.into_iter()
        .map(|(_, edit)| misreading_of(edit))
        .collect()
});

/// Adds mistakes to the search that explain some of `left` together with `set`.
pub(super) fn add_candidates(search: &mut Search, set: &Set, left: &[usize]) {
    let mut probes = probes(search, left);
    for of_kind in &mut probes {
        of_kind.retain(|&w| search.is_new_probe(w, set));
    }
    let mut candidates = fitting(search, set, &probes);
    let tables = learned::tables(search, set, left).into_iter();
    candidates.extend(tables.map(Mistake::everywhere));
    let scoped = search.each(&candidates, |mistake| scoped(search, set, mistake, left));
    for mistake in scoped.into_iter().flatten() {
        search.add(mistake);
    }
    add_scoped_misreadings(search, set, left);
}

/// Returns small failing images, several of each format and view, preferably of a size that separates rows from columns.
fn probes(search: &Search, left: &[usize]) -> Vec<Vec<usize>> {
    let mut kinds: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for w in search.solvable(left) {
        let witness = &search.witnesses[w];
        let kind = (witness.case.format(), witness.observation.view.name());
        kinds.entry(kind).or_default().push(w);
    }
    let is_small = |w: usize| match &search.witnesses[w].right {
        Answer::Decoded(frame) => frame.width.min(frame.height) < MIN_PROBE_SIZE,
        _ => true,
    };
    let mut probes: Vec<Vec<usize>> = kinds.into_values().collect();
    for of_kind in &mut probes {
        of_kind.sort_by_key(|&w| (is_small(w), search.samples(w)));
        // Cases about different clauses show different mistakes.
        *of_kind = spread(of_kind, |w| {
            search.witnesses[w].case.clauses.first().cloned()
        });
        of_kind.truncate(MAX_PROBES);
    }
    probes
}

/// Returns the edits that reproduce a probe exactly, in all channels or in the wrong ones, those that reproduce most first.
fn fitting(search: &Search, set: &Set, probes: &[Vec<usize>]) -> Vec<Mistake> {
    let taken: Vec<Formula> = set
        .iter()
        .flat_map(|&id| search.mistakes[id].misreading.at.formulas())
        .collect();
    let is_free = |misreading: &&Misreading| {
        let formulas = misreading.at.formulas();
        !formulas.iter().any(|formula| taken.contains(formula))
    };
    let edits: Vec<&'static Misreading> = EDITS.iter().filter(is_free).collect();
    let mut channels = vec![ChannelSubset::All];
    for probe in probes {
        let wrong = ChannelSubset::narrowest(&wrong_channels(search, set, probe));
        if !channels.contains(&wrong) {
            channels.push(wrong);
        }
    }
    let with_image = |&w: &usize| (w, search.answer_of(w, set));
    let firsts: Vec<(usize, Cow<Answer>)> = (probes
        .iter()
        .filter_map(|of_kind| of_kind.first())
        .map(with_image))
    .collect();
    let others = probes.iter().flat_map(|of_kind| of_kind.iter().skip(1));
    let others: Vec<(usize, Cow<Answer>)> = others.map(with_image).collect();
    let counts = search.each(&edits, |&edit| {
        let mut counts = vec![0; channels.len()];
        let edit = Mistake::everywhere(edit);
        let mut count = |probes: &[(usize, Cow<Answer>)]| {
            for (w, made) in probes {
                let witness = &search.witnesses[*w];
                if search.is_interrupted() || !witness.could_be(&edit) {
                    continue;
                }
                let answer = search.answer_with(*w, set, &edit);
                for (channels, count) in channels.iter().zip(&mut counts) {
                    let mut image = made.clone();
                    channels.replace(image.to_mut(), &answer);
                    *count += usize::from(witness.agreement(&image) == Agreement::Image);
                }
            }
            counts.iter().any(|&count| count > 0)
        };
        // The other images rank the edits that reproduce one of the first.
        if count(&firsts) {
            count(&others);
        }
        counts
    });
    let mut ranked: Vec<(usize, usize, usize)> = Vec::new();
    for (edit, counts) in counts.into_iter().enumerate() {
        let counts = counts.into_iter().enumerate();
        ranked.extend(counts.map(|(channels, count)| (count, channels, edit)));
    }
    ranked.retain(|&(count, ..)| count > 0);
    ranked.sort_by_key(|&(count, channels, edit)| (Reverse(count), channels, edit));
    ranked.truncate(MAX_EDITS);
    let mistake = |&(_, channel, edit): &(usize, usize, usize)| Mistake {
        channels: channels[channel],
        ..Mistake::everywhere(edits[edit])
    };
    ranked.iter().map(mistake).collect()
}

/// Returns the mistake in every file, or in the files in which no passing case contradicts it.
fn scoped(search: &Search, set: &Set, mistake: &Mistake, left: &[usize]) -> Option<Mistake> {
    let pictures = search.solvable(left);
    let fits = |w: &usize| search.agreement_with(*w, set, mistake) == Agreement::Image;
    let explained: Vec<usize> = pictures.iter().copied().filter(fits).collect();
    let denied = search.denied_with(set, mistake);
    let scope = match denied.is_empty() {
        true => FileScope::All,
        false => scope_between(search.witnesses, &explained, &denied)?,
    };
    // Among so many mistakes, one fits the files of some property by chance.
    let is_by_property = !matches!(scope, FileScope::All | FileScope::Formats(_));
    if is_by_property && (mistake.listed().is_none() || !is_much(explained.len(), left.len())) {
        return None;
    }
    // Two restrictions at once fit too many edits, but values that are never written are no coincidence.
    let is_limited_twice = mistake.channels != ChannelSubset::All && scope != FileScope::All;
    let is_number = matches!(
        only_edit(mistake),
        Some(EditedForm::Expression(Expression::Number(_)))
    );
    if is_limited_twice && (is_by_property || !is_number) {
        return None;
    }
    let scoped = Mistake {
        misreading: mistake.misreading,
        channels: mistake.channels,
        scope,
    };
    // In other views a later mistake may change the images, too. A learned table was compared with their texels.
    let acts = |w: &&usize| search.changes_with(**w, set, &scoped);
    let acting: Vec<usize> = pictures.iter().filter(acts).copied().collect();
    let is_learned = matches!(only_edit(mistake), Some(EditedForm::Table(_)));
    let is_supported = explained.len() >= MIN_SUPPORT
        && (is_learned || explains_a_view(search.witnesses, &explained, &acting));
    is_supported.then_some(scoped)
}

/// Returns the edit of a mistake that makes one.
fn only_edit(mistake: &Mistake) -> Option<&'static EditedForm> {
    match mistake.misreading.at {
        At::Edits([edit]) => Some(&edit.change),
        _ => None,
    }
}

/// Adds misreadings of the catalog that passing cases contradict, in the files in which they are made.
fn add_scoped_misreadings(search: &mut Search, set: &Set, left: &[usize]) {
    let is_open = |&id: &Id| {
        let mistake = &search.mistakes[id];
        mistake.of_catalog().is_some() && !set.contains(&id)
    };
    let open: Vec<Id> = (0..search.mistakes.len()).filter(is_open).collect();
    let sample = search.sample(left);
    let counts = search.each(&open, |&id| {
        let with = [&set[..], &[id]].concat();
        let explains = |&&w: &&usize| {
            search.value(w, &with) >= WORTH_OF_A_REFUSAL
                && search.value(w, set) < WORTH_OF_A_REFUSAL
        };
        sample.iter().filter(explains).count()
    });
    let mut ranked: Vec<(usize, Id)> = counts.into_iter().zip(open).collect();
    ranked.retain(|&(count, _)| count > 1);
    ranked.sort_by_key(|&(count, id)| (Reverse(count), id));
    ranked.truncate(MAX_SCOPED_MISREADINGS);
    let scopes = search.each(&ranked, |&(_, id)| {
        scoped(search, set, &search.mistakes[id], left)
            .filter(|mistake| mistake.scope != FileScope::All)
    });
    for mistake in scopes.into_iter().flatten() {
        search.add(mistake);
    }
}
