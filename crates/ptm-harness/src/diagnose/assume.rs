//! `--assume`: judges a decoder that is known to make certain mistakes.
//!
//! Failures that a decoder with these mistakes reproduces are marked "as assumed". Every other wrong image is compared with the
//! output of such a decoder.

use super::witness::{Agreement, Witness, witnesses};
use crate::session::run::Run;
use ptm::reading::Reading;
use ptm_mistakes::Misreading;
use ptm_suite::cases::Suite;
use ptm_suite::choices::{CHOICES, relevant_axes};
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::verdicts::outcome::Outcome;

/// Marks failures that the `assumed` mistakes explain, and updates the reasons for the remaining failures.
pub fn assume(suite: &Suite, run: &mut Run, assumed: &[&'static Misreading], threads: usize) {
    if assumed.is_empty() {
        return;
    }
    let mut changes: Vec<(usize, Outcome, String)> = Vec::new();
    for witness in witnesses(suite, run, threads) {
        if !witness.failed {
            continue;
        }
        let answer = witness.answer_of_misreadings(assumed);
        if *answer == witness.expected {
            continue;
        }
        if is_explained(&witness, &answer, assumed) {
            changes.push((witness.case_index, Outcome::Assumed, String::new()));
        } else if let (Some(received), Answer::Decoded(answer)) = (witness.wrong_image(), &*answer)
            && let Some(difference) = Expected::from_frame(answer).compare(received)
        {
            changes.push((
                witness.case_index,
                Outcome::Fail,
                format!("with the assumed mistakes: {difference}"),
            ));
        }
    }
    for (index, outcome, says) in changes {
        if let Some(judged) = &mut run.judgment.cases[index] {
            judged.outcome = outcome;
            judged.message = says;
        }
    }
}

/// Returns true if a decoder with these mistakes reproduces the response under some combination of choices.
fn is_explained(witness: &Witness, answer: &Answer, assumed: &[&'static Misreading]) -> bool {
    let reproduces = |answer: &Answer| {
        matches!(
            witness.agreement(answer),
            Agreement::Image | Agreement::BlankImage | Agreement::TwinImage | Agreement::Refusal
        )
    };
    let axes = relevant_axes(
        witness.case,
        &witness.built.values,
        &witness.observation.view,
    );
    reproduces(answer)
        || CHOICES.combinations(&axes).iter().skip(1).any(|dialect| {
            let (file, view) = (&witness.built.file, &witness.observation.view);
            let reading = CHOICES.apply(dialect, Reading::SPEC);
            reproduces(&ptm_mistakes::answer(assumed, reading, file, view))
        })
}
