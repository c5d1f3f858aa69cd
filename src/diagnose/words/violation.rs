//! Describes violations: files that must or may be refused, for which the response was a crash, a hang, a malformed
//! frame or "unsupported".

use super::acceptances::fault_text;
use super::list_first;
use super::refusals::example;
use crate::diagnose::diagnosis::{Category, CauseWords, Diagnosis};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::witness::Witness;
use crate::session::observation::Response;
use crate::suite::cases::Expect;

/// Describes violations on files that need not be decoded, by failure mode. Removes them from `left`.
pub(in crate::diagnose) fn describe(
    witnesses: &[Witness],
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let refusable = |w: usize| witnesses[w].case.expect != Expect::Decode;
    let violates = |w: &usize| {
        let response = &witnesses[*w].observation.response;
        refusable(*w) && matches!(response, Response::Violation(_) | Response::Unsupported)
    };
    let indices: Vec<usize> = left.iter().copied().filter(violates).collect();
    left.retain(|w| !indices.contains(w));
    let refuses = (0..witnesses.len())
        .any(|w| refusable(w) && matches!(witnesses[w].observation.response, Response::Rejected));
    let diagnosis = |mode: FailureMode| {
        let these = mode.select(witnesses, &indices);
        let expect = |w: &usize| witnesses[*w].case.expect;
        let may_be_read = |w: &usize| {
            matches!(
                expect(w),
                Expect::Lenient | Expect::Robust | Expect::Spelling
            )
        };
        let words = CauseWords {
            effect: format!("{mode} {}", describe_files(witnesses, &these, refuses)),
            fix: fix(&mode, these.iter().all(may_be_read)),
            example: example(witnesses, &these),
        };
        Diagnosis::from_description(Category::Violation, witnesses, &these, words)
    };
    FailureMode::list_by_frequency(witnesses, &indices)
        .into_iter()
        .map(diagnosis)
        .collect()
}

/// Describes the files by their damages.
fn describe_files(witnesses: &[Witness], these: &[usize], refuses: bool) -> String {
    let damages = these.iter().map(|&w| fault_text(witnesses[w].case));
    let mut damages: Vec<&str> = damages.collect();
    damages.sort_unstable();
    damages.dedup();
    let others = if refuses { "; it refuses others" } else { "" };
    let files = if these.len() == 1 { "file" } else { "files" };
    format!(
        "{} {files} that must or may be refused ({}){others}",
        these.len(),
        list_first(&damages, "kind")
    )
}

/// Returns the advice for a failure mode.
fn fix(mode: &FailureMode, may_be_read: bool) -> String {
    let end = match may_be_read {
        true => "show an image or exit with status 65",
        false => "exit with status 65",
    };
    if *mode == FailureMode::Unsupported {
        return "exit with 65 for a malformed file of a kind that the decoder reads; 69 means that the decoder reads no files of this kind"
            .to_owned();
    }
    let status = match mode {
        FailureMode::Crashes(how) => how.strip_prefix("exit status "),
        _ => None,
    };
    match status {
        // These are the statuses of panics in Rust, of shells and of signals. No decoder uses them to refuse files.
        Some(status) if !matches!(status, "101" | "126" | "127" | "134" | "139") => format!(
            "{end}; if this decoder refuses files with status {status}, use --reject-exit {status}"
        ),
        _ => format!("detect the fault, and {end}"),
    }
}
