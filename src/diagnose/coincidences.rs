//! Mistakes that agree with some responses by chance: many mistakes end in a refusal, and colors are rounded.

use std::collections::HashSet;

use super::failure_mode::FailureMode;
use super::search::{Found, Id, Search, of, without};
use super::tuning::{REFUSALS_PER_CHANCE_IMAGE, STRAY_SHARE};
use super::witness::{Agreement, Witness};
use super::words::place::is_near;
use super::words::refusals;
use crate::misreadings::{Misreading, Stage, Symptom};
use crate::suite::cases::Expect;

/// Removes mistakes that agree with some answers by chance.
pub(super) fn remove(search: &Search, found: &mut Found) {
    drop_refusals(search, found);
    drop_acceptances(search, found);
    drop_rare(search, found);
    drop_strays(search, found);
}

/// Removes misreadings that explain few of the failures, if none of these is about the misread clause, or if the misreading
/// changes more than twice as many: among many wrong images, a few agree with another mistake by chance.
fn drop_strays(search: &Search, found: &mut Found) {
    let set = of(&found.members);
    let failing = failing(search.witnesses);
    let keep = search.each(&set, |&id| {
        // Edits were compared with all images that they change.
        let Some(misreading) = search.mistakes[id].listed() else {
            return true;
        };
        let without = without(&set, id);
        let is_explained = |&w: &usize| {
            let explains = |set: &[Id]| search.agreement(w, set).explains();
            explains(&[id]) || explains(&set) && !explains(&without)
        };
        let explained: Vec<usize> = failing.iter().copied().filter(is_explained).collect();
        let acts = |w: usize| search.differ(w, &set, &without);
        let is_image = |w: usize| FailureMode::of(&search.witnesses[w]).is_none();
        let is_few = explained.len() * STRAY_SHARE < failing.len();
        let acting = failing
            .iter()
            .filter(|&&w| (is_few || is_image(w)) && acts(w));
        let is_about = || (explained.iter()).any(|&w| is_about(&search.witnesses[w], misreading));
        explained.is_empty() || explained.len() * 2 >= acting.count() && (!is_few || is_about())
    });
    found.keep(&keep);
}

/// One in so many images may agree with a mistake by chance.
const RARE: usize = 3;

/// Removes misreadings that explain few images and change many others in another way than the decoder does. A misreading must
/// explain three in four if passing files contradict it, or if only colors show it, because these are rounded.
fn drop_rare(search: &Search, found: &mut Found) {
    let set = of(&found.members);
    let failing = failing(search.witnesses);
    let keep = search.each(&set, |&id| {
        if search.mistakes[id].listed().is_none() {
            return true;
        }
        let without = without(&set, id);
        let (mut explained, mut other, mut far) = (0, 0, 0);
        for &w in &failing {
            let is_explained = |set: &[Id]| search.agreement(w, set) == Agreement::Picture;
            if is_explained(&set) && !is_explained(&without) || is_explained(&[id]) {
                explained += 1;
            } else if FailureMode::of(&search.witnesses[w]).is_none()
                && search.differ(w, &set, &without)
            {
                other += 1;
                far += usize::from(!is_near(search, w, &set, id));
            }
        }
        let is_of_colors = search.mistakes[id].misreading.at.stage() == Stage::Color;
        let is_rare = explained * RARE <= far;
        let is_denied = || !search.denied(&[id]).is_empty() && !search.denied(&set).is_empty();
        explained == 0 || !is_rare && (explained > 3 * other || !is_of_colors && !is_denied())
    });
    found.keep(&keep);
}

/// Removes mistakes that only refuse files, if a shared property explains more of them, or if passing cases contradict them: many
/// mistakes end in a refusal.
fn drop_refusals(search: &Search, found: &mut Found) {
    let witnesses = search.witnesses;
    let set = of(&found.members);
    let failing = failing(witnesses);
    let shared = refusals::widest(witnesses, &failing);
    let explained = search.each(&set, |&id| {
        let agreements = failing.iter().map(|&w| (w, search.agreement(w, &[id])));
        agreements
            .filter(|(_, agreement)| agreement.explains())
            .collect::<Vec<(usize, Agreement)>>()
    });
    let by = |member: usize, w: usize| explained[member].iter().any(|&(other, _)| other == w);
    let places: Vec<usize> = (0..set.len()).collect();
    let keep = search.each(&places, |&member| {
        let of_member = &explained[member];
        // A few images among many refusals may agree by chance.
        let pictures = (of_member.iter())
            .filter(|(_, agreement)| !matches!(agreement, Agreement::Word | Agreement::Crash));
        let refuses = pictures.count() * REFUSALS_PER_CHANCE_IMAGE <= of_member.len();
        let less = |wide: &Vec<usize>| {
            let covered = of_member.iter().filter(|(w, _)| wide.contains(w)).count();
            wide.len() > of_member.len() && covered * 10 >= of_member.len() * 9
        };
        let one = [set[member]];
        let contradicted = || {
            (0..witnesses.len())
                .any(|w| search.contradicted(w, &one) && search.contradicted(w, &set))
        };
        // Refusals that no other mistake explains.
        let refused = failing.iter().filter(|&&w| {
            let alone = places.iter().all(|&other| other == member || !by(other, w));
            FailureMode::of(&witnesses[w]).is_some() && alone
        });
        // A misreading that changes values would show an image somewhere. A crash is weaker evidence than a refusal.
        let crashes = (of_member.iter()).all(|(_, agreement)| *agreement == Agreement::Crash);
        let few = of_member.len() * if crashes { 1 } else { 3 } < refused.count();
        let listed = search.mistakes[set[member]].listed();
        let refuses_only = listed.is_some_and(|listed| listed.shows == Symptom::Refusals);
        let is_coincidence = !refuses_only && few;
        // A file that is shown, and that the mistake would refuse.
        let is_shown =
            || (failing.iter()).any(|&w| search.agreement(w, &one) == Agreement::Against);
        of_member.is_empty()
            || !refuses
            || !is_coincidence && !shared.iter().any(less) && !contradicted() && !is_shown()
    });
    found.keep(&keep);
}

/// Different faults that a misreading may explain by chance, because one check is missing.
const FEW_FAULTS: usize = 2;

/// Removes mistakes that explain only accepted malformed files, if passing cases contradict them, if they explain few faults and
/// unexplained failures are about the same clause, or if most failures of legal files are unexplained.
fn drop_acceptances(search: &Search, found: &mut Found) {
    let witnesses = search.witnesses;
    let set = of(&found.members);
    let failed = (0..witnesses.len()).filter(|&w| witnesses[w].failed);
    let failed: Vec<usize> = failed.collect();
    let explains = |w: usize, set: &[Id]| search.agreement(w, set).explains();
    let open = search.select(failed.clone(), |w| !search.explains(w, &set));
    let is_legal = |w: &&usize| witnesses[**w].case.expect == Expect::Decode;
    let legal = |of: &[usize]| of.iter().filter(is_legal).count();
    let is_unknown = 4 * legal(&open) > 3 * legal(&failed);
    let keep = search.each(&set, |&id| {
        let misreading = search.mistakes[id].misreading;
        let without = without(&set, id);
        let is_explained =
            |&w: &usize| explains(w, &[id]) || explains(w, &set) && !explains(w, &without);
        let of: Vec<usize> = failed.iter().copied().filter(is_explained).collect();
        let accepts_only = !of.iter().any(|w| is_legal(&w));
        // A mistake that explains many different faults is no coincidence.
        let faults: HashSet<_> = (of.iter())
            .filter_map(|&w| Some(&witnesses[w].case.damage()?.effect))
            .collect();
        let is_denied = || !search.denied(&[id]).is_empty();
        let is_clause_open = || (open.iter()).any(|&w| is_about(&witnesses[w], misreading));
        let is_coincidence = is_unknown || faults.len() <= FEW_FAULTS && is_clause_open();
        !accepts_only || !is_coincidence && !is_denied()
    });
    found.keep(&keep);
}

/// Returns true if a case is about the misread clause.
fn is_about(witness: &Witness, misreading: &Misreading) -> bool {
    let mut clauses = witness.case.clauses.iter();
    clauses.any(|clause| clause == misreading.clause)
}

/// Returns the legal files that fail.
fn failing(witnesses: &[Witness]) -> Vec<usize> {
    let is_one = |&w: &usize| witnesses[w].failed && witnesses[w].case.expect == Expect::Decode;
    (0..witnesses.len()).filter(is_one).collect()
}
