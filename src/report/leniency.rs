//! The behavior of a decoder for files outside the specification.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::session::observation::Response;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::{Expect, Suite};
use crate::suite::test_case::TestCase;

/// Maximum number of cases that are named as evidence.
const MAX_NAMED: usize = 3;

/// The results of a decoder for the files of one lenient ruling. Both refusing them and showing the reference's image are
/// right.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leniency {
    /// The ruling.
    pub ruling: String,
    /// Files decoded as the reference decodes them.
    pub decoded: usize,
    /// Files refused.
    pub refused: usize,
    /// Files on which it exited with 69.
    pub unsupported: usize,
    /// Files that gave another image or none.
    pub other: usize,
}

impl Leniency {
    /// Describes it in words: `lut-huge: 1 refused, 4 other results`.
    pub(super) fn in_words(&self) -> String {
        let other = if self.other == 1 {
            "other result"
        } else {
            "other results"
        };
        let mut counts = Vec::new();
        for (count, what) in [
            (self.decoded, "decoded"),
            (self.refused, "refused"),
            (self.unsupported, "unsupported"),
            (self.other, other),
        ] {
            if count > 0 {
                counts.push(format!("{count} {what}"));
            }
        }
        format!("{}: {}", self.ruling, counts.join(", "))
    }
}

/// Returns the behavior of the decoder outside the specification, ruling by ruling.
pub(super) fn leniency<C: TestCase>(suite: &Suite<C>, run: &Run<C>) -> Vec<Leniency> {
    let mut rulings: BTreeMap<&str, Leniency> = BTreeMap::new();
    for (i, case) in suite.cases.iter().enumerate() {
        let (Expect::Lenient | Expect::Robust, Some(ruling)) = (case.expect(), case.ruling())
        else {
            continue;
        };
        let (Some(observation), Some(judged)) = (&run.observations[i], &run.judgement.cases[i])
        else {
            continue;
        };
        let of = rulings.entry(ruling).or_insert_with(|| Leniency {
            ruling: ruling.to_owned(),
            ..Leniency::default()
        });
        match (&observation.response, judged.outcome) {
            (Response::Rejected, _) => of.refused += 1,
            (Response::Unsupported, _) => of.unsupported += 1,
            (Response::Image { .. }, Outcome::Pass) => of.decoded += 1,
            _ => of.other += 1,
        }
    }
    rulings.into_values().collect()
}

/// Returns the first cases of a kind that passed.
pub(super) fn passing<C: TestCase>(
    suite: &Suite<C>,
    run: &Run<C>,
    is: impl Fn(usize) -> bool,
) -> Vec<String> {
    let passed = run.judgement.with_outcome(Outcome::Pass).filter(|&i| is(i));
    let ids = passed.map(|i| suite.cases[i].id().to_owned());
    ids.take(MAX_NAMED).collect()
}
