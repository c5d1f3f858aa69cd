//! Judging the rest: mistakes that the user knows of are taken as given.
//!
//! A failure that is what a decoder with these mistakes shows is no news; every other answer is held against what such
//! a decoder should have shown.

use super::witness::{self, Agreement, Witness, spoken, witnesses};
use crate::harness::cases::Suite;
use crate::harness::check::Run;
use crate::harness::choices::{combinations, concerned};
use crate::harness::compare::Expected;
use crate::harness::judge::{Outcome, Shown};
use crate::harness::misreadings::Misreading;
use crate::harness::protocol::Answer;

/// Takes the mistakes `assumed` as given: failures that they explain are no failures any more.
pub fn assume(suite: &Suite, run: &mut Run, assumed: &[&'static Misreading], threads: usize) {
    if assumed.is_empty() {
        return;
    }
    let reading = spoken(run);
    let mut said: Vec<(usize, Outcome, String)> = Vec::new();
    for witness in witnesses(suite, run, reading, threads) {
        if !witness.failed {
            continue;
        }
        let made = witness.answer(assumed);
        if *made == witness.right {
            continue;
        }
        if is_explained(&witness, &made, assumed) {
            said.push((witness.place, Outcome::Assumed, String::new()));
        } else if let (
            Shown::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(made),
        ) = (&witness.finding.shown, &*made)
            && let Some(difference) = Expected::of_frame(made).compare(shown)
        {
            said.push((
                witness.place,
                Outcome::Fail,
                format!("with the assumed mistakes: {difference}"),
            ));
        }
    }
    for (place, outcome, says) in said {
        if let Some(judged) = &mut run.judgement.cases[place] {
            judged.outcome = outcome;
            judged.says = says;
        }
    }
}

/// Whether it is what such a decoder shows, in whatever way it reads the open questions.
fn is_explained(witness: &Witness, made: &Answer, assumed: &[&'static Misreading]) -> bool {
    let explained = |answer: &Answer| {
        matches!(
            witness.agreement(answer),
            Agreement::Picture | Agreement::Word
        )
    };
    let axes = concerned(witness.case, &witness.finding.view);
    explained(made)
        || combinations(&axes).iter().skip(1).any(|dialect| {
            let (reading, file) = (dialect.reading(), &witness.built.file);
            explained(&witness::answer(assumed, reading, file, witness.finding))
        })
}
