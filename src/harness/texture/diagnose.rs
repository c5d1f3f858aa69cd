//! From failures to causes: which misreading would have failed in the same way.
//!
//! A misreading explains a failure if one who makes it answers the same. It is contradicted by every case that passed and that it
//! would have failed. The one that explains most goes first, and then the next for what is left.

use std::cmp::Reverse;

use crate::harness::texture::cases::{Case, Suite};
use crate::harness::texture::check::{Run, ask_rules};
use crate::harness::texture::choices;
use crate::harness::texture::compare::difference;
use crate::harness::texture::judge::{Outcome, Shown, expected, tolerance};
use crate::harness::texture::misreadings::{self, Misreading};
use crate::texture::Rules;

/// A cause and what it explains.
pub struct Diagnosis {
    /// The mistake.
    pub misreading: &'static Misreading,
    /// Failing cases it reproduces, by their place in the suite.
    pub explains: Vec<usize>,
}

/// The fewest mistakes that explain the failures of `run`, as far as single mistakes do; most telling first.
#[must_use]
pub fn diagnose(suite: &Suite, run: &Run) -> Vec<Diagnosis> {
    let with = |wanted: Outcome| -> Vec<usize> {
        let judged = run.judgement.cases.iter().enumerate();
        let with = judged.filter(|(_, judged)| {
            judged
                .as_ref()
                .is_some_and(|judged| judged.outcome == wanted)
        });
        with.map(|(i, _)| i).collect()
    };
    let (mut failing, passing) = (with(Outcome::Fail), with(Outcome::Pass));
    let own = choices::under(&run.judgement.dialect, Rules::SPEC);
    let mut candidates = Vec::new();
    for misreading in misreadings::ALL {
        let rules = (misreading.change)(own);
        let explains: Vec<usize> = failing
            .iter()
            .copied()
            .filter(|&i| explains(run, i, &suite.cases[i], &rules))
            .collect();
        if explains.is_empty() {
            continue;
        }
        let against = |&&i: &&usize| is_wrong(run, &suite.cases[i], &rules);
        let contradicted = passing.iter().filter(against).count();
        if explains.len() > contradicted {
            let diagnosis = Diagnosis {
                misreading,
                explains,
            };
            candidates.push((diagnosis, contradicted));
        }
    }
    let mut diagnoses = Vec::new();
    loop {
        for (candidate, _) in &mut candidates {
            candidate.explains.retain(|i| failing.contains(i));
        }
        candidates.retain(|(candidate, _)| !candidate.explains.is_empty());
        // The one that explains most; of equals the least contradicted, then the first of the catalogue.
        let best = (0..candidates.len()).min_by_key(|&at| {
            let (candidate, contradicted) = &candidates[at];
            (Reverse(candidate.explains.len()), *contradicted)
        });
        let Some(best) = best else {
            return diagnoses;
        };
        let (best, _) = candidates.remove(best);
        failing.retain(|i| !best.explains.contains(i));
        diagnoses.push(best);
    }
}

/// Whether one who reads so answers as the decoder did.
fn explains(run: &Run, i: usize, case: &Case, rules: &Rules) -> bool {
    let Some(finding) = &run.findings[i] else {
        return false;
    };
    match (&finding.shown, ask_rules(rules, case).shown) {
        (Shown::Said(said), Shown::Said(made)) => {
            // Both ways: a field that only one of them has is a difference.
            case.expect.get("error").is_some()
                || difference(&only_expected(case, &made), said, tolerance(case)).is_none()
        }
        (Shown::Rejected, Shown::Rejected) => true,
        _ => false,
    }
}

/// Of an answer the fields that the case looks at.
fn only_expected(case: &Case, answer: &serde_json::Value) -> serde_json::Value {
    let fields = case.expect.as_object().into_iter().flatten();
    let kept = fields.filter_map(|(name, _)| Some((name.clone(), answer.get(name)?.clone())));
    serde_json::Value::Object(kept.collect())
}

/// Whether one who reads so fails the case.
fn is_wrong(run: &Run, case: &Case, rules: &Rules) -> bool {
    let expected = expected(case, &run.judgement.dialect);
    match ask_rules(rules, case).shown {
        Shown::Said(made) => {
            case.expect.get("error").is_some()
                || difference(&expected, &made, tolerance(case)).is_some()
        }
        Shown::Rejected => case.expect.get("error").is_none(),
        _ => true,
    }
}
