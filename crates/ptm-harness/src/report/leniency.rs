//! Behavior of a decoder on files outside the specification.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::session::run::{Run, RunOf};
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::test_case::{Listed, TestCase};
use ptm_suite::verdicts::{observation::Response, outcome::Outcome};

/// Maximum number of cases that are listed as evidence.
const MAX_EVIDENCE_CASES: usize = 3;

/// Results of a decoder for the files of one lenient ruling. A decoder may refuse these files or return the reference's image.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leniency {
    /// Id of the ruling.
    pub ruling: String,
    /// Number of files for which the decoder returned the image of the reference.
    pub decoded: usize,
    /// Number of refused files.
    pub refused: usize,
    /// Number of files for which the decoder exited with status 69.
    pub unsupported: usize,
    /// Number of files with any other result, such as a different image or a crash.
    pub other: usize,
}

impl Leniency {
    /// Returns a summary such as `lut-huge: 1 refused, 4 other results`.
    #[must_use]
    pub fn to_summary(&self) -> String {
        let plural = if self.other == 1 { "" } else { "s" };
        let mut counts = Vec::new();
        for (count, label) in [
            (self.decoded, "decoded"),
            (self.refused, "refused"),
            (self.unsupported, "unsupported"),
            (self.other, &format!("other result{plural}")),
        ] {
            if count > 0 {
                counts.push(format!("{count} {label}"));
            }
        }
        format!("{}: {}", self.ruling, counts.join(", "))
    }
}

/// Counts the decoder's results for files outside the specification, one entry per ruling.
pub(super) fn leniency<C: TestCase>(suite: &Suite<C>, run: &RunOf<C>) -> Vec<Leniency> {
    let mut rulings: BTreeMap<&str, Leniency> = BTreeMap::new();
    for (i, case) in suite.cases.iter().enumerate() {
        let is_lenient = matches!(case.expect(), Expect::Lenient | Expect::Robust);
        let ruling = case.ruling().filter(|_| is_lenient);
        let seen = run.observations[i].as_ref().zip(ruling);
        let Some(((seen, ruling), judged)) = seen.zip(run.judgment.cases[i].as_ref()) else {
            continue;
        };
        let counts = rulings.entry(ruling).or_insert_with(|| Leniency {
            ruling: ruling.to_owned(),
            ..Leniency::default()
        });
        match (&seen.response, judged.outcome) {
            (Response::Rejected, _) => counts.refused += 1,
            (Response::Unsupported, _) => counts.unsupported += 1,
            (Response::Image { .. }, Outcome::Pass) => counts.decoded += 1,
            // The legal twin was refused.
            (Response::Image { right, .. }, Outcome::Inconclusive)
                if right.is_right_in_reference() =>
            {
                counts.decoded += 1;
            }
            _ => counts.other += 1,
        }
    }
    rulings.into_values().collect()
}

/// Returns the ids of the first passing cases whose indices satisfy `is_included`.
pub(super) fn passing_case_ids<C: Listed, V, T, D, F>(
    suite: &Suite<C>,
    run: &Run<V, T, D, F>,
    is_included: impl Fn(usize) -> bool,
) -> Vec<String> {
    let passed = run.judgment.with_outcome(Outcome::Pass);
    let passed = passed.filter(|&i| is_included(i));
    let ids = passed.map(|i| suite.cases[i].id().to_owned());
    ids.take(MAX_EVIDENCE_CASES).collect()
}
