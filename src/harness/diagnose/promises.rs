//! Formats that a decoder declares and does not read: that is no mistake in reading, but in what it says of itself.

use std::collections::BTreeSet;

use super::{Cause, Diagnosis, Kind};
use crate::harness::cases::{Case, Suite};
use crate::harness::check::Run;
use crate::harness::judge::{Finding, breaks_promise};

/// Whether it answered 69 here as to every file of a format that its capabilities declare.
pub(super) fn is_broken(run: &Run, case: &Case, finding: &Finding) -> bool {
    breaks_promise(case, finding, &run.offer, &run.judgement.unsupported)
}

/// All of them together.
pub(super) fn describe(suite: &Suite, run: &Run) -> Option<Diagnosis> {
    let asked = suite.cases.iter().zip(&run.findings).enumerate();
    let of: Vec<usize> = asked
        .filter(|&(place, (case, finding))| {
            run.judgement.cases[place].is_some()
                && finding
                    .as_ref()
                    .is_some_and(|finding| is_broken(run, case, finding))
        })
        .map(|(place, _)| place)
        .collect();
    let first = &suite.cases[*of.first()?];
    let formats: BTreeSet<&str> = of
        .iter()
        .map(|&place| suite.cases[place].format().short_name())
        .collect();
    let formats: Vec<&str> = formats.into_iter().collect();
    Some(Diagnosis::of(
        Cause::Described {
            kind: Kind::Refusal,
            clause: "2.2/1".to_owned(),
            effect: format!(
                "answers 69 (unsupported) to every file of {}, which its capabilities declare",
                formats.join(", ")
            ),
            mend: "read these formats, or take them out of the capabilities".to_owned(),
            example: format!("for example {}: {}", first.id, first.because),
        },
        of,
    ))
}
