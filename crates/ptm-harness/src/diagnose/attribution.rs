//! Lists failures under the mistakes that the search found.

use super::diagnosis::{Accompanying, Category, Cause, CauseText, Diagnosis};
use super::failure_mode::FailureMode;
use super::mistake::Mistake;
use super::rules;
use super::scope::list_formats;
use super::search::{Member, MistakeId, MistakeSet, Search, ids_of, without_id};
use super::tuning::is_few;
use super::words::{acceptances, differences, formats_phrase, refusals, refusals::WholeFormats};
use ptm::Format;
use ptm_mistakes::formula::EditedForm;
use ptm_mistakes::{Change, Misreading, Symptom};

/// Failures listed under one mistake, and the other mistakes needed to reproduce them.
#[derive(Clone, Default)]
struct Share {
    explains: Vec<usize>,
    with: MistakeSet,
}

/// The failures that mistakes explain.
pub(super) struct Attribution {
    /// One diagnosis for each mistake.
    pub diagnoses: Vec<Diagnosis>,
    /// The mistakes.
    pub set: MistakeSet,
    /// Those of them that the diagnoses name.
    pub named: MistakeSet,
    /// The failures that the mistakes do not reproduce.
    pub left: Vec<usize>,
}

/// Lists each failure under the mistake that reproduces it. Mistakes with too little evidence are dropped.
pub(super) fn attribute_failures(search: &Search, mut found: Vec<Member>) -> Attribution {
    loop {
        let set = ids_of(&found);
        let (shares, left) = share_failures(search, &set);
        let needed: MistakeSet = (0..set.len())
            .filter(|&index| !shares[index].explains.is_empty())
            .flat_map(|index| [&[set[index]], &shares[index].with[..]].concat())
            .collect();
        let is_unfounded = |&index: &usize| {
            let explained = &shares[index].explains;
            !needed.contains(&set[index])
                || !explained.is_empty() && !is_founded(search, &set, set[index], explained, &left)
        };
        if let Some(excluded) = excluded_mistakes(search, &set, &shares) {
            found.retain(|member| !excluded.contains(&member.id));
            continue;
        }
        // The mistake that was found last has the least support.
        if let Some(index) = (0..set.len()).rev().find(is_unfounded) {
            found.remove(index);
            continue;
        }
        let whole = refusals::whole_formats(search.witnesses);
        return describe_shares(search, &found, shares, left, &whole);
    }
}

/// Returns mistakes that exclude each other, if any: a decoder computes a value in one way only, so two changes of it that never
/// appear together are parts of another mistake. If one of them explains few failures, only that one is returned.
fn excluded_mistakes(search: &Search, set: &MistakeSet, shares: &[Share]) -> Option<MistakeSet> {
    (0..set.len()).rev().find_map(|later| {
        let excludes = |earlier: &usize| {
            search.change_same_value(set[*earlier], set[later])
                && !shares[*earlier].with.contains(&set[later])
                && !shares[later].with.contains(&set[*earlier])
        };
        let earlier = (0..later).find(excludes)?;
        let [many, few] = [earlier, later].map(|index| shares[index].explains.len());
        Some(match is_few(few, many) {
            true => vec![set[later]],
            false => vec![set[earlier], set[later]],
        })
    })
}

fn is_founded(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    explained: &[usize],
    left: &[usize],
) -> bool {
    let others = || rules::count_failures_of_the_same_kind(search.witnesses, explained, left);
    let symptom = search.mistakes[id].misreading.symptom;
    let are_refusals = symptom == Symptom::Refusals;
    let read = || rules::count_files_read(search.witnesses, explained);
    let covers_its_kind = || match rules::is_shown(search, set, id, explained) {
        false => others() == 0,
        true => !are_refusals || others() <= explained.len().min(read()),
    };
    // Contradictions come last, because the search for them decodes large files.
    rules::is_shown_by_own_failures(search, set, id, explained)
        && rules::explains_most_of_what_it_changes(search, set, id, explained, left)
        && !refusals::is_part_of_a_larger_group(search.witnesses, explained)
        && !refusals::is_single_among_others(search.witnesses, explained, left)
        && (symptom != Symptom::Acceptances
            || acceptances::count_of_the_same_kind(search.witnesses, explained, left)
                <= explained.len())
        && covers_its_kind()
        && (rules::is_shown(search, set, id, explained) && !are_refusals
            || rules::refuses_no_image(search, id))
        && rules::checks_all_indices(search, set, id, explained)
        && !search.is_contradicted_anywhere(&without_id(set, id), id)
}

fn describe_shares(
    search: &Search,
    found: &[Member],
    mut shares: Vec<Share>,
    mut left: Vec<usize>,
    whole: &[WholeFormats],
) -> Attribution {
    let set = ids_of(found);
    let (mut diagnoses, mut named) = (Vec::new(), Vec::new());
    for formats in whole {
        diagnoses.extend(diagnose_whole_formats(
            search,
            formats,
            found,
            &mut shares,
            &mut left,
        ));
    }
    for (member, share) in found.iter().zip(&shares) {
        if !share.explains.is_empty() {
            let of_member = diagnose_member(search, &set, member, share);
            named.extend(
                of_member
                    .iter()
                    .any(|one| one.is_mechanism)
                    .then_some(member.id),
            );
            diagnoses.extend(of_member);
        }
    }
    Attribution {
        diagnoses,
        set,
        named,
        left,
    }
}

/// Returns the failures listed under each mistake in `set`, and the unexplained failures.
fn share_failures(search: &Search, set: &MistakeSet) -> (Vec<Share>, Vec<usize>) {
    let mut left = Vec::new();
    let mut shares = vec![Share::default(); set.len()];
    let failed = search.failing();
    let needed = search.par_map(&failed, |&w| needed_mistakes(search, w, set));
    // List each case under the last mistake that it needs.
    for (&w, needed) in failed.iter().zip(&needed) {
        match needed.last() {
            Some(&last) => shares[last].explains.push(w),
            None => left.push(w),
        }
    }
    for (&id, share) in set.iter().zip(&mut shares) {
        let explained = &mut share.explains;
        left.extend(rules::take_exceeded_limits(search, set, id, explained));
        rules::sort_smallest_first(search.witnesses, explained);
    }
    for (w, needed) in failed.iter().zip(&needed) {
        let Some((&last, others)) = needed.split_last() else {
            continue;
        };
        let share = &mut shares[last];
        for &other in others {
            if !share.with.contains(&set[other]) && share.explains.contains(w) {
                share.with.push(set[other]);
            }
        }
    }
    (shares, left)
}

/// Returns the indices in `set` of the mistakes that are needed to reproduce a failure: one mistake that is sufficient alone, or
/// else all indispensable mistakes. Returns the first mistake if none is indispensable.
fn needed_mistakes(search: &Search, w: usize, set: &[MistakeId]) -> Vec<usize> {
    let explained = |set: &[MistakeId]| search.explains(w, set);
    // A decoder meets the mistake in the earliest section first.
    let sufficient = (0..set.len()).filter(|&member| explained(&[set[member]]));
    if let Some(alone) = sufficient.min_by_key(|&member| search.mistakes[set[member]].section()) {
        return vec![alone];
    }
    if set.is_empty() || !explained(set) {
        return Vec::new();
    }
    let is_needed = |&member: &usize| !explained(&without_id(set, set[member]));
    let needed: Vec<usize> = (0..set.len()).filter(is_needed).collect();
    if needed.is_empty() { vec![0] } else { needed }
}

/// Describes the formats in `whole`, whose legal files all fail in the same way, and removes these failures from the shares of the
/// mistakes. Returns `None` if a mistake that explains them also explains other failures.
fn diagnose_whole_formats(
    search: &Search,
    whole: &WholeFormats,
    members: &[Member],
    shares: &mut [Share],
    left: &mut Vec<usize>,
) -> Option<Diagnosis> {
    let is_covered = |w: &usize| whole.cases.contains(w);
    let is_seen_elsewhere = |share: &Share| {
        let inside = share.explains.iter().filter(|w| is_covered(w)).count();
        inside > 0 && inside < share.explains.len()
    };
    if shares.iter().any(is_seen_elsewhere) {
        return None;
    }
    let mut alike = Vec::new();
    for (member, share) in members.iter().zip(shares) {
        if share.explains.iter().any(is_covered) {
            let ids = std::iter::once(&member.id).chain(&member.alternatives);
            let explains = |&&id: &&MistakeId| {
                let agrees = |&w: &usize| search.agreement(w, &[id]).explains();
                whole.cases.iter().all(agrees) && rules::refuses_no_image(search, id)
            };
            alike.extend(
                ids.filter(explains)
                    .filter_map(|&id| search.mistakes[id].catalog_misreading()),
            );
        }
        share.explains.retain(|w| !is_covered(w));
    }
    left.retain(|w| !is_covered(w));
    Some(whole.describe(search.witnesses, alike))
}

/// Returns the diagnoses for a mistake: the mistake or, if the responses do not show it, observations.
fn diagnose_member(
    search: &Search,
    set: &MistakeSet,
    member: &Member,
    share: &Share,
) -> Vec<Diagnosis> {
    let witnesses = search.witnesses;
    let explained = &share.explains;
    let mistake = &search.mistakes[member.id];
    let Some(misreading) = mistake.unrestricted_misreading() else {
        return vec![diagnose_edit(search, set, member.id, share)];
    };
    let is_shown = rules::is_shown(search, set, member.id, explained);
    let are_refusals = misreading.symptom == Symptom::Refusals;
    // Only misreadings of the catalog are reported.
    let listed = |&id: &MistakeId| Some((id, search.mistakes[id].unrestricted_misreading()?));
    let alike = member
        .alternatives
        .iter()
        .filter_map(listed)
        .filter(|&(other, _)| rules::looks_the_same(search, set, [member.id, other], explained))
        .filter(|&(other, _)| !search.is_contradicted_anywhere(&without_id(set, member.id), other))
        .filter(|&(other, _)| is_shown && !are_refusals || rules::refuses_no_image(search, other))
        .map(|(_, misreading)| misreading);
    let alike: Vec<&'static Misreading> = alike.collect();
    let is_unique = alike.iter().all(|other| other.clause == misreading.clause);
    let is_observation = misreading.symptom != Symptom::Values;
    if !is_shown || is_observation && !is_unique {
        let candidates = [&[misreading], &alike[..]].concat();
        // A misreading that needs an edit outside the catalog does not look the same.
        let is_in_catalog =
            |&id: &MistakeId| search.mistakes[id].unrestricted_misreading().is_some();
        let others = without_id(set, member.id).into_iter().filter(is_in_catalog);
        let others: MistakeSet = others.collect();
        let id_of = |misreading: &Misreading| {
            let is_same = |&id: &MistakeId| {
                let other = search.mistakes[id].unrestricted_misreading();
                other.is_some_and(|other| other.slug == misreading.slug)
            };
            (0..search.mistakes.len()).find(is_same)
        };
        let that_reproduce = |cases: &[usize], with: &[MistakeId]| -> Vec<&'static Misreading> {
            let is_sufficient = |misreading: &&Misreading| {
                let set: MistakeSet = with.iter().copied().chain(id_of(misreading)).collect();
                cases.iter().all(|&w| search.explains(w, &set))
            };
            let candidates = candidates.iter().copied();
            candidates.filter(is_sufficient).collect()
        };
        let is_accepted = |w: &usize| FailureMode::new(&witnesses[*w]).is_none();
        let (accepted, stopped): (Vec<usize>, Vec<usize>) =
            explained.iter().copied().partition(is_accepted);
        let mut observations = Vec::new();
        if !accepted.is_empty() {
            let alike = that_reproduce(&accepted, &others);
            let observation = acceptances::describe_group(witnesses, &accepted);
            observations.push(observation.with_equivalents(alike));
        }
        if !stopped.is_empty() {
            // The other mistakes may be observations, too, so each misreading must reproduce all of these failures alone.
            let mut alike = that_reproduce(&stopped, &[]);
            alike.retain(|misreading| {
                id_of(misreading).is_some_and(|id| rules::refuses_no_image(search, id))
            });
            let observation = refusals::describe_failures(witnesses, &stopped);
            observations.push(observation.with_equivalents(alike));
        }
        return observations;
    }
    let cause = Cause::Misreading {
        misreading,
        equivalents: alike,
    };
    vec![Diagnosis {
        accompanying: accompanying(search, share),
        is_mechanism: true,
        ..Diagnosis::new(cause, search.case_indices(explained))
    }]
}

/// Returns the other mistakes that some responses of a share need.
fn accompanying(search: &Search, share: &Share) -> Vec<Accompanying> {
    let others = share.with.iter().map(|&id| {
        let mistake = &search.mistakes[id];
        match mistake.catalog_misreading() {
            Some(misreading) => Accompanying::Misreading(misreading),
            None => Accompanying::Edit(effect_and_fix(mistake)[0].clone()),
        }
    });
    others.collect()
}

/// Returns the diagnosis for an edit of a formula, or for a misreading that is restricted to some formats or channels.
fn diagnose_edit(search: &Search, set: &MistakeSet, id: MistakeId, share: &Share) -> Diagnosis {
    let witnesses = search.witnesses;
    let mistake = &search.mistakes[id];
    let files = match &mistake.formats {
        // The mistake may also change other formats, in other files than these.
        None => formats_phrase(witnesses, &share.explains),
        Some(formats) => limit_text(search, &without_id(set, id), mistake, formats),
    };
    let [effect, fix] = effect_and_fix(mistake);
    let text = CauseText {
        effect: effect + &files,
        fix,
        example: differences::example_of_mistake(search, set, id, share.explains[0]),
    };
    let (cases, category) = (&share.explains, Category::Difference);
    Diagnosis {
        accompanying: accompanying(search, share),
        ..Diagnosis::from_description(category, witnesses, cases, text, None)
            .with_mechanism(mistake.misreading.clause)
    }
}

/// Returns text such as ", in files of format LRGB" if every other format whose images the mistake would change contradicts it, or
/// else ", seen in files of LRGB, but not of RGB".
fn limit_text(search: &Search, set: &MistakeSet, mistake: &Mistake, formats: &[Format]) -> String {
    let witnesses = search.witnesses;
    let everywhere = Mistake {
        channels: mistake.channels,
        ..Mistake::unrestricted(mistake.misreading)
    };
    let mut excluded = search.contradicted_formats(set, &everywhere);
    excluded.retain(|format| !formats.contains(format));
    let is_open = |&w: &usize| {
        let format = witnesses[w].case.format();
        let is_known = formats.contains(&format) || excluded.contains(&format);
        let changed = || search.changed_agreement_with(w, set, &everywhere);
        !is_known && search.is_small(w) && changed().is_some()
    };
    let seen = list_formats(formats);
    match (0..witnesses.len()).any(|w| is_open(&w)) {
        false => format!(", in files of format {seen}"),
        true if excluded.is_empty() => format!(", seen in files of {seen}"),
        true => format!(
            ", seen in files of {seen}, but not of {}",
            list_formats(&excluded)
        ),
    }
}

/// Returns the effect of a mistake, with its channels, and advice on how to fix it.
fn effect_and_fix(mistake: &Mistake) -> [String; 2] {
    let misreading = mistake.misreading;
    let (effect, fix) = match (mistake.catalog_misreading(), misreading.change) {
        (None, Change::Edits([edit, others @ ..])) => {
            // Other edits are those of the other axis.
            let others = others.iter().map(|edit| edit.formula.stated().result);
            let others = others.map(|value| format!(", and {value} in the same way"));
            let others = others.collect::<Vec<_>>().concat();
            let (value, stated) = (edit.formula.stated().result, edit.stated_text());
            let computes = edit.edited_text();
            match edit.change {
                EditedForm::Table(_) => (
                    format!("maps {value} through {computes}"),
                    "compare the value in the example with the bytes that determine it".to_owned(),
                ),
                EditedForm::Expression(_) => (
                    format!(
                        "computes {value} as {computes} instead of {stated}{others}{}",
                        edit.explanations()
                    ),
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
    [effect + &mistake.channels.describe(), fix]
}
