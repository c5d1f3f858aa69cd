//! Judging the rest: mistakes that the user knows of are taken as given.
//!
//! A failure that is what a decoder with these mistakes shows is no news; every other answer is held against what such
//! a decoder should have shown.

use super::witness::{Agreement, Witness, witnesses};
use crate::misreadings::{self, Misreading};
use crate::protocol::frame::Answer;
use crate::reading::Reading;
use crate::session::observation::Response;
use crate::session::outcome::Outcome;
use crate::session::run::Run;
use crate::suite::cases::Suite;
use crate::suite::choices::{CHOICES, concerned};
use crate::suite::compare::Expected;

/// Takes the mistakes `assumed` as given: failures that they explain are no failures any more.
pub fn assume(suite: &Suite, run: &mut Run, assumed: &[&'static Misreading], threads: usize) {
    if assumed.is_empty() {
        return;
    }
    let mut said: Vec<(usize, Outcome, String)> = Vec::new();
    for witness in witnesses(suite, run, None, threads) {
        if !witness.failed {
            continue;
        }
        let made = witness.answer_of_listed(assumed);
        if *made == witness.right {
            continue;
        }
        if is_explained(&witness, &made, assumed) {
            said.push((witness.place, Outcome::Assumed, String::new()));
        } else if let (
            Response::Picture {
                frame: Some(shown), ..
            },
            Answer::Decoded(made),
        ) = (&witness.observation.response, &*made)
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
    let axes = concerned(witness.case, &witness.observation.view);
    explained(made)
        || CHOICES.combinations(&axes).iter().skip(1).any(|dialect| {
            let (file, view) = (&witness.built.file, &witness.observation.view);
            explained(&misreadings::answer(
                assumed,
                CHOICES.under(dialect, Reading::SPEC),
                file,
                view,
            ))
        })
}
