//! Attribution of failures to the mistakes that were found.

use super::diagnosis::{Category, Cause, CauseWords, Diagnosis};
use super::failure_mode::FailureMode;
use super::mistake::{ChannelSubset, Mistake};
use super::scope::FileScope;
use super::search::{FoundMistakes, Id, Member, Search, Set, ids_of, without_id};
use super::tuning::{MAX_SAMPLE, MIN_SHARING_FILES, is_few, is_most, is_much};
use super::witness::Witness;
use super::words::acceptances;
use super::words::formats_of;
use super::words::place;
use super::words::refusals::{self, WholeFormats};
use crate::formula::{Edit, EditedForm};
use crate::misreadings::{At, Misreading, Stage, Symptom};
use crate::suite::cases::Expect;

/// The failures listed under a mistake, and the other mistakes that they need.
#[derive(Clone, Default)]
struct Share {
    explains: Vec<usize>,
    with: Set,
}

/// Returns a diagnosis for each mistake that explains failures, and the failures that none explains.
pub(super) fn attribute(
    search: &Search,
    found: &FoundMistakes,
) -> (Vec<(Id, Diagnosis)>, Vec<usize>) {
    let set = ids_of(&found.members);
    let mut left = Vec::new();
    let mut shares = vec![Share::default(); set.len()];
    let failed = search.failing();
    let needed = search.each(&failed, |&w| needed(search, w, &set));
    for (w, needed) in failed.into_iter().zip(needed) {
        // The case is listed under the last of the mistakes that it needs.
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
    let whole = refusals::whole_formats(search.witnesses);
    let mut diagnoses: Vec<(Id, Diagnosis)> = whole
        .into_iter()
        .filter_map(|whole| of_whole(search, &whole, &found.members, &mut shares, &mut left))
        .collect();
    for (place, member) in found.members.iter().enumerate() {
        if is_denied_guess(search, member, &shares[place], &left)
            || is_denied_beside(search, &set, &shares, place)
            || is_preceded(search.witnesses, &shares[place].explains, &left)
            || is_minor(search.witnesses, &shares[place].explains, &left)
        {
            left.append(&mut shares[place].explains);
        }
    }
    let members = found.members.iter().zip(shares);
    let others = members
        .filter(|(_, share)| !share.explains.is_empty())
        .map(|(member, share)| (member.id, diagnosis(search, member, &share)));
    diagnoses.extend(others);
    (diagnoses, left)
}

/// Returns true if more than half as many unexplained images of the same formats are wrong in an earlier view than any image that
/// the mistake explains: an earlier step may explain these images, too.
fn is_preceded(witnesses: &[Witness], explained: &[usize], left: &[usize]) -> bool {
    let kind = |&w: &usize| witnesses[w].observation.view.kind();
    let format = |&w: &usize| witnesses[w].case.format();
    let earliest = explained.iter().map(kind).min();
    let is_earlier = |w: &&usize| {
        Some(kind(w)) < earliest
            && FailureMode::new(&witnesses[**w]).is_none()
            && witnesses[**w].case.expect == Expect::Decode
            && explained.iter().any(|of| format(of) == format(w))
    };
    let earlier = left.iter().filter(is_earlier).count();
    earlier >= MIN_SHARING_FILES && is_most(earlier, explained.len())
}

/// Returns true if most of what shows is legal images, and these are less than a quarter of the wrong images of their formats that
/// have no other cause: a larger mistake may explain them, too.
fn is_minor(witnesses: &[Witness], explained: &[usize], left: &[usize]) -> bool {
    let format = |w: &usize| witnesses[*w].case.format();
    let is_image = |w: &usize| {
        let witness = &witnesses[*w];
        witness.case.expect == Expect::Decode && FailureMode::new(witness).is_none()
    };
    let is_open = |w: &&usize| is_image(w) && explained.iter().any(|of| format(of) == format(w));
    let open = left.iter().filter(is_open).count();
    let images = explained.iter().filter(|w| is_image(w)).count();
    is_most(images, explained.len()) && !is_much(images, images + open)
}

/// Describes whole formats that fail in one way, instead of the mistakes that explain nothing else. Returns `None` if one of
/// these mistakes explains other failures too.
fn of_whole(
    search: &Search,
    whole: &WholeFormats,
    members: &[Member],
    shares: &mut [Share],
    left: &mut Vec<usize>,
) -> Option<(Id, Diagnosis)> {
    let is_of = |w: &usize| whole.of.contains(w);
    let is_seen_elsewhere = |share: &Share| {
        let inside = share.explains.iter().filter(|w| is_of(w)).count();
        is_much(inside, whole.of.len()) && inside < share.explains.len()
    };
    if shares.iter().any(is_seen_elsewhere) {
        return None;
    }
    let mut alike = Vec::new();
    for (member, share) in members.iter().zip(shares) {
        if share.explains.iter().any(is_of) {
            let ids = std::iter::once(&member.id).chain(&member.alike);
            // Other mistakes may fail only some of these files.
            let explains = |&&id: &&Id| {
                let agrees = |&w: &usize| search.agreement(w, &[id]).explains();
                whole.of.iter().all(agrees)
            };
            alike.extend(
                ids.filter(explains)
                    .filter_map(|&id| search.mistakes[id].listed()),
            );
        }
        share.explains.retain(|w| !is_of(w));
    }
    left.retain(|w| !is_of(w));
    // No mistake has this id, so no failure is explained by it in part.
    Some((Id::MAX, whole.describe(search.witnesses, alike)))
}

/// Returns true if more cases contradict a misreading than support it, if only malformed files support it and some case contradicts
/// it, if no image but a signal shows it, or if it changes values and no image shows that, but more unexplained images are wrong.
fn is_denied_guess(search: &Search, member: &Member, share: &Share, left: &[usize]) -> bool {
    let Some(misreading) = search.mistakes[member.id].listed() else {
        return false;
    };
    let (witnesses, explained) = (search.witnesses, &share.explains);
    let against = search.contradictions(&[member.id]).len();
    let is_guess = || acceptances::all_that_shows(witnesses, explained, misreading).is_some();
    let mode = |w: &usize| FailureMode::new(&witnesses[*w]);
    let is_signal =
        |w| matches!(mode(w), Some(FailureMode::Crashes(how)) if how.starts_with("killed"));
    let images = |of: &[usize]| of.iter().filter(|w| mode(w).is_none()).count();
    let is_hidden = misreading.shows == Symptom::Values && images(explained) == 0;
    images(explained) == 0 && explained.iter().any(is_signal)
        || is_hidden && images(left) > explained.len()
        || against > explained.len()
        || against > 0 && is_guess()
}

/// Returns true if more of the files that another mistake explains alone contradict this mistake than support it. A decoder that
/// makes both would show other values in these files.
fn is_denied_beside(search: &Search, set: &[Id], shares: &[Share], place: usize) -> bool {
    let own = shares[place].explains.len();
    if own == 0 {
        return false;
    }
    let others = (0..shares.len()).filter(|&other| shares[other].explains.len() > own);
    let pairs = others.flat_map(|other| {
        let files = search.smallest(&shares[other].explains, MAX_SAMPLE);
        files.into_iter().map(move |w| (other, w))
    });
    let denied = search.each(&pairs.collect::<Vec<_>>(), |&(other, w)| {
        let both = [set[other], set[place]];
        search.differ(w, &both, &both[..1])
            && search.agreement(w, &both[..1]).explains()
            && !search.agreement(w, &both).explains()
    });
    denied.into_iter().filter(|denied| *denied).count() > own
}

fn diagnosis(search: &Search, member: &Member, share: &Share) -> Diagnosis {
    let witnesses = search.witnesses;
    let listed = |set: &[Id]| -> Vec<&'static Misreading> {
        let mistakes = set.iter().map(|&id| &search.mistakes[id]);
        mistakes.filter_map(Mistake::listed).collect()
    };
    let mistake = &search.mistakes[member.id];
    let Some(misreading) = mistake.of_catalog() else {
        return of_found(search, mistake, share);
    };
    // A mistake that is limited to some files is not the misreading of the catalog.
    let alike = member
        .alike
        .iter()
        .filter_map(|&id| search.mistakes[id].of_catalog());
    let alike: Vec<&Misreading> = alike.collect();
    let observed = refusals::all_that_shows(witnesses, &share.explains);
    if let Some(observed) = observed.filter(|_| misreading.shows == Symptom::Values) {
        return observed.with_alike([&[misreading], &alike[..]].concat());
    }
    let except = search.contradictions(&[member.id]);
    let cause = Cause::Misreading {
        misreading,
        alike,
        with: listed(&share.with),
    };
    Diagnosis {
        except: except.iter().map(|&w| witnesses[w].place).collect(),
        shows: refusals::no_picture(witnesses, &share.explains, misreading)
            .or_else(|| acceptances::all_that_shows(witnesses, &share.explains, misreading)),
        certain: true,
        ..Diagnosis::new(cause, places(search, &share.explains))
    }
}

fn places(search: &Search, of: &[usize]) -> Vec<usize> {
    of.iter().map(|&w| search.witnesses[w].place).collect()
}

/// Returns the diagnosis of an edit of a formula, or of a misreading that is limited to some files or channels.
fn of_found(search: &Search, mistake: &Mistake, share: &Share) -> Diagnosis {
    let witnesses = search.witnesses;
    let misreading = mistake.misreading;
    let place = match &mistake.scope {
        // In other formats an edit may change nothing.
        FileScope::All => formats_of(witnesses, &share.explains),
        scope => format!(", only in files {}", scope.describe()),
    };
    let (effect, fix) = match (mistake.listed(), misreading.at) {
        (None, At::Edits([edit])) => computed(edit),
        _ => (
            misreading.effect.to_owned(),
            format!(
                "{}. More: ptm-conform explain {}",
                misreading.fix, misreading.slug
            ),
        ),
    };
    let words = CauseWords {
        effect: effect + &mistake.channels.describe() + &place,
        fix,
        example: place::example(search, place::smallest(witnesses, &share.explains)),
    };
    let described = Diagnosis::described(Category::Difference, witnesses, &share.explains, words);
    Diagnosis {
        certain: true,
        ..described.with_clause(misreading.clause)
    }
}

/// Returns the effect and the fix of an edit.
fn computed(edit: &Edit) -> (String, String) {
    let (what, computes, stated) = (
        edit.formula.stated().computes,
        edit.computes(),
        edit.stated(),
    );
    match edit.change {
        EditedForm::Table(_) => (
            format!("maps {what} through {computes}"),
            "compare the example with the bytes that it comes from".to_owned(),
        ),
        EditedForm::Expression(_) => (
            format!("computes {what} as {computes} instead of {stated}"),
            format!("compute {what} as {stated}"),
        ),
    }
}

/// Returns the places of the mistakes in `set` that a failure needs: one that explains it alone, or all that are indispensable.
fn needed(search: &Search, w: usize, set: &[Id]) -> Vec<usize> {
    let explained = |set: &[Id]| search.explains(w, set);
    if let Some(alone) = (0..set.len()).find(|&member| explained(&[set[member]])) {
        return vec![alone];
    }
    if set.is_empty() || !explained(set) {
        return Vec::new();
    }
    let needed = indispensable(set, explained);
    if needed.is_empty() { vec![0] } else { needed }
}

/// Returns the places of the members without which `holds` is no longer true.
pub(super) fn indispensable(set: &[Id], holds: impl Fn(&[Id]) -> bool) -> Vec<usize> {
    let is_needed = |&member: &usize| {
        let mut without = set.to_vec();
        without.remove(member);
        !holds(&without)
    };
    (0..set.len()).filter(is_needed).collect()
}

/// Returns true if the colors of an image are computed from channels that a mistake changes.
fn shows_in_colors(search: &Search, w: usize, member: Id) -> bool {
    let (witness, mistake) = (&search.witnesses[w], &search.mistakes[member]);
    mistake.channels != ChannelSubset::All
        && mistake.misreading.at.stage() < Stage::Color
        && witness.is_in_colors()
        && witness.concerns(mistake)
        && FailureMode::new(witness).is_none()
}

/// Lists failures that a mistake explains in part under it, and removes them from `left`.
pub(super) fn attribute_in_part(
    search: &Search,
    found: &FoundMistakes,
    diagnoses: &mut [(Id, Diagnosis)],
    left: &mut Vec<usize>,
) {
    let set = ids_of(&found.members);
    let acts = |w: usize, member: Id| {
        FailureMode::new(&search.witnesses[w]).is_none()
            && search.differ(w, &set, &without_id(&set, member))
    };
    // A mistake that reproduces nearly all images that it changes is made in the others too.
    let explains_nearly_all = |member: Id| {
        let explained = diagnoses.iter().find(|(id, _)| *id == member);
        let explained = explained.map_or(0, |(_, diagnosis)| diagnosis.explains.len());
        let open = left.iter().filter(|&&w| acts(w, member)).count();
        is_few(open, explained)
    };
    let thorough: Vec<Id> = set
        .iter()
        .copied()
        .filter(|&id| explains_nearly_all(id))
        .collect();
    left.retain(|&w| {
        let is_partly = |&&member: &&Id| {
            thorough.contains(&member) && acts(w, member)
                || shows_in_colors(search, w, member)
                || place::is_near(search, w, &set, member)
        };
        let near = set.iter().find(is_partly);
        let known = near.and_then(|member| diagnoses.iter_mut().find(|(id, _)| id == member));
        let is_left = known.is_none();
        if let Some((_, diagnosis)) = known {
            diagnosis.partly.push(search.witnesses[w].place);
        }
        is_left
    });
}
