//! Open questions whose readings a mistake imitates.

use super::image_pair::ImagePair;
use super::mistake::Mistake;
use super::search::{MistakeId, Search};
use super::witness::{inferred_dialect, reading_in_dialect};
use crate::session::run::Run;
use ptm_suite::choices::CHOICES;
use ptm_suite::clauses::rulings;
use ptm_suite::dialect::{Axis, Dialect};
use ptm_suite::protocol::frame::Answer;

/// Returns the rulings of open questions whose readings the passing images do not show. Either a mistake in `set` violates the
/// ruling or edits a formula about it, or the mistakes and the reference's reading give the same images.
pub(super) fn imitated_readings(
    search: &Search,
    run: &Run,
    set: &[MistakeId],
) -> Vec<&'static str> {
    let mistakes = search.mistakes_in(&[&search.assumed[..], set].concat());
    let violated = mistakes.iter().filter_map(|one| one.misreading.violates);
    let formulas = mistakes.iter().flat_map(|one| one.misreading.formulas());
    let clauses: Vec<&str> = formulas.map(|formula| formula.stated().clause).collect();
    let rulings = rulings().unwrap_or_else(|error| unreachable!("invalid rulings: {error}"));
    let is_edited = |axis: Axis| {
        let mut of_axis = rulings.iter().filter(|one| one.id == CHOICES[axis].ruling);
        of_axis.any(|one| {
            one.clauses
                .iter()
                .any(|clause| clauses.contains(&clause.as_str()))
        })
    };
    let axes = (0..CHOICES.len())
        .filter(|&axis| is_edited(axis) || is_imitated(search, run, &mistakes, axis));
    let imitated = axes.map(|axis| CHOICES[axis].ruling);
    violated.chain(imitated).collect()
}

/// Returns true if a decoder with the mistakes, and with the reference's reading of one question, shows all passing images that
/// seem to show another reading.
fn is_imitated(search: &Search, run: &Run, mistakes: &[&Mistake], axis: Axis) -> bool {
    let Dialect(mut choices) = inferred_dialect(run);
    if mistakes.is_empty() || std::mem::take(&mut choices[axis]) == 0 {
        return false;
    }
    let reading = reading_in_dialect(run, &Dialect(choices));
    let passing = search.witnesses.iter().filter(|witness| !witness.failed);
    let mut shown = passing.filter_map(|witness| {
        let received = witness.wrong_image()?;
        let differs = |mistakes: &[&Mistake]| {
            let Answer::Decoded(image) = witness.answer_in(reading, &witness.built.file, mistakes)
            else {
                return true;
            };
            let pair = ImagePair::new(witness, &image, received);
            pair.is_none_or(|pair| !pair.wrong_samples().is_empty())
        };
        // An image that follows the reference's reading shows nothing about the question.
        differs(&[]).then(|| differs(mistakes))
    });
    shown.next() == Some(false) && shown.all(|is_shown| !is_shown)
}
