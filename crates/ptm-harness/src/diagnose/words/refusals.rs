//! Describes legal files that the decoder refused or crashed on.

use super::{files_in_scope, share_text};
use crate::diagnose::diagnosis::{Category, CauseText, Diagnosis};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::groups::Group;
use crate::diagnose::rules;
use crate::diagnose::scope::shared_scope;
use crate::diagnose::tuning::{MIN_READ_FILES, MIN_SUPPORT, is_nearly_all};
use crate::diagnose::witness::Witness;
use ptm::Format;
use ptm_mistakes::Misreading;
use ptm_suite::cases::Expect;
use ptm_suite::kit::last_message::quote_last_message;

/// Describes a group of files without an image, which may include wrong images of files with the same property.
pub(in crate::diagnose) fn describe(witnesses: &[Witness], group: &Group) -> Diagnosis {
    let count = group.cases.len();
    if group.shared.is_some() {
        return describe_group(witnesses, group, None, fix(witnesses, &group.cases));
    }
    let files = if count == 1 {
        Some("a legal file; the cause is unknown".to_owned())
    } else if files_read(witnesses).len() < MIN_READ_FILES {
        Some(format!(
            "{count} legal files; the decoder reads so few other files that no distinguishing property can be found"
        ))
    } else {
        None
    };
    let fix = "start with the example, the first of these files".to_owned();
    describe_group(witnesses, group, files, fix)
}

/// Describes files without an image that a decoder with a certain mistake would also refuse, by a property if only they have one.
pub(in crate::diagnose) fn describe_failures(witnesses: &[Witness], cases: &[usize]) -> Diagnosis {
    let is_other = |w: &usize| witnesses[*w].case.expect == Expect::Decode && !cases.contains(w);
    let others: Vec<usize> = (0..witnesses.len()).filter(is_other).collect();
    let shared = shared_scope(witnesses, &Format::ALL, cases, &others, &[], false);
    let group = Group {
        cases: cases.to_vec(),
        shared: shared.filter(|shared| shared.cases.len() == cases.len()),
    };
    describe_group(witnesses, &group, None, fix(witnesses, cases))
}

/// Describes a group. `files` replaces the description of the files by their property or number.
fn describe_group(
    witnesses: &[Witness],
    group: &Group,
    files: Option<String>,
    fix: String,
) -> Diagnosis {
    let cases = &group.cases;
    let files = files.unwrap_or_else(|| match &group.shared {
        Some(shared) => files_in_scope(witnesses, shared),
        None => share_text(witnesses, cases),
    });
    let text = CauseText {
        effect: outcomes_text(witnesses, cases, &files),
        fix,
        example: example(witnesses, cases),
    };
    Diagnosis::from_description(Category::Refusal, witnesses, cases, text, group.clause())
}

/// Returns what the decoder does with these files, which `files` describes: "refuses every legal file …", or "refuses 12 and crashes
/// (exit status 1) on 3 of 15 legal files …".
fn outcomes_text(witnesses: &[Witness], cases: &[usize], files: &str) -> String {
    let modes = FailureMode::list_by_frequency(witnesses, cases);
    let is_image = |w: &&usize| FailureMode::new(&witnesses[**w]).is_none();
    let images = cases.iter().filter(is_image).count();
    if let ([mode], 0) = (&modes[..], images) {
        return format!("{mode} {files}");
    }
    let count = |mode: &FailureMode| mode.select(witnesses, cases).len();
    let mut outcomes: Vec<String> = (modes.iter())
        .map(|mode| format!("{mode} {}", count(mode)))
        .collect();
    if images > 0 {
        outcomes.push(format!("shows a wrong image for {images}"));
    }
    let last = outcomes.pop().unwrap_or_default();
    format!("{} and {last}: {files}", outcomes.join(", "))
}

/// Returns advice about legal files without an image.
fn fix(witnesses: &[Witness], cases: &[usize]) -> String {
    let read = "read these legal files, or exit with 69 for all files with a feature that the decoder lacks";
    // The advice is about the example.
    let Some(mode) = FailureMode::new(&witnesses[cases[0]]) else {
        return read.to_owned();
    };
    match (&mode, mode.refusal_status()) {
        (FailureMode::Unsupported, _) => {
            "read these legal files, too, or exit with 69 for all files with one of the features that the message names".to_owned()
        }
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
    }
}

/// Returns true if the decoder fails in the same way on more files, which share a property with nearly all of these.
pub(in crate::diagnose) fn is_part_of_a_larger_group(
    witnesses: &[Witness],
    cases: &[usize],
) -> bool {
    let read = files_read(witnesses);
    let failing: Vec<usize> = (0..witnesses.len())
        .filter(|&w| witnesses[w].failed && witnesses[w].case.expect == Expect::Decode)
        .collect();
    FailureMode::list_by_frequency(witnesses, cases)
        .iter()
        .any(|mode| {
            let group = mode.select(witnesses, &failing);
            let shared = shared_scope(witnesses, &Format::ALL, &group, &read, &[], true);
            shared.is_some_and(|shared| {
                let common = cases.iter().filter(|w| shared.cases.contains(w)).count();
                is_nearly_all(common, cases.len())
                    && shared.cases.len() >= cases.len() + MIN_SUPPORT
            })
        })
}

pub(super) fn reject_exit_hint(status: i32) -> String {
    format!("if this decoder refuses files with status {status}, use --reject-exit {status}")
}

/// Returns the legal files that the decoder reads, correctly or not. Files that fail in another way are not evidence.
pub(in crate::diagnose) fn files_read(witnesses: &[Witness]) -> Vec<usize> {
    let is_read = |w: &usize| witnesses[*w].is_image_of_legal_file();
    (0..witnesses.len()).filter(is_read).collect()
}

/// Returns the failure mode that all of these cases share, if any.
fn common_mode(witnesses: &[Witness], indices: &[usize]) -> Option<FailureMode> {
    let mode = FailureMode::new(&witnesses[*indices.first()?])?;
    (mode.select(witnesses, indices).len() == indices.len()).then_some(mode)
}

/// Returns true if this is a single file without an image, and the decoder fails in the same way on legal files in `left`.
pub(in crate::diagnose) fn is_single_among_others(
    witnesses: &[Witness],
    cases: &[usize],
    left: &[usize],
) -> bool {
    let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
    let left: Vec<usize> = left.iter().copied().filter(is_legal).collect();
    match cases {
        [only] => FailureMode::new(&witnesses[*only])
            .is_some_and(|mode| !mode.select(witnesses, &left).is_empty()),
        _ => false,
    }
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
    for group in &mut groups {
        rules::sort_smallest_first(witnesses, &mut group.cases);
    }
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
        Diagnosis::from_description(
            Category::Refusal,
            witnesses,
            &self.cases,
            text,
            Some("2.2/1"),
        )
        .with_equivalents(others)
    }
}

/// Describes the first of these failures: the reason for its case, and the last message on standard error.
pub(in crate::diagnose) fn example(witnesses: &[Witness], cases: &[usize]) -> String {
    let first = &witnesses[cases[0]];
    let because = first.case.because.trim_end_matches('.');
    let message = quote_last_message("; ", &first.observation.stderr);
    format!("for example {}: {because}{message}", first.case.id)
}
