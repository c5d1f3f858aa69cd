//! Files that must or may be refused, and that ended in a crash, a hang, a malformed frame or "unsupported" instead.

use super::refusals::example;
use super::{NAMED, first_of};
use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::witness::Witness;
use crate::session::observation::Response;
use crate::suite::cases::Expect;

/// Violations on files that need not be read, mode by mode. They are taken out of `left`.
pub(in crate::diagnose) fn describe(
    witnesses: &[Witness],
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let refusable = |w: usize| witnesses[w].case.expect != Expect::Decode;
    let violates = |w: &usize| {
        let response = &witnesses[*w].observation.response;
        refusable(*w) && matches!(response, Response::Violation(_) | Response::Unsupported)
    };
    let of: Vec<usize> = left.iter().copied().filter(violates).collect();
    left.retain(|w| !of.contains(w));
    let refuses = (0..witnesses.len())
        .any(|w| refusable(w) && matches!(witnesses[w].observation.response, Response::Rejected));
    let diagnosis = |mode: FailureMode| {
        let these = mode.select(witnesses, &of);
        let expect = |w: &usize| witnesses[*w].case.expect;
        let may_be_read = |w: &usize| matches!(expect(w), Expect::Lenient | Expect::Spelling);
        let words = Words {
            effect: format!("{mode} {}", files(witnesses, &these, refuses)),
            fix: fix(&mode, these.iter().all(may_be_read)),
            example: example(witnesses, &these),
        };
        Diagnosis::described(Category::Violation, witnesses, &these, words)
    };
    FailureMode::among(witnesses, &of)
        .into_iter()
        .map(diagnosis)
        .collect()
}

/// Which files they are: by their damages, where those are few.
fn files(witnesses: &[Witness], these: &[usize], refuses: bool) -> String {
    let mut damages: Vec<&str> = these
        .iter()
        .map(|&w| {
            let case = witnesses[w].case;
            case.damage()
                .map_or(case.because.trim_end_matches('.'), |damage| &damage.effect)
        })
        .collect();
    damages.sort_unstable();
    damages.dedup();
    if damages.len() <= NAMED {
        return format!("files that need not be read: {}", damages.join("; "));
    }
    let others = if refuses { "; others it refuses" } else { "" };
    format!(
        "{} files that must or may be refused ({}){others}",
        these.len(),
        first_of(&damages, "kind")
    )
}

fn fix(mode: &FailureMode, may_be_read: bool) -> String {
    let end = match may_be_read {
        true => "end with a picture or with exit status 65",
        false => "end with exit status 65",
    };
    if *mode == FailureMode::Unsupported {
        return "answer 65 to a malformed file of a kind that the decoder reads; 69 says that it reads no such files"
            .to_owned();
    }
    let status = match mode {
        FailureMode::Crashes(how) => how.strip_prefix("exit status "),
        _ => None,
    };
    match status {
        // How Rust and shells end that break down; nobody refuses so.
        Some(status) if !matches!(status, "101" | "126" | "127" | "134" | "139") => format!(
            "{end} there; if {status} is how this decoder refuses, say --reject-exit {status}"
        ),
        _ => format!("find the fault before it does harm, and {end}"),
    }
}
