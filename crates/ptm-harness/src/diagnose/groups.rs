//! Groups failures that no mistake explains by what the files of a group share and no other file has.

use std::collections::BTreeMap;

use super::failure_mode::{FailureMode, message_form};
use super::image_pair::image_pair;
use super::place::{Step, is_rearranged};
use super::properties::VIEW_PROPERTIES;
use super::rules;
use super::scope::{FileScope, SharedScope, common_property, format_sets, shared_scope};
use super::search::{MistakeSet, Search};
use super::tuning::{is_few, is_most, is_substantial};
use super::witness::Witness;
use ptm_suite::cases::Expect;

/// Failures with the same cause, sorted with the smallest file first.
pub(super) struct Group {
    pub cases: Vec<usize>,
    /// What the files share, if it is known.
    pub shared: Option<SharedScope>,
}

impl Group {
    fn new(witnesses: &[Witness], mut cases: Vec<usize>, shared: Option<SharedScope>) -> Group {
        rules::sort_smallest_first(witnesses, &mut cases);
        Group { cases, shared }
    }

    /// Returns true if the file has the property that the files share.
    fn contains(&self, witness: &Witness) -> bool {
        let shared = self.shared.as_ref();
        shared.is_some_and(|shared| shared.is_property() && shared.contains(witness))
    }

    /// Returns the clause about the property that the files share.
    pub fn clause(&self) -> Option<&'static str> {
        self.shared
            .as_ref()
            .and_then(|shared| shared.scope.clause())
    }
}

/// Groups legal files without an image, and takes them from `left`.
///
/// A property is searched among files with the same form of the last line on standard error. Files with the same property are in one
/// group even if the decoder refuses some, crashes on some and misreads others.
pub(super) fn group_stops(search: &Search, left: &mut Vec<usize>) -> Vec<Group> {
    let witnesses = search.witnesses;
    let is_stop = |w: &usize| {
        witnesses[*w].case.expect == Expect::Decode && FailureMode::new(&witnesses[*w]).is_some()
    };
    let is_image = |w: &usize| witnesses[*w].is_permitted_image();
    let all: Vec<usize> = (0..witnesses.len()).filter(is_image).collect();
    // A wrong image with an unknown cause may have the same cause as the files without an image.
    let known: Vec<usize> = all.iter().copied().filter(|w| !left.contains(w)).collect();
    let mut by_message: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for w in left.iter().copied().filter(is_stop) {
        let message = message_form(&witnesses[w].observation.stderr);
        by_message.entry(message).or_default().push(w);
    }
    join_unknown_messages(witnesses, &mut by_message);
    left.retain(|w| !is_stop(w));
    let mut groups: Vec<Group> = Vec::new();
    let mut rest: Vec<(String, Vec<usize>)> = Vec::new();
    // Failures without a message come last.
    let unknown = by_message.remove_entry("");
    for (message, mut open) in by_message.into_iter().chain(unknown) {
        if message.is_empty() {
            for group in &mut groups {
                let is_inside = |w: &mut usize| group.contains(&witnesses[*w]);
                let cases: Vec<usize> = open.extract_if(.., is_inside).collect();
                extend(witnesses, group, cases);
            }
        }
        for read in [&all, &known] {
            let is_all = read.len() == all.len();
            while let Some(mut shared) =
                stop_scope(search, &open, read, if is_all { &[] } else { left })
            {
                // That all images of a format are also wrong connects them with nothing.
                if !shared.is_property() && !is_all {
                    break;
                }
                open.retain(|w| !shared.cases.contains(w));
                let mut cases = shared.cases.clone();
                // Wrong images of files in the scope, and failures of those that need not be decoded, belong to the group.
                let is_inside = |w: &&usize| {
                    let witness = &witnesses[**w];
                    !witness.case.expect.is_refusal() && shared.contains(witness)
                };
                cases.extend(left.iter().filter(is_inside));
                left.retain(|w| !cases.contains(w));
                shared.cases.clone_from(&cases);
                let group = Group::new(witnesses, cases, Some(shared));
                join(witnesses, &mut groups, group);
            }
        }
        if !open.is_empty() {
            rest.push((message, open));
        }
    }
    for (message, open) in rest {
        if message.is_empty() {
            for mode in FailureMode::list_by_frequency(witnesses, &open) {
                groups.push(Group::new(witnesses, mode.select(witnesses, &open), None));
            }
        } else {
            groups.push(Group::new(witnesses, open, None));
        }
    }
    groups
}

/// Joins failures without a message to the others if all have the same failure mode and all messages the same form. The messages of
/// a decoder in serve mode are known for few of its failures.
fn join_unknown_messages(witnesses: &[Witness], by_message: &mut BTreeMap<String, Vec<usize>>) {
    let mut modes = by_message
        .values()
        .flatten()
        .map(|&w| FailureMode::new(&witnesses[w]));
    let first = modes.next();
    if by_message.len() == 2 && modes.all(|mode| Some(mode) == first) {
        let unknown = by_message.remove("").unwrap_or_default();
        for cases in by_message.values_mut() {
            cases.extend(&unknown);
        }
    }
}

/// Returns what a substantial part of the files without an image share and no file in `read` has. Most of them must share a view,
/// because few decoders open a file only for some views. `images` are wrong images with an unknown cause.
fn stop_scope(
    search: &Search,
    open: &[usize],
    read: &[usize],
    images: &[usize],
) -> Option<SharedScope> {
    let witnesses = search.witnesses;
    if search.is_arbitrary {
        return None;
    }
    let sets = format_sets(witnesses, open);
    sets.iter().find_map(|formats| {
        let scope = |with_view| shared_scope(witnesses, formats, open, read, images, with_view);
        let is_view = |shared: &SharedScope| matches!(shared.scope, FileScope::Property(index, _) if index < VIEW_PROPERTIES);
        let is_most = |shared: &SharedScope| is_most(shared.cases.len(), open.len());
        let shared = scope(true).filter(|shared| !is_view(shared) || is_most(shared));
        let shared = shared.or_else(|| scope(false))?;
        // A property shared by a few of many files is a coincidence.
        is_substantial(shared.cases.len(), open.len()).then_some(shared)
    })
}

/// Groups wrong images. Images that first differ in different steps are in different groups.
pub(super) fn group_images(
    search: &Search,
    set: &MistakeSet,
    steps: &[(usize, Step)],
) -> Vec<(Step, Group)> {
    let witnesses = search.witnesses;
    // A correct or reproduced image of a file with a property contradicts it. A file without an image is no evidence.
    let is_known = |w: &usize| {
        let witness = &witnesses[*w];
        witness.is_permitted_image() && (!witness.failed || search.agreement(*w, set).explains())
    };
    let known: Vec<usize> = (0..witnesses.len()).filter(is_known).collect();
    let mut by_step: BTreeMap<Step, Vec<usize>> = BTreeMap::new();
    for &(w, step) in steps {
        by_step.entry(step).or_default().push(w);
    }
    let mut groups: Vec<(Step, Group)> = Vec::new();
    while let Some((step, mut open)) = by_step.pop_first() {
        let mut parts: Vec<Group> = Vec::new();
        for formats in format_sets(witnesses, &open) {
            let Some(shared) = image_scope(search, &formats, &open, &known, steps) else {
                continue;
            };
            open.retain(|w| !shared.cases.contains(w));
            let group = Group::new(witnesses, shared.cases.clone(), Some(shared));
            join(witnesses, &mut parts, group);
        }
        let is_coded = |w: &usize| witnesses[*w].case.format().coding().is_some();
        let (coded, plain): (Vec<usize>, Vec<usize>) = open.into_iter().partition(is_coded);
        // The files with compressed planes are a group of their own if they have something in common.
        let rest = match common_property(witnesses, &coded) {
            Some(_) => vec![coded, plain],
            None => vec![[coded, plain].concat()],
        };
        for cases in rest.into_iter().filter(|cases| !cases.is_empty()) {
            parts.push(Group::new(witnesses, cases, None));
        }
        // If other causes have all earlier values, images show wrong colors only.
        for group in parts.extract_if(.., |group| shows_only_colors(search, step, &group.cases)) {
            by_step.entry(Step::Color).or_default().extend(group.cases);
        }
        // Files with the same property belong to the group that differs in the earliest step.
        for part in parts {
            let is_property =
                |group: &Group| group.shared.as_ref().is_some_and(SharedScope::is_property);
            let same = |(_, group): &&mut (Step, Group)| has_same_scope(group, &part);
            match groups.iter_mut().find(same) {
                Some((_, group)) if is_property(&part) => extend(witnesses, group, part.cases),
                _ => groups.push((step, part)),
            }
        }
    }
    groups
}

/// Returns true if these are images of colors that do not show that values differ in an earlier step.
fn shows_only_colors(search: &Search, step: Step, cases: &[usize]) -> bool {
    let shows_step = |&w: &usize| {
        let is_moved = || image_pair(search, &[], w).is_some_and(|pair| is_rearranged(&pair));
        !search.witnesses[w].is_rgb() || step == Step::Rearranged && is_moved()
    };
    (Step::Rearranged..Step::Color).contains(&step) && !cases.iter().any(shows_step)
}

/// Returns what most of these wrong images share and no known image has.
fn image_scope(
    search: &Search,
    formats: &[ptm::Format],
    open: &[usize],
    known: &[usize],
    steps: &[(usize, Step)],
) -> Option<SharedScope> {
    let witnesses = search.witnesses;
    let format = |w: usize| witnesses[w].case.format();
    // If nearly all failures of these formats are explained, the rest nearly always share some property by chance.
    let is_explained = |w: &&usize| {
        witnesses[**w].failed && open.iter().any(|other| format(*other) == format(**w))
    };
    let is_rest = is_few(open.len(), known.iter().filter(is_explained).count());
    if open.is_empty() || search.is_arbitrary || is_rest {
        return None;
    }
    let images: Vec<usize> = steps.iter().map(|&(w, _)| w).collect();
    let shared = shared_scope(witnesses, formats, open, known, &images, false)?;
    (is_most(shared.cases.len(), open.len()) && shared.is_prevalent(witnesses)).then_some(shared)
}

/// Adds a group to a list, or its cases to a group whose files share the same property in other formats.
fn join(witnesses: &[Witness], groups: &mut Vec<Group>, new: Group) {
    match groups.iter_mut().find(|group| has_same_scope(group, &new)) {
        Some(group) => {
            if let (Some(shared), Some(more)) = (&mut group.shared, new.shared) {
                shared.add_formats(&more);
            }
            extend(witnesses, group, new.cases);
        }
        None => groups.push(new),
    }
}

fn extend(witnesses: &[Witness], group: &mut Group, cases: Vec<usize>) {
    group.cases.extend(cases);
    rules::sort_smallest_first(witnesses, &mut group.cases);
    if let Some(shared) = &mut group.shared {
        shared.cases.clone_from(&group.cases);
    }
}

fn has_same_scope(a: &Group, b: &Group) -> bool {
    match (&a.shared, &b.shared) {
        (Some(a), Some(b)) => match (&a.scope, &b.scope) {
            (FileScope::Formats(_), FileScope::Formats(_)) => true,
            (a, b) => a == b,
        },
        _ => false,
    }
}
