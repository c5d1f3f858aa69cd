//! A decoder with mistakes: what it answers.

use std::borrow::Cow;

use super::anatomy::{Anatomy, Seen};
use super::at::At;
use super::misreading::Misreading;
use crate::error::{Class, Error};
use crate::formula::{self, Edit, Edits};
use crate::protocol::frame::{Answer, Frame, View};
use crate::ptm::Ptm;
use crate::reading::Reading;

/// How a decoder with these mistakes answers, if it reads the open questions as `reading` does.
#[must_use]
pub fn answer(misreadings: &[&Misreading], reading: Reading, file: &[u8], view: &View) -> Answer {
    match read(misreadings, reading, file) {
        Ok((ptm, reading)) => show(misreadings, &reading, &ptm, view),
        Err(why) => refused(why),
    }
}

/// What is answered to a file that is not read; without a reason it is a mistake that refuses it.
pub(crate) fn refused(why: Option<Error>) -> Answer {
    match why {
        Some(error) if error.class() != Class::Malformed => Answer::Unsupported,
        _ => Answer::Rejected,
    }
}

/// What a decoder with these mistakes finds in a file, before its mistakes with finished planes, and how it goes on reading;
/// or why it refuses the file, where that is no mistake itself.
pub(crate) fn read(
    misreadings: &[&Misreading],
    reading: Reading,
    file: &[u8],
) -> Result<(Ptm, Reading), Option<Error>> {
    let reading = misread(misreadings, reading);
    let mut seen = Cow::Borrowed(file);
    for misreading in misreadings {
        if let At::Bytes(edit) = misreading.at {
            match edit(&Anatomy::of(&seen, &reading)) {
                Seen::Refused => return Err(None),
                Seen::File(bytes) => seen = Cow::Owned(bytes),
            }
        }
    }
    let edits = edits_of(misreadings);
    let ptm = formula::decode(&seen, &reading, Edits(&edits)).map_err(Some)?;
    Ok((ptm, reading))
}

/// `reading` with these mistakes in its decisions.
pub(crate) fn misread(misreadings: &[&Misreading], reading: Reading) -> Reading {
    misreadings
        .iter()
        .fold(reading, |reading, misreading| misreading.at.change(reading))
}

/// How a decoder with these mistakes, which `reading` has in it, shows what it found in a file.
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
    Answer::Decoded(Frame::edited(&ptm, view, reading, Edits(&edits)))
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

/// What these mistakes do to finished planes.
pub(crate) fn edits_of_planes(misreadings: &[&Misreading]) -> impl Iterator<Item = fn(&mut Ptm)> {
    misreadings
        .iter()
        .filter_map(|misreading| match misreading.at {
            At::Planes(edit) => Some(edit),
            _ => None,
        })
}
