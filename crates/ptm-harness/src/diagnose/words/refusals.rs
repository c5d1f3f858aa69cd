//! Describes legal files that the decoder refused or crashed on, by a property that these files share and no accepted file has.

use super::{files_in_scope, share_text};
use crate::diagnose::diagnosis::{Category, Cause, CauseText, Diagnosis};
use crate::diagnose::scope::{format_sets, shared_scope};
use crate::diagnose::tuning::{MIN_READ_FILES, MIN_SUPPORT, is_few, is_substantial};
use crate::diagnose::{failure_mode::FailureMode, witness::Witness};
use ptm::Format;
use ptm_mistakes::{Misreading, Symptom};
use ptm_suite::cases::Expect;
use ptm_suite::kit::last_message::quote_last_message;

/// Describes refusals by a property that the refused files share and no decoded file has. Removes these files from `left`.
pub fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    let read = files_read(witnesses);
    for mode in FailureMode::list_by_frequency(witnesses, left) {
        let mut open = mode.select(witnesses, left);
        // A property shared by a few of many files is a coincidence.
        let find_shared = |open: &[usize]| {
            format_sets(witnesses, open).iter().find_map(|formats| {
                let shared = shared_scope(witnesses, formats, open, &read, true)?;
                is_substantial(shared.cases.len(), open.len()).then_some(shared)
            })
        };
        while let Some(shared) = find_shared(&open) {
            open.retain(|w| !shared.cases.contains(w));
            left.retain(|w| !shared.cases.contains(w));
            let effect = format!("{mode} {}", files_in_scope(witnesses, &shared));
            let refusal = mode_diagnosis(witnesses, &shared.cases, &mode, effect);
            diagnoses.push(refusal.with_clause(shared.scope.clause()));
        }
    }
    diagnoses
}

/// Returns the diagnosis for files that fail in the same way.
fn mode_diagnosis(
    witnesses: &[Witness],
    indices: &[usize],
    mode: &FailureMode,
    effect: String,
) -> Diagnosis {
    let read = "read these legal files, or exit with 69 for all files of this kind";
    let fix = match (mode, mode.refusal_status()) {
        (FailureMode::TimesOut(_), _) => {
            "find out why these files take so long; if the decoder needs the time, raise the limit with --timeout".to_owned()
        }
        (FailureMode::MalformedFrame(_), _) => {
            "compare the output with docs/protocol.md".to_owned()
        }
        (_, Some(status)) => format!("{read}; {}", reject_exit_hint(status)),
        (FailureMode::Crashes(_), None) => {
            "run the example in a debugger; these files are legal, so the decoder must not crash"
                .to_owned()
        }
        _ => read.to_owned(),
    };
    let text = CauseText {
        effect,
        fix,
        example: example(witnesses, indices),
    };
    Diagnosis::from_description(Category::Refusal, witnesses, indices, text)
}

pub(super) fn reject_exit_hint(status: i32) -> String {
    format!("if this decoder refuses files with status {status}, use --reject-exit {status}")
}

/// Returns, for each failure mode, the failures that a single shared property explains.
pub fn shared_failures(witnesses: &[Witness], failing: &[usize]) -> Vec<Vec<usize>> {
    let read = files_read(witnesses);
    let explained = |mode: FailureMode| {
        let group = mode.select(witnesses, failing);
        shared_scope(witnesses, &Format::ALL, &group, &read, true).map(|shared| shared.cases)
    };
    FailureMode::list_by_frequency(witnesses, failing)
        .into_iter()
        .filter_map(explained)
        .collect()
}

/// Returns the legal files that the decoder reads, correctly or not. Files that fail in another way are not evidence.
fn files_read(witnesses: &[Witness]) -> Vec<usize> {
    let is_read = |w: &usize| witnesses[*w].is_image_of_legal_file();
    (0..witnesses.len()).filter(is_read).collect()
}

/// Returns the failure mode that all of these cases share, if any.
fn common_mode(witnesses: &[Witness], indices: &[usize]) -> Option<FailureMode> {
    let mode = FailureMode::new(&witnesses[*indices.first()?])?;
    (mode.select(witnesses, indices).len() == indices.len()).then_some(mode)
}

/// Formats whose legal files all fail in the same way, without an image.
pub(in crate::diagnose) struct WholeFormats {
    mode: FailureMode,
    formats: Vec<Format>,
    /// The legal files in these formats, and any other files in these formats that fail in the same way.
    pub cases: Vec<usize>,
}

/// Returns the formats whose legal files all fail in the same way, grouped by failure mode.
pub(in crate::diagnose) fn whole_formats(witnesses: &[Witness]) -> Vec<WholeFormats> {
    let mut groups: Vec<WholeFormats> = Vec::new();
    for format in Format::ALL {
        let of_format = |w: &usize| witnesses[*w].case.format() == format;
        let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
        let all: Vec<usize> = (0..witnesses.len()).filter(of_format).collect();
        let legal: Vec<usize> = all.iter().copied().filter(is_legal).collect();
        // Unsupported files are not witnesses, but they are also legal files. Inconclusive legal files are always refused.
        let is_whole = |witness: &Witness| {
            witness.failed && witness.legal_files == legal.len() + witness.inconclusive_files
        };
        if legal.len() < 2 || !legal.iter().all(|&w| is_whole(&witnesses[w])) {
            continue;
        }
        let Some(mode) = common_mode(witnesses, &legal) else {
            continue;
        };
        let same_mode = mode.select(witnesses, &all).into_iter();
        let indices = same_mode.filter(|&w| witnesses[w].failed);
        match groups.iter_mut().find(|group| group.mode == mode) {
            Some(group) => {
                group.formats.push(format);
                group.cases.extend(indices);
            }
            None => groups.push(WholeFormats {
                formats: vec![format],
                cases: indices.collect(),
                mode,
            }),
        }
    }
    groups.retain(|group| group.cases.len() >= MIN_SUPPORT);
    groups
}

impl WholeFormats {
    /// Describes the observed behavior, and lists the misreadings that would have the same effect.
    pub fn describe(&self, witnesses: &[Witness], others: Vec<&'static Misreading>) -> Diagnosis {
        let names = self.formats.iter().map(|format| format.short_name());
        let names: Vec<&str> = names.collect();
        let text = CauseText {
            effect: format!(
                "{} every legal file in format {}",
                self.mode,
                names.join(" or ")
            ),
            fix: "read these formats, or exit with 69 for all of their files".to_owned(),
            example: example(witnesses, &self.cases),
        };
        let others = match self.mode {
            FailureMode::Refuses | FailureMode::Unsupported => others,
            _ => Vec::new(),
        };
        Diagnosis::from_description(Category::Refusal, witnesses, &self.cases, text)
            .with_equivalents(others)
            .with_clause("2.2/1")
    }
}

/// Describes these files if all of them fail in the same way and no other legal file has their common format or property.
pub(in crate::diagnose) fn describe_observation(
    witnesses: &[Witness],
    indices: &[usize],
) -> Option<Diagnosis> {
    let mode = common_mode(witnesses, indices)?;
    let is_other = |w: &usize| witnesses[*w].case.expect == Expect::Decode && !indices.contains(w);
    let others: Vec<usize> = (0..witnesses.len()).filter(is_other).collect();
    let shared = shared_scope(witnesses, &Format::ALL, indices, &others, false)?;
    let effect = format!("{mode} {}", files_in_scope(witnesses, &shared));
    (shared.cases.len() == indices.len()).then(|| mode_diagnosis(witnesses, indices, &mode, effect))
}

/// Describes the failures on the legal files in `indices` if the evidence for the misreading is weak because few of the responses
/// are images. Returns `None` if the misreading predicts the refusals, and all misreadings in `others` have the same clause.
pub(in crate::diagnose) fn describe_non_images(
    witnesses: &[Witness],
    indices: &[usize],
    misreading: &Misreading,
    others: &[&Misreading],
) -> Option<Cause> {
    let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
    let indices: Vec<usize> = indices.iter().copied().filter(is_legal).collect();
    let is_refusal =
        |mode: &FailureMode| matches!(mode, FailureMode::Refuses | FailureMode::Unsupported);
    let modes = FailureMode::list_by_frequency(witnesses, &indices);
    let images = indices
        .iter()
        .filter(|&&w| FailureMode::new(&witnesses[w]).is_none());
    let is_predicted = modes.iter().all(is_refusal) && misreading.symptom == Symptom::Refusals;
    let is_unique = others.iter().all(|other| other.clause == misreading.clause);
    if indices.is_empty() || !is_few(images.count(), indices.len()) || is_predicted && is_unique {
        return None;
    }
    let mode = modes.first()?;
    let effect = outcomes_text(witnesses, &indices, &modes);
    let refusal = mode_diagnosis(witnesses, &indices, mode, effect);
    Some(match is_unique {
        true => refusal.with_clause(misreading.clause).cause,
        false => refusal.cause,
    })
}

/// Returns a list of outcomes such as "crashes (exit status 1) on 12 legal files, and refuses 1 legal file".
fn outcomes_text(witnesses: &[Witness], indices: &[usize], modes: &[FailureMode]) -> String {
    let files = |count: usize| match count {
        1 => "1 legal file".to_owned(),
        count => format!("{count} legal files"),
    };
    let outcome =
        |mode: &FailureMode| format!("{mode} {}", files(mode.select(witnesses, indices).len()));
    let mut outcomes: Vec<String> = modes.iter().map(outcome).collect();
    let is_image = |w: &&usize| FailureMode::new(&witnesses[**w]).is_none();
    match indices.iter().filter(is_image).count() {
        0 => {}
        count => outcomes.push(format!("shows a wrong image for {}", files(count))),
    }
    outcomes.join(", and ")
}

/// Describes refusals that no property explains, and removes them from `left`.
pub(in crate::diagnose) fn describe_unexplained(
    witnesses: &[Witness],
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    for mode in FailureMode::list_by_frequency(witnesses, left) {
        let indices = mode.select(witnesses, left);
        left.retain(|w| !indices.contains(w));
        let effect = match indices.len() {
            1 => format!("{mode} a legal file; the cause is unknown"),
            count if files_read(witnesses).len() < MIN_READ_FILES => format!(
                "{mode} {count} legal files; the decoder reads so few other files that no distinguishing property can be found"
            ),
            _ => format!("{mode} {}", share_text(witnesses, &indices)),
        };
        let text = CauseText {
            effect,
            fix: "start with the example, the smallest of these files".to_owned(),
            example: example(witnesses, &indices),
        };
        diagnoses.push(Diagnosis::from_description(
            Category::Refusal,
            witnesses,
            &indices,
            text,
        ));
    }
    diagnoses
}

/// Describes the smallest of these files: the reason for its case, and the last message on standard error.
pub(in crate::diagnose) fn example(witnesses: &[Witness], indices: &[usize]) -> String {
    let smallest = indices
        .iter()
        .map(|&w| &witnesses[w])
        .min_by_key(|witness| witness.built.file.len())
        .expect("a diagnosis explains at least one case");
    let stderr = &smallest.observation.stderr;
    let because = smallest.case.because.trim_end_matches('.');
    let message = quote_last_message("; ", stderr);
    format!("for example {}: {because}{message}", smallest.case.id)
}
