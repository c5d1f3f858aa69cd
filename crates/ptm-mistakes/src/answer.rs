//! Answers of a decoder that makes mistakes.

use std::borrow::Cow;

use super::anatomy::{Anatomy, EditedFile};
use super::{change::Change, misreading::Misreading};
use crate::formula::{self, Edit, Edits, Outside};
use ptm::Ptm;
use ptm::error::{Class, Error};
use ptm::reading::Reading;
use ptm_suite::protocol::frame::{Answer, View};

/// Returns the answer of a decoder that follows `reading` except for these mistakes.
#[must_use]
pub fn answer(misreadings: &[&Misreading], reading: Reading, file: &[u8], view: &View) -> Answer {
    answer_with(misreadings, reading, file, view, Outside::Refused)
}

/// Like [`answer`], for a decoder that does `outside` at an edited position outside the data.
#[must_use]
pub fn answer_with(
    misreadings: &[&Misreading],
    reading: Reading,
    file: &[u8],
    view: &View,
    outside: Outside,
) -> Answer {
    match read_with(misreadings, reading, file, outside) {
        Ok((ptm, reading)) => render(misreadings, &reading, &ptm, view),
        Err(error) => refusal_answer(error),
    }
}

/// Returns the answer for a refused file. `None` means that a mistake caused the refusal.
#[must_use]
pub fn refusal_answer(error: Option<Error>) -> Answer {
    match error {
        Some(error) if error.class() != Class::Malformed => Answer::Unsupported,
        _ => Answer::Rejected,
    }
}

/// Decodes a file as a decoder with these mistakes would, except for mistakes that change decoded planes. Returns the map and the
/// modified reading.
///
/// # Errors
/// Returns the error that makes the decoder refuse the file, or `None` if a mistake causes the refusal.
pub fn read(
    misreadings: &[&Misreading],
    reading: Reading,
    file: &[u8],
) -> Result<(Ptm, Reading), Option<Error>> {
    read_with(misreadings, reading, file, Outside::Refused)
}

/// Like [`read`], for a decoder that does `outside` at an edited position outside the data.
fn read_with(
    misreadings: &[&Misreading],
    reading: Reading,
    file: &[u8],
    outside: Outside,
) -> Result<(Ptm, Reading), Option<Error>> {
    let reading = apply_to_reading(misreadings, reading);
    let mut bytes = Cow::Borrowed(file);
    for misreading in misreadings {
        if let Change::Bytes(edit) = misreading.change {
            match edit(&Anatomy::new(&bytes, &reading)) {
                EditedFile::Refused => return Err(None),
                EditedFile::File(edited) => bytes = Cow::Owned(edited),
            }
        }
    }
    let edits = formula_edits(misreadings);
    let ptm = formula::decode(&bytes, &reading, Edits(&edits), outside).map_err(Some)?;
    Ok((ptm, reading))
}

/// Returns `reading` with the decisions of a decoder with these mistakes.
#[must_use]
pub fn apply_to_reading(misreadings: &[&Misreading], mut reading: Reading) -> Reading {
    for misreading in misreadings {
        if let Change::Reading(change) = misreading.change {
            change(&mut reading);
        }
    }
    reading
}

/// Renders a decoded map as a decoder with these mistakes would. `reading` must already include them.
#[must_use]
pub fn render(misreadings: &[&Misreading], reading: &Reading, ptm: &Ptm, view: &View) -> Answer {
    let ptm = with_plane_edits(misreadings, ptm);
    let edits = formula_edits(misreadings);
    Answer::Decoded(formula::render(&ptm, view, reading, Edits(&edits)))
}

/// Computes the samples in `view` for a decoder with these mistakes. Colors are not rounded.
#[must_use]
pub fn unrounded_values(
    misreadings: &[&Misreading],
    reading: &Reading,
    ptm: &Ptm,
    view: &View,
) -> Vec<f64> {
    let ptm = with_plane_edits(misreadings, ptm);
    let edits = formula_edits(misreadings);
    formula::values(&ptm, view, reading, Edits(&edits))
}

fn with_plane_edits<'a>(misreadings: &[&Misreading], ptm: &'a Ptm) -> Cow<'a, Ptm> {
    let mut ptm = Cow::Borrowed(ptm);
    for edit in plane_edits(misreadings) {
        edit(ptm.to_mut());
    }
    ptm
}

/// Returns the map with the stored values of a decoder with these mistakes.
#[must_use]
pub fn stored_values(misreadings: &[&Misreading], ptm: &Ptm) -> Ptm {
    let ptm = with_plane_edits(misreadings, ptm);
    let edits = formula_edits(misreadings);
    formula::stored_values(&ptm, Edits(&edits)).into_owned()
}

/// Returns the formula edits of these mistakes. If two mistakes edit the same formula, the edit of the later mistake comes first.
#[must_use]
pub fn formula_edits(misreadings: &[&Misreading]) -> Vec<&'static Edit> {
    let edits = misreadings
        .iter()
        .rev()
        .filter_map(|misreading| match misreading.change {
            Change::Edits(edits) => Some(edits),
            _ => None,
        });
    edits.flatten().collect()
}

/// Returns the changes to the decoded map that these mistakes make.
pub fn plane_edits(misreadings: &[&Misreading]) -> impl Iterator<Item = fn(&mut Ptm)> {
    misreadings
        .iter()
        .filter_map(|misreading| match misreading.change {
            Change::Map(edit) => Some(edit),
            _ => None,
        })
}
