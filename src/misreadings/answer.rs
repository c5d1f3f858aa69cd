//! The answer of a decoder with mistakes.

use std::borrow::Cow;

use super::anatomy::{Anatomy, Seen};
use super::at::At;
use super::misreading::Misreading;
use crate::error::{Class, Error};
use crate::formula::{self, Edit, Edits};
use crate::protocol::frame::{Answer, Frame, View};
use crate::ptm::Ptm;
use crate::reading::Reading;

/// Returns the answer of a decoder with these mistakes that otherwise follows `reading`.
#[must_use]
pub fn answer(misreadings: &[&Misreading], reading: Reading, file: &[u8], view: &View) -> Answer {
    match read(misreadings, reading, file) {
        Ok((ptm, reading)) => show(misreadings, &reading, &ptm, view),
        Err(why) => refused(why),
    }
}

/// Returns the answer to a file that is not read. Without an error, a mistake refuses it.
pub(crate) fn refused(why: Option<Error>) -> Answer {
    match why {
        Some(error) if error.class() != Class::Malformed => Answer::Unsupported,
        _ => Answer::Rejected,
    }
}

/// Returns the map that a decoder with these mistakes reads, before mistakes that change finished planes, and its reading.
///
/// # Errors
/// The error for which it refuses the file, or `None` if a mistake refuses it.
pub(crate) fn read(
    misreadings: &[&Misreading],
    reading: Reading,
    file: &[u8],
) -> Result<(Ptm, Reading), Option<Error>> {
    let reading = misread(misreadings, reading);
    let mut seen = Cow::Borrowed(file);
    for misreading in misreadings {
        if let At::Bytes(edit) = misreading.at {
            match edit(&Anatomy::new(&seen, &reading)) {
                Seen::Refused => return Err(None),
                Seen::File(bytes) => seen = Cow::Owned(bytes),
            }
        }
    }
    let edits = edits_of(misreadings);
    let ptm = formula::decode(&seen, &reading, Edits(&edits)).map_err(Some)?;
    Ok((ptm, reading))
}

/// Returns `reading` with these mistakes.
pub(crate) fn misread(misreadings: &[&Misreading], reading: Reading) -> Reading {
    misreadings
        .iter()
        .fold(reading, |reading, misreading| misreading.at.change(reading))
}

/// Returns the image that a decoder with these mistakes shows for a decoded map. `reading` includes them.
pub(crate) fn show(
    misreadings: &[&Misreading],
    reading: &Reading,
    ptm: &Ptm,
    view: &View,
) -> Answer {
    let mut ptm = Cow::Borrowed(ptm);
    for edit in edits_of_planes(misreadings) {
        edit(ptm.to_mut());
    }
    let edits = edits_of(misreadings);
    Answer::Decoded(Frame::render_edited(&ptm, view, reading, Edits(&edits)))
}

/// Returns the colors that a decoder with these mistakes computes under a light, before it rounds them.
#[cfg(unix)]
pub(crate) fn colors(
    misreadings: &[&Misreading],
    reading: &Reading,
    ptm: &Ptm,
    light: &crate::protocol::frame::Light,
) -> Vec<f64> {
    let mut ptm = Cow::Borrowed(ptm);
    for edit in edits_of_planes(misreadings) {
        edit(ptm.to_mut());
    }
    let edits = edits_of(misreadings);
    let ptm = formula::stored(&ptm, Edits(&edits));
    let finals = formula::finals(&ptm, reading, Edits(&edits));
    formula::image(&finals, light.lu, light.lv, reading, Edits(&edits)).values
}

/// Returns the formulas that these mistakes compute differently; of two edits of one formula the later counts.
pub(crate) fn edits_of(misreadings: &[&Misreading]) -> Vec<&'static Edit> {
    let edits = misreadings
        .iter()
        .rev()
        .filter_map(|misreading| match misreading.at {
            At::Edits(edits) => Some(edits),
            _ => None,
        });
    edits.flatten().collect()
}

/// Applies the mistakes that change finished planes.
pub(crate) fn edits_of_planes(misreadings: &[&Misreading]) -> impl Iterator<Item = fn(&mut Ptm)> {
    misreadings
        .iter()
        .filter_map(|misreading| match misreading.at {
            At::Planes(edit) => Some(edit),
            _ => None,
        })
}
