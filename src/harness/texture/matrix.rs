//! How strong the suite is: which cases catch which misreadings, and which misreadings it can tell apart.

use std::sync::Arc;

use crate::harness::texture::cases::Suite;
use crate::harness::texture::check::{Plan, ask_rules, check};
use crate::harness::texture::judge::{Outcome, Shown};
use crate::harness::texture::misreadings::{self, Misreading};
use crate::texture::Rules;

/// What the suite makes of one mistake.
pub struct Row {
    /// The mistake.
    pub misreading: &'static Misreading,
    /// The cases that fail, by their place in the suite.
    pub killed_by: Vec<usize>,
    /// Its answer to every case.
    pub answers: Vec<String>,
}

/// Runs the suite against every misreading.
#[must_use]
pub fn matrix(suite: &Suite) -> Vec<Row> {
    let row = |misreading: &'static Misreading| {
        let rules = (misreading.change)(Rules::SPEC);
        let plan = Plan {
            selected: vec![true; suite.cases.len()],
            jobs: 1,
            stop: Arc::default(),
        };
        let run = check(
            suite,
            &plan,
            &|case, _| ask_rules(&rules, case),
            &|_, _, _, _| (),
        );
        let failed = run
            .judgement
            .cases
            .iter()
            .enumerate()
            .filter(|(_, judged)| {
                judged
                    .as_ref()
                    .is_some_and(|judged| judged.outcome == Outcome::Fail)
            });
        let answers = run.findings.iter().map(|finding| match finding {
            Some(finding) => match &finding.shown {
                Shown::Said(value) => value.to_string(),
                other => other.name().to_owned(),
            },
            None => String::new(),
        });
        Row {
            misreading,
            killed_by: failed.map(|(i, _)| i).collect(),
            answers: answers.collect(),
        }
    };
    misreadings::ALL.iter().map(row).collect()
}
