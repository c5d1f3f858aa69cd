//! The dialect card: how a decoder reads what the text leaves open, and what it does with files beyond the letter.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Reading;
use crate::harness::cases::{Expect, Feature, Suite};
use crate::harness::check::Run;
use crate::harness::choices::CHOICES;
use crate::harness::judge::{Outcome, Right, Shown};

/// Cases that are named as evidence.
const NAMED: usize = 3;

/// What a decoder did with the files of one lenient ruling. Refusing them and showing the reference's picture are both
/// right.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leniency {
    /// The ruling.
    pub ruling: String,
    /// Files decoded as the reference decodes them.
    pub decoded: usize,
    /// Files refused.
    pub refused: usize,
    /// Files answered 69.
    pub unsupported: usize,
    /// Files that gave another picture or none.
    pub otherwise: usize,
}

/// The reading of each choice that some case showed, with the cases that show it.
pub(super) fn dialect(suite: &Suite, run: &Run) -> Vec<Reading> {
    let reading = |ruling: &str, reading: &str, shown_by: Vec<String>| Reading {
        ruling: ruling.to_owned(),
        reading: reading.to_owned(),
        shown_by,
    };
    let has_tables = run
        .judgement
        .decoded
        .iter()
        .any(|feature| matches!(feature, Feature::Format(format) if format.has_table()));
    let newline = if run.table.newline {
        "one line feed"
    } else {
        "nothing"
    };
    let spelled = |ruling: &str| {
        passing(suite, run, |i| {
            suite.cases[i].expect == Expect::Spelling
                && suite.cases[i].ruling.as_deref() == Some(ruling)
        })
    };
    let tables = has_tables.then(|| {
        [
            reading("lut-count", run.table.count.name(), spelled("lut-count")),
            reading("lut-newline", newline, spelled("lut-newline")),
        ]
    });
    let choices = run.judgement.dialect.iter().filter_map(|&(ruling, said)| {
        let axis = CHOICES.iter().position(|choice| choice.ruling == ruling)?;
        let shows = |i: usize| {
            let finding = run.findings[i].as_ref();
            matches!(
                finding.map(|finding| &finding.shown),
                Some(Shown::Picture { right: Right::In { axes, .. }, .. }) if axes.contains(&axis)
            )
        };
        Some(reading(ruling, said?, passing(suite, run, shows)))
    });
    tables.into_iter().flatten().chain(choices).collect()
}

/// The first cases of a kind that passed.
fn passing(suite: &Suite, run: &Run, is: impl Fn(usize) -> bool) -> Vec<String> {
    let passes = |&i: &usize| {
        let judged = run.judgement.cases[i].as_ref();
        judged.is_some_and(|judged| judged.outcome == Outcome::Pass) && is(i)
    };
    (0..suite.cases.len())
        .filter(passes)
        .take(NAMED)
        .map(|i| suite.cases[i].id.clone())
        .collect()
}

/// What the decoder does beyond the letter, ruling by ruling.
pub(super) fn leniency(suite: &Suite, run: &Run) -> Vec<Leniency> {
    let mut rulings: BTreeMap<&str, Leniency> = BTreeMap::new();
    for (i, case) in suite.cases.iter().enumerate() {
        let (Expect::Lenient, Some(ruling)) = (case.expect, &case.ruling) else {
            continue;
        };
        let (Some(finding), Some(judged)) = (&run.findings[i], &run.judgement.cases[i]) else {
            continue;
        };
        let of = rulings.entry(ruling).or_insert_with(|| Leniency {
            ruling: ruling.clone(),
            ..Leniency::default()
        });
        match (&finding.shown, judged.outcome) {
            (Shown::Rejected, _) => of.refused += 1,
            (Shown::Unsupported, _) => of.unsupported += 1,
            (Shown::Picture { .. }, Outcome::Pass) => of.decoded += 1,
            _ => of.otherwise += 1,
        }
    }
    rulings.into_values().collect()
}

/// One ruling in words, for the terminal.
pub(super) fn said(leniency: &Leniency) -> String {
    let counts = [
        (leniency.decoded, "decoded"),
        (leniency.refused, "refused"),
        (leniency.unsupported, "unsupported"),
        (leniency.otherwise, "otherwise"),
    ];
    let counts: Vec<String> = counts
        .into_iter()
        .filter(|&(count, _)| count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
    format!("{} {}", leniency.ruling, counts.join(" "))
}
