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
    let seen = SeenFile::of(file, &[mistake]);
    seen.is_some_and(|seen| seen.is_right(request)) || is_lost(right, file, mistake)
}

/// Whether the file has what a reader with this mistake makes of the right one.
fn is_lost(right: &[u8], file: &[u8], mistake: &Misreading) -> bool {
    match mistake.at {
        At::Bytes(edit) => match edit(&Anatomy::of(right, &Reading::SPEC)) {
            Seen::File(seen) => {
                let lost = payload(&seen);
                lost != payload(right) && lost == payload(file)
            }
            Seen::Refused => false,
        },
        At::Planes(_)
        | At::FinalCoefficient(_)
        | At::LumMatrix(_)
        | At::LumTranslation(_)
        | At::Clamp(_) => {
            SeenFile::of(right, &[mistake]).is_some_and(|seen| seen.is_written_as_seen(file))
        }
        _ => false,
    }
}

/// What follows the header.
fn payload(file: &[u8]) -> &[u8] {
    &file[Anatomy::of(file, &Reading::SPEC).payload()..]
}
