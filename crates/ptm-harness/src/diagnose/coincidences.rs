//! Removes mistakes that match some responses by chance.
//!
//! Chance matches are common because many mistakes cause refusals and because colors are rounded.

use std::collections::HashSet;

use super::failure_mode::FailureMode;
use super::search::{Member, MistakeId, MistakeSet, Search, ids_of, without_id};
use super::tuning::{MIN_SHARING_FILES, is_few, is_most, is_nearly_all};
use super::witness::{Agreement, Witness};
use super::words::{differences::reduces_wrong_samples, refusals};
use ptm_mistakes::{Misreading, Stage, Symptom};
use ptm_suite::cases::Expect;

/// Failing cases that support or contradict a mistake.
#[derive(Default)]
struct FailureEvidence {
    /// Legal files for which the mistake, alone or together with the other mistakes, reproduces the response.
    explained: Vec<usize>,
    /// Number of images in `explained`.
    images: usize,
    /// Number of crashes in `explained`.
    crashes: usize,
    /// Malformed files that the decoder accepts, as the mistake predicts.
    accepted: Vec<usize>,
    /// Number of legal files for which the mistake changes the image, but does not reproduce the decoder's image.
    other_images: usize,
    /// Number of `other_images` that the mistake does not bring closer to the response.
    not_closer: usize,
    /// Number of legal files whose image the mistake changes.
    changed_images: usize,
    /// Number of legal files that the decoder refuses or crashes on, and for which the mistake changes the answer.
    changed_refusals: usize,
    /// Number of legal files for which the decoder returned an image, although it would refuse them if it made the mistake.
    refused: usize,
}

impl FailureEvidence {
    /// Compares the responses with the answers of a decoder that makes the mistake `id` from `set`.
    fn new(search: &Search, set: &MistakeSet, failing: &[usize], id: MistakeId) -> FailureEvidence {
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
            let is_changed = search.answers_differ(w, set, &without);
            evidence.changed_images += usize::from(is_changed && is_image);
            evidence.changed_refusals += usize::from(is_changed && !is_image);
            let would_refuse = [alone, search.agreement(w, set)] == [Agreement::Contradiction; 2];
            evidence.refused += usize::from(would_refuse);
            if is_needed(Agreement::explains) {
                evidence.explained.push(w);
                evidence.images += usize::from(is_image);
                evidence.crashes += usize::from(alone == Agreement::Crash);
            } else if is_changed && is_image {
                evidence.other_images += 1;
                evidence.not_closer += usize::from(!reduces_wrong_samples(search, w, set, id));
            }
        }
        evidence
    }
}

/// Removes mistakes that match some responses by chance.
pub(super) fn remove_coincidences(search: &Search, found: &mut Vec<Member>) {
    use Rule::{Acceptances, Rare, Refusals, Stray};
    let witnesses = search.witnesses;
    let failed = search.failing();
    let legal = |indices: &[usize]| -> Vec<usize> {
        let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
        indices.iter().copied().filter(is_legal).collect()
    };
    let failing = legal(&failed);
    let shared = refusals::shared_failures(witnesses, &failing);
    // Each rule considers only the mistakes that remain. The last rule runs twice, because it may remove a mistake that
    // hid the changes of others.
    for rule in [Refusals, Acceptances, Rare, Stray, Stray] {
        let set = ids_of(found);
        let open = search.select(failed.clone(), |w| !search.explains(w, &set));
        let is_unknown = is_nearly_all(legal(&open).len(), failing.len());
        let all = search.par_map(&set, |&id| FailureEvidence::new(search, &set, &failed, id));
        let indices: Vec<usize> = (0..set.len()).collect();
        let keep = search.par_map(&indices, |&index| {
            let (id, evidence) = (set[index], &all[index]);
            let listed = search.mistakes[id].catalog_misreading();
            if evidence.explained.is_empty() && evidence.accepted.is_empty() {
                return false;
            }
            match (rule, listed) {
                (Refusals, _) => !refuses_by_chance(search, &set, &all, index, &failing, &shared),
                (Acceptances, _) => !accepts_by_chance(search, id, evidence, &open, is_unknown),
                // Edits have already been compared with all images that they change.
                (_, None) => true,
                (Rare, Some(_)) => !is_rare(search, &set, id, evidence),
                (Stray, Some(misreading)) => !is_stray(search, misreading, evidence, failing.len()),
            }
        });
        let mut keep = keep.into_iter();
        found.retain(|_| keep.next() == Some(true));
    }
}

/// Rules that identify coincidences, in the order in which they are applied.
#[derive(Clone, Copy)]
enum Rule {
    Refusals,
    Acceptances,
    Rare,
    Stray,
}

/// Returns true if a misreading matches only stray failures:
/// - it explains few failures, and none of them is about the misread clause,
/// - it changes more than twice as many cases as it explains, or
/// - it would turn more images into refusals than it explains.
fn is_stray(
    search: &Search,
    misreading: &Misreading,
    evidence: &FailureEvidence,
    failing: usize,
) -> bool {
    let explained = evidence.explained.len();
    let explains_few = is_few(explained, failing);
    let changed = match explains_few {
        true => evidence.changed_images + evidence.changed_refusals,
        false => evidence.changed_images,
    };
    let mut about = evidence.explained.iter();
    let is_about = about.any(|&w| is_about(&search.witnesses[w], misreading));
    let others = changed.saturating_sub(explained);
    explained > 0
        && (is_most(others, changed) || explains_few && !is_about || evidence.refused > explained)
}

/// Returns true if a misreading explains too few of the images that it changes. It must explain nearly all of them if passing
/// files contradict it, or if it changes only colors, which are rounded.
fn is_rare(search: &Search, set: &MistakeSet, id: MistakeId, evidence: &FailureEvidence) -> bool {
    let (images, far) = (evidence.images, evidence.not_closer);
    let is_thorough = is_nearly_all(images, images + evidence.other_images);
    let is_color_only = search.mistakes[id].misreading.stage() == Stage::Color;
    let is_refuted =
        || !search.refuting_files(&[id]).is_empty() && !search.refuting_files(set).is_empty();
    images > 0
        && (is_nearly_all(far, far + images) || !is_thorough && (is_color_only || is_refuted()))
}

/// Returns true if a mistake explains few images and may match refusals by chance: it explains a small part of the refusals, it
/// predicts the refusal of a decoded file, a case contradicts it, or a group in `shared` contains these refusals and others.
fn refuses_by_chance(
    search: &Search,
    set: &MistakeSet,
    all: &[FailureEvidence],
    index: usize,
    failing: &[usize],
    shared: &[Vec<usize>],
) -> bool {
    let (evidence, witnesses) = (&all[index], search.witnesses);
    let explained = &evidence.explained;
    if explained.is_empty() || !is_few(evidence.images, explained.len()) {
        return false;
    }
    let explains_more = |group: &Vec<usize>| {
        let others = explained.iter().filter(|w| !group.contains(w)).count();
        group.len() > explained.len() && is_few(others, explained.len())
    };
    // Refusals that no other mistake explains. A misreading that changes values would affect some image.
    let others = || (0..all.len()).filter(|&other| other != index);
    let is_refused = |w: &&usize| {
        let is_other = others().any(|other| all[other].explained.contains(w));
        FailureMode::new(&witnesses[**w]).is_some() && !is_other
    };
    let refused = failing.iter().filter(is_refused).count();
    let unexplained = refused.saturating_sub(explained.len());
    // A crash is weaker evidence than a refusal.
    let are_crashes = evidence.crashes == explained.len();
    let is_small = is_nearly_all(unexplained, refused) || are_crashes && unexplained > 0;
    let listed = search.mistakes[set[index]].catalog_misreading();
    let refuses_only = listed.is_some_and(|listed| listed.symptom == Symptom::Refusals);
    let alone = [set[index]];
    let is_refuted = |w| search.is_refuted(w, &alone) && search.is_refuted(w, set);
    (!refuses_only || is_few(explained.len(), refused)) && is_small
        || evidence.refused > 0
        || shared.iter().any(explains_more)
        || (0..witnesses.len()).any(is_refuted)
}

/// Returns true if a mistake explains only accepted malformed files, and one of these holds:
/// - passing cases contradict it,
/// - it explains few kinds of faults, and unexplained failures are about the same clause, or
/// - the causes of nearly all failures of legal files are unknown.
fn accepts_by_chance(
    search: &Search,
    id: MistakeId,
    evidence: &FailureEvidence,
    open: &[usize],
    is_unknown: bool,
) -> bool {
    if !evidence.explained.is_empty() {
        return false;
    }
    // A mistake that explains many different faults is not a coincidence.
    let accepted = evidence.accepted.iter();
    let faults = accepted.filter_map(|&w| Some(&search.witnesses[w].case.damage()?.name));
    let are_few_faults = faults.collect::<HashSet<_>>().len() <= MIN_SHARING_FILES;
    let misreading = search.mistakes[id].misreading;
    let is_clause_open = || {
        open.iter()
            .any(|&w| is_about(&search.witnesses[w], misreading))
    };
    is_unknown || are_few_faults && is_clause_open() || !search.refuting_files(&[id]).is_empty()
}

fn is_about(witness: &Witness, misreading: &Misreading) -> bool {
    (witness.case.clauses.iter()).any(|clause| clause == misreading.clause)
}
