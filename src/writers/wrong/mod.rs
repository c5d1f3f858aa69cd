//! What a writer with a mistake writes: the catalog of misreadings from the other side.
//!
//! A writer misunderstands a clause as a reader does, and its file is right for such a reader alone; or it loses on the
//! way to the file what such a reader loses on the way from it. Either way the file is made here by undoing or repeating
//! the misreading, and nothing is taken for such a file that has not been read back under it.

mod header;

mod samples;

mod streams;

mod table;

mod text;

use crate::decode::fields;
use crate::misreadings::{Anatomy, At, Misreading, Seen};
use crate::reading::Reading;
use crate::writers::reference::written;
use crate::writers::request::WriteRequest;
use crate::writers::seen::SeenFile;

/// The file that a writer with this mistake writes; nothing where the mistake does not show in this request.
#[must_use]
pub fn miswritten(request: &WriteRequest, mistake: &Misreading) -> Option<Vec<u8>> {
    let right = written(request).ok()?;
    let candidates: Vec<Vec<u8>> = match mistake.at {
        At::Planes(edit) => samples::edited(request, edit),
        At::StoredRow(row) => samples::in_rows(request, row),
        At::Blocks(blocks) => [
            samples::in_blocks(request, &right, blocks),
            table::with_blocks(request, blocks),
        ]
        .concat(),
        At::Bytes(edit) => {
            let seen = match edit(&Anatomy::of(&right, &Reading::SPEC)) {
                Seen::File(bytes) => Some(bytes),
                Seen::Refused => None,
            };
            let more = [
                text::candidates(request, &right),
                table::candidates(request),
            ];
            seen.into_iter().chain(more.concat()).collect()
        }
        At::Indices(_) | At::Index(_) | At::Entry(_) => table::candidates(request),
        _ if mistake.at.stage() > crate::misreadings::Stage::Planes => header::candidates(request),
        _ => streams::candidates(request, &right, mistake),
    };
    candidates.into_iter().find(|file| {
        let is_right = |seen: SeenFile| seen.is_right(request);
        *file != right
            && explains(request, &right, file, mistake)
            && !SeenFile::of(file, &[]).is_some_and(is_right)
    })
}

/// Whether a wrong file is one that a writer with this mistake writes. `right` is the reference's.
pub(super) fn explains(
    request: &WriteRequest,
    right: &[u8],
    file: &[u8],
    mistake: &Misreading,
) -> bool {
    is_right_under(request, file, &[mistake]) || is_lost(right, file, mistake)
}

/// Whether a reader with these mistakes has the right values of a file, and one without them has not.
pub(super) fn is_right_under(
    request: &WriteRequest,
    file: &[u8],
    mistakes: &[&Misreading],
) -> bool {
    let is_right = |seen: SeenFile| seen.is_right(request);
    SeenFile::of(file, mistakes).is_some_and(is_right)
        && !SeenFile::plainly(file, mistakes).is_some_and(is_right)
}

/// Whether the file has what a reader with this mistake makes of the right one, and what no other makes of it.
fn is_lost(right: &[u8], file: &[u8], mistake: &Misreading) -> bool {
    let is_written = |seen: SeenFile| seen.is_written_as_seen(file);
    let is_seen = || {
        SeenFile::of(right, &[mistake]).is_some_and(is_written)
            && !SeenFile::plainly(right, &[mistake]).is_some_and(is_written)
    };
    match mistake.at {
        At::Bytes(edit) => match edit(&Anatomy::of(right, &Reading::SPEC)) {
            Seen::File(seen) => {
                let lost = payload(&seen);
                (lost != payload(right) && lost == payload(file) && has_numbers(file)) || is_seen()
            }
            Seen::Refused => false,
        },
        At::Planes(_)
        | At::FinalCoefficient(_)
        | At::LumMatrix(_)
        | At::LumTranslation(_)
        | At::Clamp(_) => is_seen(),
        _ => false,
    }
}

/// Whether all scales and biases can be read, so that it is the payload that is wrong.
fn has_numbers(file: &[u8]) -> bool {
    let (fields, _) = fields(file);
    let biases = fields.iter().filter(|field| field.clause == "2.4/4");
    biases.count() == 6
}

/// What follows the header.
fn payload(file: &[u8]) -> &[u8] {
    &file[Anatomy::of(file, &Reading::SPEC).payload()..]
}
