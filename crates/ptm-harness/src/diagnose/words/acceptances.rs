//! Describes malformed files that the decoder accepts because it does not check for their faults.

use super::list_first;
use crate::diagnose::diagnosis::{Category, Cause, CauseText, Diagnosis};
use crate::diagnose::witness::Witness;
use ptm_mistakes::{Misreading, Symptom};
use ptm_suite::cases::{Case, Expect};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::verdicts::observation::Response;

/// Describes acceptances, grouped by clause, and removes them from `left`.
pub fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let accepted = |&w: &usize| {
        let witness = &witnesses[w];
        matches!(witness.case.expect, Expect::Reject | Expect::Refuse)
            && matches!(witness.observation.response, Response::Image { .. })
    };
    let mut clauses: Vec<(&str, Vec<usize>)> = Vec::new();
    for w in left.iter().copied().filter(accepted) {
        let clause = violated_clause(&witnesses[w]);
        match clauses.iter_mut().find(|(known, _)| *known == clause) {
            Some((_, indices)) => indices.push(w),
            None => clauses.push((clause, vec![w])),
        }
    }
    left.retain(|w| !accepted(w));
    clauses.sort_by_key(|(_, indices)| std::cmp::Reverse(indices.len()));
    let diagnosis = |(clause, indices): (&str, Vec<usize>)| {
        describe_acceptance(witnesses, &indices).with_clause(clause)
    };
    clauses.into_iter().map(diagnosis).collect()
}

/// Describes malformed files that the decoder accepts.
fn describe_acceptance(witnesses: &[Witness], indices: &[usize]) -> Diagnosis {
    let first = &witnesses[indices[0]];
    let twin = first.case.twin_of.as_ref().map_or(String::new(), |twin| {
        format!(", which is the legal {twin} with this one fault")
    });
    let text = CauseText {
        effect: format!(
            "accepts malformed files: {}",
            list_faults(witnesses, indices)
        ),
        fix: "refuse these files with exit status 65".to_owned(),
        example: format!("for example {}{twin}", first.case.id),
    };
    Diagnosis::from_description(Category::Acceptance, witnesses, indices, text)
}

/// Describes accepted malformed files if a misreading explains only these, although it would also affect other files. Malformed
/// files have no correct image, so these cases do not reveal how the decoder reads them.
pub(in crate::diagnose) fn describe_acceptances(
    witnesses: &[Witness],
    indices: &[usize],
    misreading: &Misreading,
) -> Option<Cause> {
    let is_accepted = |w: &usize| witnesses[*w].expected == Answer::Rejected;
    let expect = |w: &usize| witnesses[*w].case.expect;
    let is_malformed = |w: &usize| matches!(expect(w), Expect::Reject | Expect::Refuse);
    let malformed: Vec<usize> = indices.iter().copied().filter(is_malformed).collect();
    let claims_more = misreading.symptom != Symptom::Acceptances;
    let &first = malformed.first()?;
    (claims_more && indices.iter().all(is_accepted)).then(|| {
        describe_acceptance(witnesses, &malformed)
            .with_clause(violated_clause(&witnesses[first]))
            .cause
    })
}

fn violated_clause<'w>(witness: &'w Witness<'_>) -> &'w str {
    let first_clause = || witness.case.clauses.first().map_or("", String::as_str);
    (witness.case.damage()).map_or_else(first_clause, |damage| &damage.clause)
}

/// Lists the distinct faults of these files.
fn list_faults(witnesses: &[Witness], indices: &[usize]) -> String {
    let mut faults: Vec<&str> = Vec::new();
    for fault in indices.iter().map(|&w| fault_text(witnesses[w].case)) {
        if !faults.contains(&fault) {
            faults.push(fault);
        }
    }
    list_first(&faults, "fault")
}

/// Returns the effect of the damage to a file, or the purpose of the case if there is no damage.
pub(super) fn fault_text(case: &Case) -> &str {
    let because = case.because.trim_end_matches('.');
    case.damage().map_or(because, |damage| &damage.effect)
}
