//! Formats that a decoder declares and does not read: that is no mistake in reading, but in what it says of itself.

use super::{Cause, Diagnosis, Kind};
use crate::harness::cases::{Case, Expect, Feature, Suite};
use crate::harness::check::Run;
use crate::harness::judge::{Finding, Shown};

/// Whether it answered 69 here as to every file of a format that its capabilities declare.
pub(super) fn is_broken(run: &Run, case: &Case, finding: &Finding) -> bool {
    matches!(finding.shown, Shown::Unsupported)
        && case.expect == Expect::Decode
        && run.offer.declared.contains(&case.format())
        && run
            .judgement
            .unsupported
            .contains(&Feature::Format(case.format()))
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
    let mut formats: Vec<&str> = of
        .iter()
        .map(|&place| suite.cases[place].format().short_name())
        .collect();
    formats.dedup();
    formats.sort_unstable();
    formats.dedup();
    Some(Diagnosis {
        cause: Cause::Described {
            kind: Kind::Refusal,
            clause: "2.2/1".to_owned(),
            effect: format!(
                "answers 69 (unsupported) to every file of {}, which its capabilities declare",
                formats.join(", ")
            ),
            mend: "read these formats, or take them out of the capabilities".to_owned(),
            example: format!("for example {}: {}", first.id, first.because),
        },
        explains: of,
        partly: Vec::new(),
        except: Vec::new(),
        shows: None,
    })
}
