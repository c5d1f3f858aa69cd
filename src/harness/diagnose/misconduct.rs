//! Files that must or may be refused, and that ended in a crash, a hang or nonsense instead.

use super::refusals::{Deed, deed_of, deeds, example};
use super::witness::Witness;
use super::{Diagnosis, Kind};
use crate::harness::cases::Expect;
use crate::harness::judge::Shown;
use crate::harness::protocol::Answer;

/// Faults that are named one by one.
const NAMED: usize = 3;

/// Misconduct on files that need not be read, way by way. It is taken out of `left`.
pub(super) fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let refusable = |w: usize| witnesses[w].case.expect != Expect::Decode;
    let of: Vec<usize> = left
        .iter()
        .copied()
        .filter(|&w| refusable(w) && matches!(witnesses[w].finding.shown, Shown::Misconduct(_)))
        .collect();
    left.retain(|w| !of.contains(w));
    let refuses = (0..witnesses.len())
        .any(|w| refusable(w) && matches!(witnesses[w].finding.shown, Shown::Rejected));
    let diagnosis = |deed: Deed| {
        let these: Vec<usize> = of
            .iter()
            .copied()
            .filter(|&w| deed_of(&witnesses[w]).as_ref() == Some(&deed))
            .collect();
        let effect = format!("{} {}", deed.verb, files(witnesses, &these, refuses));
        let may_be_read = these
            .iter()
            .all(|&w| matches!(witnesses[w].case.expect, Expect::Lenient | Expect::Spelling));
        let mend = mend(&witnesses[these[0]].finding.shown, may_be_read);
        let example = example(witnesses, &these);
        Diagnosis::described(Kind::Misconduct, witnesses, &these, (effect, mend, example))
    };
    deeds(witnesses, &of).into_iter().map(diagnosis).collect()
}

/// Which files they are: by their faults, where those are few.
fn files(witnesses: &[Witness], these: &[usize], refuses: bool) -> String {
    let mut faults: Vec<&str> = these
        .iter()
        .map(|&w| {
            let case = witnesses[w].case;
            case.damage()
                .map_or(case.because.trim_end_matches('.'), |damage| damage.effect)
        })
        .collect();
    faults.sort_unstable();
    faults.dedup();
    if faults.len() <= NAMED {
        return format!("files that need not be read: {}", faults.join("; "));
    }
    let others = if refuses { "; others it refuses" } else { "" };
    format!("{} files that must or may be refused{others}", these.len())
}

fn mend(shown: &Shown, may_be_read: bool) -> String {
    let status = match shown {
        Shown::Misconduct(Answer::Crashed(how)) => how.strip_prefix("exit status "),
        _ => None,
    };
    let end = if may_be_read {
        "end with a picture or with exit status 65"
    } else {
        "end with exit status 65"
    };
    match status {
        // How Rust and shells end that break down; nobody refuses so.
        Some(status) if !matches!(status, "101" | "126" | "127" | "134" | "139") => format!(
            "{end} there; if {status} is how this decoder refuses, say --reject-exit {status}"
        ),
        _ => format!("find the fault before it does harm, and {end}"),
    }
}
