//! Mistakes that agree with some responses by chance: many mistakes end in a refusal, and colors are rounded.

use std::collections::HashSet;

use super::failure_mode::FailureMode;
use super::search::{FoundMistakes, Id, Search, Set, ids_of, without_id};
use super::tuning::{MIN_SHARING_FILES, is_few, is_most, is_nearly_all};
use super::witness::{Agreement, Witness};
use super::words::place::is_near;
use super::words::refusals;
use crate::misreadings::{Misreading, Stage, Symptom};
use crate::suite::cases::Expect;

/// The failing cases that show whether the decoder makes a mistake.
#[derive(Default)]
struct FailureEvidence {
    /// Legal files whose response the mistake reproduces, alone or together with the others.
    explained: Vec<usize>,
    /// The number of images in `explained`.
    images: usize,
    /// The number of crashes in `explained`.
    crashes: usize,
    /// Malformed files that it accepts as the decoder does.
    accepted: Vec<usize>,
    /// Images of legal files that it changes in another way than the decoder does.
    other_images: usize,
    /// The images among `other_images` that it does not bring closer to the response.
    far: usize,
    /// Images of legal files that it changes.
    changed_images: usize,
    /// Refusals and crashes of legal files that it changes.
    changed_refusals: usize,
    /// Images of legal files that it would refuse.
    against: usize,
}

impl FailureEvidence {
    /// Compares the answers of a decoder that makes the mistake `id` of `set` with the responses.
    fn new(search: &Search, set: &Set, failing: &[usize], id: Id) -> FailureEvidence {
        let without = without_id(set, id);
        let mut evidence = FailureEvidence::default();
        for &w in failing {
            let alone = search.agreement(w, &[id]);
            let is_needed = |is: fn(Agreement) -> bool| {
                is(alone) || is(search.agreement(w, set)) && !is(search.agreement(w, &without))
            };
            let is_image = FailureMode::new(&search.witnesses[w]).is_none();
            if search.witnesses[w].case.expect != Expect::Decode {
                if is_needed(Agreement::explains) {
                    evidence.accepted.push(w);
                }
                continue;
            }
            let is_changed = search.differ(w, set, &without);
            evidence.changed_images += usize::from(is_changed && is_image);
            evidence.changed_refusals += usize::from(is_changed && !is_image);
            let is_against = [alone, search.agreement(w, set)] == [Agreement::Against; 2];
            evidence.against += usize::from(is_against);
            if is_needed(Agreement::explains) {
                evidence.explained.push(w);
                evidence.images += usize::from(is_image);
                evidence.crashes += usize::from(alone == Agreement::Crash);
            } else if is_changed && is_image {
                evidence.other_images += 1;
                evidence.far += usize::from(!is_near(search, w, set, id));
            }
        }
        evidence
    }
}

/// Removes mistakes that agree with some answers by chance.
pub(super) fn remove(search: &Search, found: &mut FoundMistakes) {
    use Rule::{Acceptances, Rare, Refusals, Stray};
    let witnesses = search.witnesses;
    let failed = search.failing();
    let legal = |of: &[usize]| -> Vec<usize> {
        let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
        of.iter().copied().filter(is_legal).collect()
    };
    let failing = legal(&failed);
    let shared = refusals::widest(witnesses, &failing);
    // Each rule weighs only the mistakes that are left. The last rule is repeated, because it may remove what hid other changes.
    for rule in [Refusals, Acceptances, Rare, Stray, Stray] {
        let set = ids_of(&found.members);
        let open = search.select(failed.clone(), |w| !search.explains(w, &set));
        let is_unknown = is_nearly_all(legal(&open).len(), failing.len());
        let all = search.each(&set, |&id| FailureEvidence::new(search, &set, &failed, id));
        let places: Vec<usize> = (0..set.len()).collect();
        let keep = search.each(&places, |&place| {
            let (id, evidence) = (set[place], &all[place]);
            let listed = search.mistakes[id].listed();
            if evidence.explained.is_empty() && evidence.accepted.is_empty() {
                return false;
            }
            match (rule, listed) {
                (Refusals, _) => !refuses_by_chance(search, &set, &all, place, &failing, &shared),
                (Acceptances, _) => !accepts_by_chance(search, id, evidence, &open, is_unknown),
                // Edits were compared with all images that they change.
                (_, None) => true,
                (Rare, Some(_)) => !is_rare(search, &set, id, evidence),
                (Stray, Some(misreading)) => !is_stray(search, misreading, evidence, failing.len()),
            }
        });
        found.keep(&keep);
    }
}

/// The rules, in the order in which they are applied.
#[derive(Clone, Copy)]
enum Rule {
    Refusals,
    Acceptances,
    Rare,
    Stray,
}

/// Returns true if a misreading explains few of the failures, and none of these is about the misread clause, if it changes more than
/// twice as many, or if it would refuse more images than it explains: among many wrong images, a few agree with another mistake by
/// chance.
fn is_stray(
    search: &Search,
    misreading: &Misreading,
    evidence: &FailureEvidence,
    failing: usize,
) -> bool {
    let explained = evidence.explained.len();
    let is_few = is_few(explained, failing);
    let changed = match is_few {
        true => evidence.changed_images + evidence.changed_refusals,
        false => evidence.changed_images,
    };
    let mut about = evidence.explained.iter();
    let is_about = about.any(|&w| is_about(&search.witnesses[w], misreading));
    let others = changed.saturating_sub(explained);
    explained > 0
        && (is_most(others, changed) || is_few && !is_about || evidence.against > explained)
}

/// Returns true if a misreading explains few images and changes many others in another way than the decoder does. It must explain
/// nearly all if passing files contradict it, or if only colors show it, because these are rounded.
fn is_rare(search: &Search, set: &Set, id: Id, evidence: &FailureEvidence) -> bool {
    let (images, far) = (evidence.images, evidence.far);
    let is_thorough = is_nearly_all(images, images + evidence.other_images);
    let is_of_colors = search.mistakes[id].misreading.at.stage() == Stage::Color;
    let is_denied = || !search.denied(&[id]).is_empty() && !search.denied(set).is_empty();
    images > 0
        && (is_nearly_all(far, far + images) || !is_thorough && (is_of_colors || is_denied()))
}

/// Returns true if a mistake only refuses files, and a shared property explains more of them, or other cases contradict it: many
/// mistakes end in a refusal. `shared` are the failures that one property explains.
fn refuses_by_chance(
    search: &Search,
    set: &Set,
    all: &[FailureEvidence],
    place: usize,
    failing: &[usize],
    shared: &[Vec<usize>],
) -> bool {
    let (evidence, witnesses) = (&all[place], search.witnesses);
    let explained = &evidence.explained;
    if explained.is_empty() || !is_few(evidence.images, explained.len()) {
        return false;
    }
    let explains_more = |wide: &Vec<usize>| {
        let others = explained.iter().filter(|w| !wide.contains(w)).count();
        wide.len() > explained.len() && is_few(others, explained.len())
    };
    // Refusals that no other mistake explains. A misreading that changes values would show an image somewhere.
    let others = || (0..all.len()).filter(|&other| other != place);
    let is_refused = |w: &&usize| {
        let is_other = others().any(|other| all[other].explained.contains(w));
        FailureMode::new(&witnesses[**w]).is_some() && !is_other
    };
    let refused = failing.iter().filter(is_refused).count();
    let unexplained = refused.saturating_sub(explained.len());
    // A crash is weaker evidence than a refusal.
    let are_crashes = evidence.crashes == explained.len();
    let is_small = is_nearly_all(unexplained, refused) || are_crashes && unexplained > 0;
    let listed = search.mistakes[set[place]].listed();
    let refuses_only = listed.is_some_and(|listed| listed.shows == Symptom::Refusals);
    let one = [set[place]];
    let is_contradicted = |w| search.contradicted(w, &one) && search.contradicted(w, set);
    (!refuses_only || is_few(explained.len(), refused)) && is_small
        || evidence.against > 0
        || shared.iter().any(explains_more)
        || (0..witnesses.len()).any(is_contradicted)
}

/// Returns true if a mistake explains only malformed files that are accepted, and passing cases contradict it, or it explains few
/// faults and unexplained failures are about the same clause, or the causes of nearly all failures of legal files are unknown.
fn accepts_by_chance(
    search: &Search,
    id: Id,
    evidence: &FailureEvidence,
    open: &[usize],
    is_unknown: bool,
) -> bool {
    if !evidence.explained.is_empty() {
        return false;
    }
    // A mistake that explains many different faults is no coincidence.
    let damages = evidence.accepted.iter();
    let faults = damages.filter_map(|&w| Some(&search.witnesses[w].case.damage()?.effect));
    let is_one_fault = faults.collect::<HashSet<_>>().len() <= MIN_SHARING_FILES;
    let misreading = search.mistakes[id].misreading;
    let is_clause_open = || {
        open.iter()
            .any(|&w| is_about(&search.witnesses[w], misreading))
    };
    is_unknown || is_one_fault && is_clause_open() || !search.denied(&[id]).is_empty()
}

/// Returns true if a case is about the misread clause.
fn is_about(witness: &Witness, misreading: &Misreading) -> bool {
    (witness.case.clauses.iter()).any(|clause| clause == misreading.clause)
}
