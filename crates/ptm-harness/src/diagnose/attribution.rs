//! Attributes failures to the mistakes that the search found.

use std::collections::HashSet;

use super::diagnosis::{Category, Cause, CauseText, Diagnosis};
use super::failure_mode::FailureMode;
use super::mistake::{ChannelSubset, Mistake};
use super::scope::FileScope;
use super::search::{Member, MistakeId, MistakeSet, Search, ids_of, without_id};
use super::tuning::{MAX_SAMPLE, MIN_SHARING_FILES, is_few, is_most, is_substantial};
use super::witness::{Agreement, Witness};
use super::words::refusals::{self, WholeFormats};
use super::words::{acceptances, differences, formats_phrase};
use ptm::Format;
use ptm_mistakes::formula::EditedForm;
use ptm_mistakes::{Change, Misreading, Stage, Symptom};
use ptm_suite::cases::Expect;
use ptm_suite::protocol::frame::{Answer, ProcessEnd};
use ptm_suite::verdicts::observation::Response;

/// Failures listed under one mistake, and the other mistakes needed to explain them.
#[derive(Clone, Default)]
struct Share {
    explains: Vec<usize>,
    with: MistakeSet,
}

/// Returns a diagnosis for each mistake that explains failures, and the failures that remain unexplained. Removes all mistakes
/// from `found` that are not reported.
pub(super) fn attribute_failures(
    search: &Search,
    found: &mut Vec<Member>,
) -> (Vec<(MistakeId, Diagnosis)>, Vec<usize>) {
    let whole = refusals::whole_formats(search.witnesses);
    loop {
        let set = ids_of(found);
        let (mut shares, mut left) = share_failures(search, &set);
        let whole = whole.iter().filter_map(|whole| {
            diagnose_whole_formats(search, whole, found, &mut shares, &mut left)
        });
        let mut diagnoses: Vec<(MistakeId, Diagnosis)> = whole.collect();
        // Without a mistake that has too little evidence, the others may explain more failures.
        let is_unfounded = |&index: &usize| {
            let explained = &shares[index].explains;
            !explained.is_empty()
                && (is_weak(search, &set, index, &shares[index], &left)
                    || is_incompatible(search, &set, &shares, index)
                    || is_minor(search.witnesses, explained, &left)
                    || is_too_broad(search, set[index], explained, &left))
        };
        if let Some(index) = (0..set.len()).find(is_unfounded) {
            found.remove(index);
            continue;
        }
        let mut reported = MistakeSet::new();
        for (member, share) in found.iter().zip(&shares) {
            if !share.explains.is_empty() {
                reported.push(member.id);
                reported.extend(&share.with);
                diagnoses.push((member.id, diagnose_member(search, member, share, &left)));
            }
        }
        found.retain(|member| reported.contains(&member.id));
        return (diagnoses, left);
    }
}

/// Returns the failures listed under each mistake in `set`, and the unexplained failures.
fn share_failures(search: &Search, set: &MistakeSet) -> (Vec<Share>, Vec<usize>) {
    let mut left = Vec::new();
    let mut shares = vec![Share::default(); set.len()];
    let failed = search.failing();
    let needed = search.par_map(&failed, |&w| needed_mistakes(search, w, set));
    for (w, needed) in failed.into_iter().zip(needed) {
        // List the case under the last mistake that it needs.
        let Some((&last, others)) = needed.split_last() else {
            left.push(w);
            continue;
        };
        shares[last].explains.push(w);
        for &other in others {
            if !shares[last].with.contains(&set[other]) {
                shares[last].with.push(set[other]);
            }
        }
    }
    (shares, left)
}

/// Returns true if a more general mistake may explain the failures: in the same formats and the same or earlier views, either
/// - more than three times as many wrong images remain unexplained, and the explained failures are mostly images, or
/// - the unexplained images of earlier views number more than half of the explained failures.
///
/// Images in later views do not count, because a mistake in a later step may explain them.
fn is_minor(witnesses: &[Witness], explained: &[usize], left: &[usize]) -> bool {
    let kind = |w: &usize| witnesses[*w].observation.view.kind();
    let earliest = explained.iter().map(kind).min();
    let format = |w: &usize| witnesses[*w].case.format();
    let is_image = |w: &usize| witnesses[*w].is_telling_image();
    let has_same_format = |w: &usize| explained.iter().any(|other| format(other) == format(w));
    let mut open = left.to_vec();
    open.retain(|w| is_image(w) && Some(kind(w)) <= earliest && has_same_format(w));
    let earlier = open.iter().filter(|w| Some(kind(w)) < earliest).count();
    let images = explained.iter().filter(|w| is_image(w)).count();
    earlier >= MIN_SHARING_FILES && is_most(earlier, explained.len())
        || is_most(images, explained.len()) && !is_substantial(images, images + open.len())
}

/// Returns true if the mistake is restricted to some files, but too many wrong images of such files remain unexplained: more than
/// a few if the files share a property, or more than the mistake explains if they share a format. Blank images do not count.
fn is_too_broad(search: &Search, id: MistakeId, explained: &[usize], left: &[usize]) -> bool {
    let scope = &search.mistakes[id].scope;
    let format = |w: &usize| search.witnesses[*w].case.format();
    let formats: HashSet<Format> = explained.iter().map(format).collect();
    let is_open = |w: &&usize| {
        let witness = &search.witnesses[**w];
        witness.is_telling_image() && scope.contains(witness) && formats.contains(&format(w))
    };
    let open = left.iter().filter(is_open).count();
    match scope {
        FileScope::All => false,
        FileScope::Formats(_) => open > explained.len(),
        _ => !is_few(open, explained.len()),
    }
}

/// Describes the formats in `whole`, whose legal files all fail in the same way. Drops mistakes that explain only these failures.
/// Returns `None` if one of the mistakes also explains other failures.
fn diagnose_whole_formats(
    search: &Search,
    whole: &WholeFormats,
    members: &[Member],
    shares: &mut [Share],
    left: &mut Vec<usize>,
) -> Option<(MistakeId, Diagnosis)> {
    let is_covered = |w: &usize| whole.cases.contains(w);
    let is_seen_elsewhere = |share: &Share| {
        let inside = share.explains.iter().filter(|w| is_covered(w)).count();
        is_substantial(inside, whole.cases.len()) && inside < share.explains.len()
    };
    if shares.iter().any(is_seen_elsewhere) {
        return None;
    }
    let mut alike = Vec::new();
    for (member, share) in members.iter().zip(shares) {
        if share.explains.iter().any(is_covered) {
            let ids = std::iter::once(&member.id).chain(&member.equivalents);
            // An equivalent mistake may fail only some of these files.
            let explains = |&&id: &&MistakeId| {
                let agrees = |&w: &usize| search.agreement(w, &[id]).explains();
                whole.cases.iter().all(agrees)
            };
            alike.extend(
                ids.filter(explains)
                    .filter_map(|&id| search.mistakes[id].catalog_misreading()),
            );
        }
        share.explains.retain(|w| !is_covered(w));
    }
    left.retain(|w| !is_covered(w));
    // No mistake has this id, so no failure is partially attributed to it.
    Some((MistakeId::MAX, whole.describe(search.witnesses, alike)))
}

/// Returns true if the evidence for a misreading is too weak:
/// - more cases contradict it than support it, or more than half as many if it explains images (images of files that it would
///   refuse count as contradictions),
/// - only malformed files support it, and some case contradicts it,
/// - only a single legal file supports it, and the response is not an image,
/// - it explains a crash by a signal, and no image supports it, or
/// - it changes values, no image supports it, and it explains fewer failures than there are unexplained images.
fn is_weak(search: &Search, set: &[MistakeId], i: usize, share: &Share, left: &[usize]) -> bool {
    let Some(misreading) = search.mistakes[set[i]].catalog_misreading() else {
        return false;
    };
    let (witnesses, explained) = (search.witnesses, &share.explains);
    let alone = &set[i..=i];
    let would_refuse = |w, set| search.agreement(w, set) == Agreement::Contradiction;
    let is_read = |w: &&usize| would_refuse(**w, alone) && would_refuse(**w, set);
    let read = search.failing().iter().filter(is_read).count();
    let contradictions = read + search.contradictions(alone).len();
    let is_guess = || acceptances::describe_acceptances(witnesses, explained, misreading).is_some();
    let mode = |w: &usize| FailureMode::new(&witnesses[*w]);
    let signal = |text: &str| matches!(ProcessEnd::parse(text), Some(ProcessEnd::Signal(_)));
    let is_signal = |w| matches!(mode(w), Some(FailureMode::Crashes(text)) if signal(&text));
    let images = |indices: &[usize]| indices.iter().filter(|w| mode(w).is_none()).count();
    let is_hidden = misreading.symptom != Symptom::Refusals && images(explained) == 0;
    let is_single = matches!(explained[..], [w] if witnesses[w].case.expect == Expect::Decode);
    images(explained) == 0 && (is_single || explained.iter().any(is_signal))
        || is_hidden && images(left) > explained.len()
        || contradictions > explained.len()
        || images(explained) > 0 && is_most(contradictions, explained.len())
        || contradictions > 0 && is_guess()
}

/// Returns true if the mistake at `index` is incompatible with mistakes that explain more failures, because it would spoil more
/// responses than it explains. A response is spoiled if one of these other mistakes reproduces it alone, but not in combination
/// with the mistake at `index`.
fn is_incompatible(search: &Search, set: &[MistakeId], shares: &[Share], index: usize) -> bool {
    let own = shares[index].explains.len();
    let others = (0..shares.len()).filter(|&other| shares[other].explains.len() > own);
    let pairs = others.flat_map(|other| {
        let files = search.smallest(&shares[other].explains, MAX_SAMPLE);
        files.into_iter().map(move |w| (other, w))
    });
    let conflicts = search.par_map(&pairs.collect::<Vec<_>>(), |&(other, w)| {
        let both = [set[other], set[index]];
        search.answers_differ(w, &both, &both[..1])
            && search.agreement(w, &both[..1]).explains()
            && !search.agreement(w, &both).explains()
    });
    conflicts.into_iter().filter(|conflicts| *conflicts).count() > own
}

fn diagnose_member(search: &Search, member: &Member, share: &Share, left: &[usize]) -> Diagnosis {
    let witnesses = search.witnesses;
    let listed = |set: &[MistakeId]| -> Vec<&'static Misreading> {
        let mistakes = set.iter().map(|&id| &search.mistakes[id]);
        mistakes.filter_map(Mistake::catalog_misreading).collect()
    };
    let mistake = &search.mistakes[member.id];
    let Some(misreading) = mistake.unrestricted_misreading() else {
        return diagnose_edit(search, mistake, share, left);
    };
    // A mistake that is restricted to some files differs from the misreading in the catalog.
    let alike = member
        .equivalents
        .iter()
        .filter_map(|&id| search.mistakes[id].unrestricted_misreading());
    let mut alike: Vec<&'static Misreading> = alike.collect();
    let observed = refusals::describe_observation(witnesses, &share.explains);
    if let Some(observed) = observed.filter(|_| misreading.symptom != Symptom::Refusals) {
        return observed.with_equivalents([&[misreading], &alike[..]].concat());
    }
    let in_suite = |indices: &[usize]| -> Vec<usize> {
        indices.iter().map(|&w| witnesses[w].case_index).collect()
    };
    let accepted = acceptances::describe_acceptances(witnesses, &share.explains, misreading);
    // A decoder with a misreading that accepts other malformed files as well would not look the same.
    let accepts_more = |misreading: &'static Misreading| {
        let mistake = Mistake::unscoped(misreading);
        let accepts = |w: &usize| {
            let witness = &witnesses[*w];
            witness.expected == Answer::Rejected
                && matches!(witness.observation.response, Response::Rejected)
                && matches!(*witness.answer(&[&mistake]), Answer::Decoded(_))
        };
        search.run_or_default(|| search.passing.iter().any(accepts))
    };
    if accepted.is_some() {
        alike.retain(|misreading| !accepts_more(misreading));
    }
    let observed = match accepted {
        Some(accepted) if accepts_more(misreading) => {
            let diagnosis = Diagnosis::new(accepted, in_suite(&share.explains));
            return diagnosis.with_equivalents(alike);
        }
        accepted => refusals::describe_non_images(witnesses, &share.explains, misreading, &alike)
            .or(accepted),
    };
    let cause = Cause::Misreading {
        misreading,
        equivalents: alike,
        accompanying: listed(&share.with),
    };
    Diagnosis {
        contradicted_by: in_suite(&search.contradictions(&[member.id])),
        observed,
        is_certain: true,
        ..Diagnosis::new(cause, in_suite(&share.explains))
    }
}

/// Returns the diagnosis for an edit of a formula, or for a misreading that is restricted to some files or channels.
fn diagnose_edit(search: &Search, mistake: &Mistake, share: &Share, left: &[usize]) -> Diagnosis {
    let witnesses = search.witnesses;
    let misreading = mistake.misreading;
    let files = match &mistake.scope {
        // An edit may change nothing in other formats.
        FileScope::All => formats_phrase(witnesses, &share.explains),
        scope => {
            // The decoder may make the same mistake in the other files, with other results.
            let is_open = |w: &&usize| {
                let witness = &witnesses[**w];
                witness.is_image_of_legal_file() && !scope.contains(witness)
            };
            let open = left.iter().filter(is_open).count();
            match is_few(open, share.explains.len()) {
                true => format!(", only in files {}", scope.describe_members()),
                false => format!(", in files {}", scope.describe_members()),
            }
        }
    };
    let (effect, fix) = match (mistake.catalog_misreading(), misreading.change) {
        (None, Change::Edits([edit])) => {
            let (value, stated) = (edit.formula.stated().result, edit.stated_text());
            let computes = edit.edited_text();
            match edit.change {
                EditedForm::Table(_) => (
                    format!("maps {value} through {computes}"),
                    "compare the value in the example with the bytes that determine it".to_owned(),
                ),
                EditedForm::Expression(_) => (
                    format!("computes {value} as {computes} instead of {stated}"),
                    format!("compute {value} as {stated}"),
                ),
            }
        }
        _ => (
            misreading.effect.to_owned(),
            format!(
                "{} (see ptm-conform explain {})",
                misreading.fix, misreading.slug
            ),
        ),
    };
    let text = CauseText {
        effect: effect + &mistake.channels.describe() + &files,
        fix,
        example: differences::example(
            search,
            &[],
            differences::smallest_file(witnesses, &share.explains),
        ),
    };
    let described =
        Diagnosis::from_description(Category::Difference, witnesses, &share.explains, text);
    Diagnosis {
        is_certain: true,
        ..described.with_clause(misreading.clause)
    }
}

/// Returns the indices in `set` of the mistakes that are needed to explain a failure: one mistake that is sufficient alone, or
/// else all indispensable mistakes. Returns the first mistake if none is indispensable.
fn needed_mistakes(search: &Search, w: usize, set: &[MistakeId]) -> Vec<usize> {
    let explained = |set: &[MistakeId]| search.explains(w, set);
    if let Some(alone) = (0..set.len()).find(|&member| explained(&[set[member]])) {
        return vec![alone];
    }
    if set.is_empty() || !explained(set) {
        return Vec::new();
    }
    let is_needed = |&member: &usize| !explained(&without_id(set, set[member]));
    let needed: Vec<usize> = (0..set.len()).filter(is_needed).collect();
    if needed.is_empty() { vec![0] } else { needed }
}

/// Returns true if the response contains colors computed from channels that the mistake changes.
fn shows_in_colors(search: &Search, w: usize, member: MistakeId) -> bool {
    let (witness, mistake) = (&search.witnesses[w], &search.mistakes[member]);
    mistake.channels != ChannelSubset::All
        && mistake.misreading.stage() < Stage::Color
        && witness.is_rgb()
        && witness.can_affect(mistake)
        && FailureMode::new(witness).is_none()
}

/// Extends each diagnosis with the failures that its mistake partially explains. Removes these failures from `left`.
pub(super) fn attribute_partially(
    search: &Search,
    found: &[Member],
    diagnoses: &mut [(MistakeId, Diagnosis)],
    left: &mut Vec<usize>,
) {
    let set = ids_of(found);
    let named: MistakeSet = diagnoses.iter().map(|(id, _)| *id).collect();
    let changes = |w: usize, member: MistakeId| {
        FailureMode::new(&search.witnesses[w]).is_none()
            && search.answers_differ(w, &set, &without_id(&set, member))
    };
    // A mistake that reproduces nearly all images that it changes also affects the remaining ones.
    let explains_nearly_all = |member: MistakeId| {
        let explained = diagnoses.iter().find(|(id, _)| *id == member);
        let explained = explained.map_or(0, |(_, diagnosis)| diagnosis.explains.len());
        let open = left.iter().filter(|&&w| changes(w, member)).count();
        is_few(open, explained)
    };
    let thorough = set.iter().copied().filter(|&id| explains_nearly_all(id));
    let thorough: Vec<MistakeId> = thorough.collect();
    left.retain(|&w| {
        let explains_partially = |&&member: &&MistakeId| {
            named.contains(&member)
                && (thorough.contains(&member) && changes(w, member)
                    || shows_in_colors(search, w, member)
                    || differences::reduces_wrong_samples(search, w, &set, member))
        };
        let member = set.iter().find(explains_partially);
        let known = member.and_then(|member| diagnoses.iter_mut().find(|(id, _)| id == member));
        let is_left = known.is_none();
        if let Some((_, diagnosis)) = known {
            diagnosis.partial.push(search.witnesses[w].case_index);
        }
        is_left
    });
}
