//! Describes formats that a decoder declares but does not read. This is a mistake in the capabilities that the decoder declares.

use std::collections::BTreeSet;

use crate::diagnose::diagnosis::{Category, Cause, Diagnosis};
use crate::diagnose::rules;
use crate::diagnose::witness::breaks_promise;
use crate::session::run::Run;
use ptm_suite::cases::{Case, Suite};

/// Describes all declared formats that the decoder does not read.
pub(in crate::diagnose) fn describe(suite: &Suite, run: &Run) -> Option<Diagnosis> {
    let is_broken = |&index: &usize| {
        let observation = run.observations[index].as_ref();
        run.judgment.cases[index].is_some()
            && observation.is_some_and(|seen| breaks_promise(run, &suite.cases[index], seen))
    };
    let indices: Vec<usize> = (0..suite.cases.len()).filter(is_broken).collect();
    let cases: Vec<&Case> = indices.iter().map(|&index| &suite.cases[index]).collect();
    let first = cases.first()?;
    let clause = rules::common_clause(&cases, Some("2.2/1"));
    let formats = cases.iter().map(|case| case.format().short_name());
    let formats: Vec<&str> = formats.collect::<BTreeSet<_>>().into_iter().collect();
    Some(Diagnosis::new(
        Cause::Described {
            category: Category::Refusal,
            clause: clause.map(str::to_owned),
            effect: format!(
                "exits with 69 (unsupported) on {} files, although its capabilities declare their formats: {}",
                indices.len(),
                formats.join(", ")
            ),
            fix: "read these formats, or remove them from the capabilities".to_owned(),
            example: format!("for example {}: {}", first.id, first.because),
            equivalents: Vec::new(),
        },
        indices,
    ))
}
