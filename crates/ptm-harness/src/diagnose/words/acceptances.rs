//! Describes malformed files that the decoder accepts because it does not check for their faults.

use super::list_first;
use crate::diagnose::diagnosis::{Category, CauseText, Diagnosis};
use crate::diagnose::rules;
use crate::diagnose::witness::Witness;
use ptm_suite::cases::Case;
use ptm_suite::verdicts::observation::Response;

/// Describes acceptances, grouped by the ruling that makes the files malformed or by the violated clause, and removes them from
/// `left`.
pub fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let mut groups: Vec<(&str, Vec<usize>)> = Vec::new();
    left.retain(|&w| {
        let Some(rule) = violated_rule(&witnesses[w]) else {
            return true;
        };
        match groups.iter_mut().find(|(known, _)| *known == rule) {
            Some((_, indices)) => indices.push(w),
            None => groups.push((rule, vec![w])),
        }
        false
    });
    groups.sort_by_key(|(_, indices)| std::cmp::Reverse(indices.len()));
    groups
        .into_iter()
        .map(|(_, cases)| describe_group(witnesses, &cases))
        .collect()
}

/// Counts the acceptances in `left` that violate the same ruling or clause as one in `cases`.
pub(in crate::diagnose) fn count_of_the_same_kind(
    witnesses: &[Witness],
    cases: &[usize],
    left: &[usize],
) -> usize {
    let rule = |w: &usize| violated_rule(&witnesses[*w]);
    let is_same = |other: &&usize| {
        rule(other).is_some_and(|violated| cases.iter().any(|w| rule(w) == Some(violated)))
    };
    left.iter().filter(is_same).count()
}

/// Returns the ruling or clause that an accepted malformed file violates, or `None` if the response is not an acceptance.
fn violated_rule<'w>(witness: &'w Witness<'_>) -> Option<&'w str> {
    let is_accepted = witness.case.expect.is_refusal()
        && matches!(witness.observation.response, Response::Image { .. });
    let ruling = witness.case.ruling.as_deref();
    is_accepted.then(|| ruling.unwrap_or_else(|| violated_clause(witness)))
}

/// Describes accepted malformed files.
pub(in crate::diagnose) fn describe_group(witnesses: &[Witness], cases: &[usize]) -> Diagnosis {
    let mut indices = cases.to_vec();
    rules::sort_smallest_first(witnesses, &mut indices);
    // A lenient file may be listed with them, because the same misreading gives a wrong image of it. It has no fault.
    indices.sort_by_key(|&w| witnesses[w].case.expect.is_optional());
    let is_malformed = |w: &&usize| !witnesses[**w].case.expect.is_optional();
    let malformed = match indices.iter().filter(is_malformed).count() {
        0 => indices.len(),
        count => count,
    };
    let first = &witnesses[indices[0]];
    let faults = faults(witnesses, &indices[..malformed]);
    let others = match indices.len() - malformed {
        0 => String::new(),
        count => format!(" (and {count} that need not be decoded)"),
    };
    let its_fault = match faults.len() {
        1 => "with this fault",
        _ => "with the first of these faults",
    };
    let twin = first.case.twin_of.as_ref().map_or(String::new(), |twin| {
        format!(", which is the legal {twin} {its_fault}")
    });
    let text = CauseText {
        effect: format!(
            "accepts malformed files: {}{others}",
            list_first(&faults, "fault")
        ),
        fix: "refuse these files with exit status 65".to_owned(),
        example: format!("for example {}{twin}", first.case.id),
    };
    let clause = Some(violated_clause(first));
    Diagnosis::from_description(Category::Acceptance, witnesses, &indices, text, clause)
}

fn violated_clause<'w>(witness: &'w Witness<'_>) -> &'w str {
    let first_clause = || witness.case.clauses.first().map_or("", String::as_str);
    (witness.case.damage()).map_or_else(first_clause, |damage| &damage.clause)
}

/// Returns the distinct faults of these files, in the order of the files.
fn faults<'w>(witnesses: &'w [Witness<'_>], indices: &[usize]) -> Vec<&'w str> {
    let mut faults: Vec<&str> = Vec::new();
    for fault in indices.iter().map(|&w| fault_text(witnesses[w].case)) {
        if !faults.contains(&fault) {
            faults.push(fault);
        }
    }
    faults
}

/// Returns the effect of the damage to a file, or the purpose of the case if there is no damage.
pub(super) fn fault_text(case: &Case) -> &str {
    let because = case.because.trim_end_matches('.');
    case.damage().map_or(because, |damage| &damage.effect)
}
