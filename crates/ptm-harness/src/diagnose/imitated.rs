//! Open questions whose readings a mistake imitates.

use super::attribution::Attribution;
use super::diagnosis::Cause;
use super::mistake::Mistake;
use super::search::Search;
use super::witness::{equal_up_to_rounding, reading_in_dialect};
use crate::session::run::Run;
use ptm_suite::choices::CHOICES;
use ptm_suite::dialect::{Axis, Dialect};
use ptm_suite::protocol::frame::Answer;

/// Returns the rulings of open questions whose readings the passing images do not show. Either a named mistake violates the
/// ruling, or the mistakes and the reference's reading give the same images.
pub(super) fn imitated_readings(
    search: &Search,
    run: &Run,
    found: &Attribution,
) -> Vec<&'static str> {
    let violated = found.diagnoses.iter().flat_map(|diagnosis| {
        let Cause::Misreading {
            misreading,
            accompanying,
            ..
        } = &diagnosis.cause
        else {
            return Vec::new();
        };
        let named = std::iter::once(misreading).chain(accompanying);
        named.filter_map(|one| one.violates).collect()
    });
    let axes = (0..CHOICES.len()).filter(|&axis| is_imitated(search, run, found, axis));
    violated
        .chain(axes.map(|axis| CHOICES[axis].ruling))
        .collect()
}

/// Returns true if a decoder with the mistakes, and with the reference's reading of one question, shows all passing images that
/// seem to show another reading.
fn is_imitated(search: &Search, run: &Run, found: &Attribution, axis: Axis) -> bool {
    let Dialect(mut choices) = run.judgment.dialect.clone();
    if found.set.is_empty() || std::mem::take(&mut choices[axis]) == 0 {
        return false;
    }
    let reading = reading_in_dialect(run, &Dialect(choices));
    let mistakes: Vec<&Mistake> = found.set.iter().map(|&id| &search.mistakes[id]).collect();
    let passing = search.witnesses.iter().filter(|witness| !witness.failed);
    let mut is_shown = passing.filter_map(|witness| {
        let received = witness.wrong_image()?;
        let shows = |mistakes: &[&Mistake]| {
            let (file, view) = (&witness.built.file, &witness.observation.view);
            let misreadings = witness.misreadings_in_scope(mistakes);
            let answer = ptm_mistakes::answer(&misreadings, reading, file, view);
            matches!(answer, Answer::Decoded(image) if equal_up_to_rounding(&image, received))
        };
        // An image that follows the reference's reading shows nothing about the question.
        (!shows(&[])).then(|| !shows(&mistakes))
    });
    is_shown.next() == Some(false) && !is_shown.any(|shown| shown)
}
