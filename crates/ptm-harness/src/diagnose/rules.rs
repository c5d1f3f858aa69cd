//! The rules that keep the sentences of a diagnosis true. `docs/diagnosis.md` explains them to users.

use std::collections::BTreeSet;

use super::failure_mode::{FailureMode, message_form};
use super::mistake::Mistake;
use super::scope::{FileScope, files_of, own_formats};
use super::search::{Effect, MistakeId, MistakeSet, Search, without_id};
use super::tuning::{MIN_SUPPORT, MIN_TWICE_LIMITED_IMAGES, is_most, is_nearly_all, is_third};
use super::witness::{Agreement, Witness};
use super::words::refusals::files_read;
use ptm_mistakes::formula::{EditedForm, Formula};
use ptm_mistakes::{Change, Misreading, Symptom};
use ptm_suite::cases::{Case, Expect};
use ptm_suite::protocol::frame::{Answer, ViewKind};
use ptm_suite::verdicts::observation::Response;

/// *No response contradicts a named mistake.*
///
/// A response contradicts a mistake if it agrees with a decoder without the mistake rather than with one that makes it: the mistake
/// turns a correct or reproduced response into another one, or a wrong image has the values of a decoder without the mistake at more
/// samples than those of a decoder with it, by more than half of the samples that the mistake changes.
pub(super) fn contradicts(without: Effect, with: Effect) -> bool {
    if with.answer == without.answer || with.agreement.explains() {
        return false;
    }
    let is_contradiction = |effect: Effect| effect.agreement == Agreement::Contradiction;
    let changed = with.changed_samples.max(without.changed_samples);
    let lost = without.equal_samples.saturating_sub(with.equal_samples);
    is_contradiction(with) && !is_contradiction(without)
        || without.agreement.explains()
        || changed >= MIN_SUPPORT && is_most(lost, changed)
}

/// *An edit, or a mistake in some formats only, is named only if it explains more of the failures than a description of the same
/// files would.*
///
/// It must reproduce at least [`MIN_SUPPORT`] images, and nearly all images that it changes of the first view in which it changes
/// any. If it is restricted to some formats, it must reproduce most of the wrong images in the same views of all formats; otherwise,
/// it may fit what another mistake left over. `images` are the wrong images that `set` does not reproduce, and `explained` those of
/// them that the mistake reproduces.
pub(super) fn explains_more_than_a_description(
    search: &Search,
    set: &MistakeSet,
    mistake: &Mistake,
    explained: &[usize],
    images: &[usize],
) -> bool {
    let view = |w: usize| search.witnesses[w].observation.view.kind();
    // A learned table has already been compared with all images of stored values.
    let is_table = matches!(
        mistake.misreading.change,
        Change::Edits([edit]) if matches!(edit.change, EditedForm::Table(_))
    );
    let explains_first_view = || {
        // A wrong image in which the position is outside the data supports nothing and refutes nothing.
        let is_changed = |w: &&usize| {
            let agreement = || search.changed_agreement_with(**w, set, mistake);
            let can_contradict =
                |agreement| search.witnesses[**w].can_contradict(mistake, agreement);
            explained.contains(*w) || agreement().is_some_and(can_contradict)
        };
        let changed: Vec<ViewKind> = images.iter().filter(is_changed).map(|&w| view(w)).collect();
        let first = ViewKind::ALL.into_iter().find(|one| changed.contains(one));
        first.is_some_and(|first| {
            let explained = explained.iter().filter(|&&w| view(w) == first).count();
            let changed = changed.iter().filter(|&&one| one == first).count();
            is_nearly_all(explained, changed)
        })
    };
    let views: BTreeSet<ViewKind> = explained.iter().map(|&w| view(w)).collect();
    let everywhere = Mistake::unrestricted(mistake.misreading);
    let is_similar = |w: &&usize| {
        views.contains(&view(**w))
            && search.witnesses[**w].wrong_image().is_some()
            && search.witnesses[**w].can_affect(&everywhere)
    };
    let all = || search.failing().iter().filter(is_similar).count();
    explained.len() >= MIN_SUPPORT
        && (is_table || explains_first_view())
        && (mistake.formats.is_none() || is_most(explained.len(), all()))
}

/// *A mistake explains most of the failures that it changes, and a third of the wrong images of its formats and views.*
///
/// Failures in later views do not count if it explains nearly all of many failures that it changes in the first view.
/// `explained` are the failures that `set` reproduces because of the mistake, and `left` those that it does not reproduce.
pub(super) fn explains_most_of_what_it_changes(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    explained: &[usize],
    left: &[usize],
) -> bool {
    let without = without_id(set, id);
    let is_changed = |w: &usize| search.answers_differ(*w, set, &without);
    let mut changed: Vec<usize> = left.iter().copied().filter(is_changed).collect();
    let view = |w: usize| search.witnesses[w].observation.view.kind();
    let first = changed.iter().chain(explained).map(|&w| view(w)).min();
    let in_first_view = |cases: &[usize]| cases.iter().filter(|&&w| Some(view(w)) == first).count();
    let [shown, missed] = [explained, &changed].map(in_first_view);
    if shown >= MIN_TWICE_LIMITED_IMAGES && is_nearly_all(shown, shown + missed) {
        // A mistake in a later step, which need not be known, changes the images in later views.
        changed.retain(|&w| Some(view(w)) == first);
    }
    let kind = |w: usize| {
        let witness = &search.witnesses[w];
        (witness.case.format(), witness.observation.view.kind())
    };
    let kinds: BTreeSet<_> = explained.iter().map(|&w| kind(w)).collect();
    let is_image = |w: &usize| search.witnesses[*w].is_telling_image();
    let images = explained.iter().filter(|w| is_image(w)).count();
    let is_open = |w: &&usize| is_image(w) && kinds.contains(&kind(**w));
    let open = left.iter().filter(is_open).count();
    changed.len() <= explained.len() && (images == 0 || is_third(images, images + open))
}

/// *A failure that another mistake of the set reproduces, too, does not show a mistake.*
pub(super) fn is_shown_by_own_failures(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    explained: &[usize],
) -> bool {
    let others = without_id(set, id);
    let is_own = |w: &usize| others.iter().all(|&other| !search.explains(*w, &[other]));
    let own: Vec<usize> = explained.iter().copied().filter(is_own).collect();
    !is_shown(search, set, id, explained) || is_shown(search, set, id, &own)
}

/// Returns true if the responses show how the decoder computes. An edit always reproduces images.
pub(super) fn is_shown(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    explained: &[usize],
) -> bool {
    let misreading = search.mistakes[id].unrestricted_misreading();
    misreading
        .is_none_or(|misreading| is_shown_by_responses(search, set, id, misreading, explained))
}

/// *A mechanism is named only if whole images equal its output.*
///
/// From refusals follows only an observation, and so it does from acceptances: the image of a malformed file that is that of its
/// legal twin does not show how the fault was read. This is the image of a decoder with the other mistakes in `set`. A misreading
/// that consists of refusals or acceptances is itself an observation.
pub(super) fn is_shown_by_responses(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    misreading: &Misreading,
    explained: &[usize],
) -> bool {
    let others = search.mistakes_in(&without_id(set, id));
    let agreement = |w: usize| match search.agreement(w, set) {
        Agreement::Image if search.witnesses[w].has_image_of_twin(&others) => Agreement::TwinImage,
        other => other,
    };
    let are_all = |expected: Agreement| explained.iter().all(|&w| agreement(w) == expected);
    match misreading.symptom {
        Symptom::Refusals if are_all(Agreement::Refusal) => true,
        Symptom::Acceptances if are_all(Agreement::TwinImage) => true,
        _ => explained.iter().any(|&w| agreement(w) == Agreement::Image),
    }
}

/// *A mistake that is shown by refusals alone refuses no file of which the decoder shows an image.*
///
/// A decoder with an edited position may also read outside the data without noticing, but then its images show the mistake.
pub(super) fn refuses_no_image(search: &Search, id: MistakeId) -> bool {
    let mistake = &search.mistakes[id];
    let is_refused = |witness: &Witness| {
        matches!(witness.observation.response, Response::Image { .. })
            && witness.expected != Answer::Rejected
            && witness.can_affect(mistake)
            && *witness.answer(&[mistake]) == Answer::Rejected
            && (witness.answer_in_other_reading(&[mistake]))
                .is_none_or(|answer| answer == Answer::Rejected)
    };
    !search.witnesses.iter().any(is_refused)
}

/// *A decoder that refuses an index past the table does not also read there.*
///
/// An edit of the index that reproduces refusals is not shown by images in which the index is past the table.
pub(super) fn checks_all_indices(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    explained: &[usize],
) -> bool {
    let formulas = search.mistakes[id].misreading.formulas();
    let is_refused = |&w: &usize| search.agreement(w, set) == Agreement::Refusal;
    !formulas.contains(&Formula::Index)
        || !explained.iter().any(is_refused)
        || refuses_no_image(search, id)
}

/// *An exceeded time limit is not listed under wrong values.*
///
/// Takes the exceeded time limits out of `explained` if images show the mistake: a decoder that computes other values than the
/// reference, and finds them outside the data, ends at once.
pub(super) fn take_exceeded_limits(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    explained: &mut Vec<usize>,
) -> Vec<usize> {
    let is_late = |w: usize| {
        let response = &search.witnesses[w].observation.response;
        response.time_limit().is_some()
    };
    let is_by_images = explained.iter().any(|&w| is_late(w))
        && search.mistakes[id].misreading.symptom == Symptom::Values
        && is_shown(search, set, id, explained);
    explained
        .extract_if(.., |w| is_by_images && is_late(*w))
        .collect()
}

/// *One mistake is one cause.*
///
/// Counts the responses in `left` that are failures of the same kind as one in `cases`, which have no image: the same format, the
/// same failure mode, and a last line on standard error of the same form. A misreading that would only refuse the files in `cases`
/// does not show that these failures are separate.
pub(super) fn count_failures_of_the_same_kind(
    witnesses: &[Witness],
    cases: &[usize],
    left: &[usize],
) -> usize {
    let is_same_kind = |&a: &usize, &b: &usize| {
        let [a, b] = [&witnesses[a], &witnesses[b]];
        let form = |witness: &Witness| message_form(&witness.observation.stderr);
        a.case.format() == b.case.format()
            && a.case.expect == b.case.expect
            && FailureMode::new(a).is_some_and(|mode| FailureMode::new(b) == Some(mode))
            && form(a) == form(b)
    };
    let has_kind = |other: &&usize| cases.iter().any(|case| is_same_kind(case, other));
    left.iter().filter(has_kind).count()
}

/// *A refusal is explained by what separates the file from those that the decoder reads.*
///
/// Counts the images of legal files that have the formats of `cases`. If the decoder refuses more of the files that a misreading
/// does not refuse than it reads, the misreading does not separate the two.
pub(super) fn count_files_read(witnesses: &[Witness], cases: &[usize]) -> usize {
    let formats = own_formats(witnesses, cases, &[]);
    files_of(witnesses, &files_read(witnesses), &formats).len()
}

/// *A property is named only if it separates files.*
///
/// If the decoder fails, for unknown reasons, on more files without the property than it reads (`others`), the property describes
/// the few files that it reads rather than the mistake. `failures` contains the group and all other failures without a known cause.
pub(super) fn separates(
    witnesses: &[Witness],
    scope: &FileScope,
    failures: [&[usize]; 2],
    others: &[usize],
) -> bool {
    let [group, open] = failures;
    let more = open.iter().filter(|w| !group.contains(w));
    let is_outside = |w: &&usize| {
        let witness = &witnesses[**w];
        witness.case.expect == Expect::Decode && !scope.contains(witness)
    };
    let failing = group.iter().chain(more).filter(is_outside).count();
    matches!(scope, FileScope::Formats(_)) || failing <= others.len()
}

/// *"Would look the same" is said only after the outputs for all these files have been compared.*
///
/// Returns true if decoders with `other` and with `id` give the same answers to the cases in `explained`, whole images included.
pub(super) fn looks_the_same(
    search: &Search,
    set: &MistakeSet,
    [id, other]: [MistakeId; 2],
    explained: &[usize],
) -> bool {
    let rest = without_id(set, id);
    let [with, instead] = [id, other].map(|id| [&rest[..], &[id]].concat());
    let mut explained = explained.iter();
    explained.all(|&w| !search.answers_differ(w, &with, &instead))
}

/// *The example is the first failure below the cause.*
///
/// Sorts failures for a report: stored and final values before colors, and small files first.
pub(super) fn sort_smallest_first(witnesses: &[Witness], cases: &mut [usize]) {
    cases.sort_by_key(|&w| (witnesses[w].is_rgb(), witnesses[w].built.file.len()));
}

/// *The clause of a description is one that all its files test.*
///
/// Returns `preferred` if all of these cases test it, or else the first clause that all of them test, if any.
pub(super) fn common_clause<'a>(cases: &[&'a Case], preferred: Option<&'a str>) -> Option<&'a str> {
    let clauses = |case: &'a Case| case.clauses.iter().map(String::as_str);
    let is_common = |clause: &&str| {
        let tests = |case| clauses(case).any(|other| other == *clause);
        cases.iter().copied().all(tests)
    };
    let mut first = clauses(cases.first()?);
    preferred
        .filter(is_common)
        .or_else(|| first.find(is_common))
}
