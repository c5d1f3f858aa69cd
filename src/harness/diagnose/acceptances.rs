//! Malformed files that were accepted: the edit that made them malformed is what the decoder does not check.

use super::witness::Witness;
use super::{Diagnosis, Kind};
use crate::harness::cases::Expect;
use crate::harness::judge::Shown;

/// Acceptances, damage by damage. They are taken out of `left`.
pub(super) fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let accepted = |&w: &usize| {
        let witness = &witnesses[w];
        matches!(witness.case.expect, Expect::Reject | Expect::Refuse)
            && matches!(witness.finding.shown, Shown::Picture { .. })
    };
    let mut damages: Vec<(String, Vec<usize>)> = Vec::new();
    for w in left.iter().copied().filter(accepted) {
        let fault = fault(&witnesses[w]);
        match damages.iter_mut().find(|(known, _)| *known == fault) {
            Some((_, of)) => of.push(w),
            None => damages.push((fault, vec![w])),
        }
    }
    left.retain(|w| !accepted(w));
    damages.sort_by_key(|(_, of)| std::cmp::Reverse(of.len()));
    let diagnosis = |(fault, of): (String, Vec<usize>)| {
        let first = &witnesses[of[0]];
        let twin = first.case.twin_of.as_ref().map_or(String::new(), |twin| {
            format!(", which is the legal {twin} with this one fault")
        });
        let mut diagnosis = Diagnosis::described(
            Kind::Acceptance,
            witnesses,
            &of,
            (
                format!("accepts malformed files: {fault}"),
                "refuse such files with exit status 65".to_owned(),
                format!("for example {}{twin}", first.case.id),
            ),
        );
        if let (super::Cause::Described { clause, .. }, Some(damage)) =
            (&mut diagnosis.cause, first.case.damage())
        {
            damage.clause.clone_into(clause);
        }
        diagnosis
    };
    damages.into_iter().map(diagnosis).collect()
}

fn fault(witness: &Witness) -> String {
    witness.case.damage().map_or_else(
        || witness.case.because.clone(),
        |damage| damage.effect.to_owned(),
    )
}
