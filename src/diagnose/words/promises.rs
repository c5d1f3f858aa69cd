//! Formats that a decoder declares and does not read: a mistake in its capabilities, not in its reading.

use std::collections::BTreeSet;

use crate::diagnose::diagnosis::{Category, Cause, Diagnosis};
use crate::diagnose::witness::breaks_its_promise;
use crate::session::run::Run;
use crate::suite::cases::Suite;

/// Describes all declared formats that are not read.
pub(in crate::diagnose) fn describe(suite: &Suite, run: &Run) -> Option<Diagnosis> {
    let asked = suite.cases.iter().zip(&run.observations).enumerate();
    let of: Vec<usize> = asked
        .filter(|&(place, (case, observation))| {
            run.judgement.cases[place].is_some()
                && observation
                    .as_ref()
                    .is_some_and(|observation| breaks_its_promise(run, case, observation))
        })
        .map(|(place, _)| place)
        .collect();
    let first = &suite.cases[*of.first()?];
    let formats: BTreeSet<&str> = of
        .iter()
        .map(|&place| suite.cases[place].format().short_name())
        .collect();
    let formats: Vec<&str> = formats.into_iter().collect();
    Some(Diagnosis::new(
        Cause::Described {
            category: Category::Refusal,
            clause: "2.2/1".to_owned(),
            effect: format!(
                "exits with 69 (unsupported) on {} files of {}, which its capabilities declare",
                of.len(),
                formats.join(", ")
            ),
            fix: "read these formats, or remove them from the capabilities".to_owned(),
            example: format!("for example {}: {}", first.id, first.because),
            alike: Vec::new(),
        },
        of,
    ))
}
