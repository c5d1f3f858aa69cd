//! Open questions whose readings a mistake imitates.

use super::image_pair::ImagePair;
use super::mistake::Mistake;
use super::search::{MistakeId, Search};
use super::witness::{inferred_dialect, reading_in_dialect};
use crate::session::run::Run;
use ptm_suite::choices::CHOICES;
use ptm_suite::clauses::rulings;
use ptm_suite::dialect::Axis;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::verdicts::dialect::Certainty;
use ptm_suite::verdicts::observation::Response;

/// Returns the rulings of open questions whose readings the passing images do not show. Either a mistake in `set` violates the
/// ruling or is about one of its clauses, or the mistakes give the same images with another reading.
pub(super) fn imitated_readings(
    search: &Search,
    run: &Run,
    set: &[MistakeId],
) -> Vec<&'static str> {
    let mistakes = search.mistakes_in(&[&search.assumed[..], set].concat());
    let violated = mistakes.iter().filter_map(|one| one.misreading.violates);
    let formulas = mistakes.iter().flat_map(|one| one.misreading.formulas());
    let of_formulas = formulas.map(|formula| formula.stated().clause);
    let of_mistakes = mistakes.iter().map(|one| one.misreading.clause);
    let clauses: Vec<&str> = of_formulas.chain(of_mistakes).collect();
    let rulings = rulings().unwrap_or_else(|error| unreachable!("invalid rulings: {error}"));
    let is_misread = |axis: Axis| {
        let mut of_axis = rulings.iter().filter(|one| one.id == CHOICES[axis].ruling);
        of_axis.any(|one| {
            one.clauses
                .iter()
                .any(|clause| clauses.contains(&clause.as_str()))
        })
    };
    let settled =
        (0..CHOICES.len()).filter(|&axis| run.judgment.certainties[axis] == Certainty::Settled);
    let axes =
        settled.filter(|&axis| is_misread(axis) || is_imitated(search, run, &mistakes, axis));
    let imitated = axes.map(|axis| CHOICES[axis].ruling);
    violated.chain(imitated).collect()
}

/// Returns true if a decoder with the mistakes, and with another reading of one question, shows all passing images that seem to
/// show the decoder's reading.
fn is_imitated(search: &Search, run: &Run, mistakes: &[&Mistake], axis: Axis) -> bool {
    let dialect = inferred_dialect(run);
    let mut others = (0..CHOICES[axis].readings.len()).filter(|&other| other != dialect.0[axis]);
    let gives_same_images = |other: usize| {
        let mut dialect = dialect.clone();
        dialect.0[axis] = other;
        let reading = reading_in_dialect(run, &dialect);
        let passing = search.witnesses.iter().filter(|witness| !witness.failed);
        let mut shown = passing.filter_map(|witness| {
            let received = match (&witness.observation.response, &witness.expected) {
                (Response::Image { right, .. }, Answer::Decoded(expected))
                    if right.axes().contains(&axis) =>
                {
                    witness.wrong_image().unwrap_or(expected)
                }
                _ => return None,
            };
            let differs = |mistakes: &[&Mistake]| {
                let answer = witness.answer_in(reading, &witness.built.file, mistakes);
                let Answer::Decoded(image) = answer else {
                    return true;
                };
                let pair = ImagePair::new(witness, &image, received);
                pair.is_none_or(|pair| !pair.wrong_samples().is_empty())
            };
            // An image that also follows the other reading shows nothing about the question.
            differs(&[]).then(|| differs(mistakes))
        });
        shown.next() == Some(false) && shown.all(|is_shown| !is_shown)
    };
    !mistakes.is_empty() && others.any(gives_same_images)
}
