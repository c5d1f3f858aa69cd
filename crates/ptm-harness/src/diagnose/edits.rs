//! Mistakes outside the catalog: an edit of one formula, or a misreading that is limited to some formats.
//!
//! Every edit is tried on a few small failing files of each format. If an edit reproduces an image, the search tries it on all
//! files. A mistake that some responses contradict is restricted to the formats without contradictions.

use std::borrow::Cow;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::learned;
use super::mistake::{ChannelSubset, Mistake, edits_as_misreading};
use super::place::wrong_channels;
use super::rules;
use super::scope::own_formats;
use super::search::{MistakeId, MistakeSet, Search, interleave_groups};
use super::tuning::{
    MAX_EDITS, MAX_PROBES, MAX_RESTRICTED_MISREADINGS, MIN_PROBE_SIZE, MIN_SUPPORT,
    MIN_TWICE_LIMITED_IMAGES,
};
use super::witness::Agreement;
use ptm_mistakes::formula::{Edit, EditedForm, Expression, Formula, edits};
use ptm_mistakes::{Change, Misreading};
use ptm_suite::protocol::frame::Answer;

/// Edits of both axes at once.
static EDITS_OF_BOTH_AXES: LazyLock<Vec<[Edit; 2]>> = LazyLock::new(edits::of_both_axes);

/// Misreadings for all edits of all formulas, most likely first.
static EDITS: LazyLock<Vec<Misreading>> = LazyLock::new(|| {
    let formulas = Formula::ALL.iter();
    let ranked = formulas.flat_map(|&(formula, ..)| edits::all(formula).iter().enumerate());
    let single = ranked.map(|(rank, edit)| (rank, std::slice::from_ref(edit)));
    let both = EDITS_OF_BOTH_AXES.iter().map(|pair| &pair[..]);
    let mut all: Vec<(usize, &[Edit])> = single.chain(both.enumerate()).collect();
    all.sort_by_key(|(rank, _)| *rank);
    all.into_iter()
        .map(|(_, edits)| edits_as_misreading(edits))
        .collect()
});

/// Extends the search with mistakes that, together with `set`, explain some of the failures in `left`.
pub(super) fn add_candidates(search: &mut Search, set: &MistakeSet, left: &[usize]) {
    let mut probes = select_probes(search, left);
    for group in &mut probes {
        group.retain(|&w| search.is_new_probe(w, set));
    }
    let mut candidates = matching_edits(search, set, &probes);
    let tables = learned::learn_tables(search, set, left).into_iter();
    candidates.extend(tables.map(Mistake::unrestricted));
    candidates.append(&mut search.weak_edits);
    let restricted = search.par_map(&candidates, |mistake| restrict(search, set, mistake, left));
    for (candidate, restricted) in candidates.into_iter().zip(restricted) {
        match restricted {
            Some(mistake) => {
                search.add(mistake);
            }
            None if candidate.channels != ChannelSubset::All => search.weak_edits.push(candidate),
            None => {}
        }
    }
    add_restricted_misreadings(search, set, left);
}

/// Returns a few small failing images for each format and view. Prefers images that are not blank, and sizes that distinguish rows
/// from columns.
fn select_probes(search: &Search, left: &[usize]) -> Vec<Vec<usize>> {
    let mut kinds: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for w in search.comparable_images(left) {
        let witness = &search.witnesses[w];
        let kind = (witness.case.format(), witness.observation.view.name());
        kinds.entry(kind).or_default().push(w);
    }
    let is_narrow = |w: usize| match &search.witnesses[w].expected {
        Answer::Decoded(frame) => frame.width.min(frame.height) < MIN_PROBE_SIZE,
        _ => true,
    };
    let mut probes: Vec<Vec<usize>> = kinds.into_values().collect();
    for group in &mut probes {
        group.sort_by_key(|&w| {
            let is_blank = search.witnesses[w].is_blank_by_mistake();
            (is_blank, is_narrow(w), search.sample_count(w))
        });
        // Cases about different clauses reveal different mistakes.
        *group = interleave_groups(group, |w| search.witnesses[w].case.clauses.first().cloned());
        group.sort_by_key(|&w| search.witnesses[w].is_blank_by_mistake());
        group.truncate(MAX_PROBES);
    }
    probes
}

/// Returns the edits that reproduce all channels, or all wrong channels, of a probe exactly. Edits that reproduce more probes
/// come first.
fn matching_edits(search: &Search, set: &MistakeSet, probes: &[Vec<usize>]) -> Vec<Mistake> {
    let used = set
        .iter()
        .flat_map(|&id| search.mistakes[id].misreading.formulas());
    let used: Vec<Formula> = used.collect();
    let is_unused = |misreading: &&Misreading| {
        let formulas = misreading.formulas();
        !formulas.iter().any(|formula| used.contains(formula))
    };
    let edits: Vec<&'static Misreading> = EDITS.iter().filter(is_unused).collect();
    let mut channels = vec![ChannelSubset::All];
    for probe in probes {
        let wrong = ChannelSubset::smallest_containing(&wrong_channels(search, set, probe));
        if !channels.contains(&wrong) {
            channels.push(wrong);
        }
    }
    let with_answer = |&w: &usize| (w, search.best_answer(w, set));
    let first_probes: Vec<(usize, Cow<Answer>)> = (probes
        .iter()
        .filter_map(|group| group.first())
        .map(with_answer))
    .collect();
    let others = probes.iter().flat_map(|group| group.iter().skip(1));
    let other_probes: Vec<(usize, Cow<Answer>)> = others.map(with_answer).collect();
    let counts = search.par_map(&edits, |&edit| {
        let mut counts = vec![0; channels.len()];
        let edit = Mistake::unrestricted(edit);
        let mut count = |probes: &[(usize, Cow<Answer>)]| {
            for (w, unedited) in probes {
                let witness = &search.witnesses[*w];
                if search.is_interrupted() || !witness.can_explain(&edit) {
                    continue;
                }
                let answer = search.answer_with(*w, set, &edit);
                for (channels, count) in channels.iter().zip(&mut counts) {
                    let mut image = unedited.clone();
                    channels.replace_in_image(image.to_mut(), &answer);
                    *count += usize::from(witness.agreement(&image) == Agreement::Image);
                }
            }
            counts.iter().any(|&count| count > 0)
        };
        // The remaining probes rank the edits that reproduce one of the first probes.
        if count(&first_probes) {
            count(&other_probes);
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
        ..Mistake::unrestricted(edits[edit])
    };
    ranked.iter().map(mistake).collect()
}

/// Returns the mistake, restricted to the formats without contradictions, or `None` if the evidence is too weak.
fn restrict(
    search: &Search,
    set: &MistakeSet,
    mistake: &Mistake,
    left: &[usize],
) -> Option<Mistake> {
    let mut images = search.comparable_images(left);
    // That the mistake reproduces a blank image supports nothing and refutes nothing.
    images.retain(|&w| search.agreement_with(w, set, mistake) != Agreement::BlankImage);
    let fits = |w: &usize| {
        search.agreement_with(*w, set, mistake) == Agreement::Image
            && search.witnesses[*w].is_mistake_in_other_reading(mistake)
    };
    let mut explained: Vec<usize> = images.iter().copied().filter(fits).collect();
    // The rule below requires as many, and contradictions take long to find.
    if explained.len() < MIN_SUPPORT {
        return None;
    }
    let contradicted = search.contradicted_formats(set, mistake);
    let formats = (!contradicted.is_empty()).then(|| {
        let mut formats = own_formats(search.witnesses, &explained, &[]);
        formats.retain(|format| !contradicted.contains(format));
        formats
    });
    let restricted = Mistake {
        misreading: mistake.misreading,
        channels: mistake.channels,
        formats,
    };
    explained.retain(|&w| restricted.affects(search.witnesses[w].case.format()));
    // With two restrictions, too many edits fit by chance, except for values that the decoder never writes or never changes, and if
    // no wrong image of any format is left.
    let is_limited_twice =
        restricted.channels != ChannelSubset::All && restricted.formats.is_some();
    let is_plain = matches!(
        single_edit(mistake),
        Some(EditedForm::Expression(
            Expression::Number(_) | Expression::Variable(_)
        ))
    );
    let explains_everything =
        explained.len() >= MIN_TWICE_LIMITED_IMAGES && explained.len() == images.len();
    if is_limited_twice && !is_plain && !explains_everything {
        return None;
    }
    rules::explains_more_than_a_description(search, set, &restricted, &explained, &images)
        .then_some(restricted)
}

fn single_edit(mistake: &Mistake) -> Option<&'static EditedForm> {
    match mistake.misreading.change {
        Change::Edits([edit]) => Some(&edit.change),
        _ => None,
    }
}

/// Adds misreadings that some responses contradict. Each is restricted to the formats without contradictions.
fn add_restricted_misreadings(search: &mut Search, set: &MistakeSet, left: &[usize]) {
    let is_open = |&id: &MistakeId| {
        let mistake = &search.mistakes[id];
        mistake.unrestricted_misreading().is_some() && !set.contains(&id)
    };
    let open: Vec<MistakeId> = (0..search.mistakes.len()).filter(is_open).collect();
    let sample = search.sample(left);
    let counts = search.par_map(&open, |&id| {
        let with = [&set[..], &[id]].concat();
        let explains = |&&w: &&usize| {
            search.agreement(w, &with).explains() && !search.agreement(w, set).explains()
        };
        sample.iter().filter(explains).count()
    });
    let mut ranked: Vec<(usize, MistakeId)> = counts.into_iter().zip(open).collect();
    ranked.retain(|&(count, _)| count > 1);
    ranked.sort_by_key(|&(count, id)| (Reverse(count), id));
    ranked.truncate(MAX_RESTRICTED_MISREADINGS);
    let restricted = search.par_map(&ranked, |&(_, id)| {
        restrict(search, set, &search.mistakes[id], left)
            .filter(|mistake| mistake.formats.is_some())
    });
    for mistake in restricted.into_iter().flatten() {
        search.add(mistake);
    }
}
