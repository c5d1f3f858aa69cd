//! Describes violations on files that must or may be refused: crashes, exceeded limits, malformed frames and "unsupported" responses.

use super::{acceptances::fault_text, list_first, refusals::example, refusals::reject_exit_hint};
use crate::diagnose::diagnosis::{Category, CauseText, Diagnosis};
use crate::diagnose::{failure_mode::FailureMode, rules, witness::Witness};
use ptm_suite::cases::Expect;
use ptm_suite::verdicts::observation::Response;

/// Describes violations on files that need not be decoded, grouped by failure mode. Removes these files from `left`.
pub fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
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
        let mut group = mode.select(witnesses, &indices);
        rules::sort_smallest_first(witnesses, &mut group);
        let may_be_read = |w: &usize| witnesses[*w].case.expect.is_optional();
        let text = CauseText {
            effect: format!("{mode} {}", describe_files(witnesses, &group, refuses)),
            fix: fix(&mode, group.iter().all(may_be_read)),
            example: example(witnesses, &group),
        };
        Diagnosis::from_description(Category::Violation, witnesses, &group, text, None)
    };
    FailureMode::list_by_frequency(witnesses, &indices)
        .into_iter()
        .map(diagnosis)
        .collect()
}

fn describe_files(witnesses: &[Witness], group: &[usize], refuses: bool) -> String {
    // A lenient file without a fault is of the kind that its ruling is about.
    let fault = |&w: &usize| {
        let case = witnesses[w].case;
        let is_kind = case.expect.is_optional() && case.damage().is_none();
        match &case.ruling {
            Some(ruling) if is_kind => format!("ruling {ruling}"),
            _ => fault_text(case).to_owned(),
        }
    };
    let mut faults: Vec<String> = group.iter().map(fault).collect();
    faults.sort_unstable();
    faults.dedup();
    let faults: Vec<&str> = faults.iter().map(String::as_str).collect();
    let others = if refuses { "; it refuses others" } else { "" };
    let files = if group.len() == 1 { "file" } else { "files" };
    format!(
        "{} {files} that must or may be refused ({}){others}",
        group.len(),
        list_first(&faults, "kind")
    )
}

fn fix(mode: &FailureMode, may_be_read: bool) -> String {
    let advice = match may_be_read {
        true => "show an image or exit with status 65",
        false => "exit with status 65",
    };
    match (mode, mode.refusal_status()) {
        (FailureMode::Unsupported, _) => {
            "exit with 65 for a malformed file of a kind that the decoder reads; 69 means that the decoder reads no files of this kind".to_owned()
        }
        (FailureMode::MalformedFrame(_), _) => {
            format!("{advice}; a refusal writes nothing to standard output")
        }
        (_, Some(status)) => format!("{advice}; {}", reject_exit_hint(status)),
        (_, None) => format!("detect the fault, and {advice}"),
    }
}
