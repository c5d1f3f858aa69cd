//! The changes that turn the reference decoder into a decoder with a mistake.

use super::anatomy::{Anatomy, EditedFile};
use crate::formula::Edit;
use ptm::Ptm;
use ptm::reading::Reading;

/// Function that returns the change for a slug in one section, or `None` for other slugs. Slugs are in `misreadings.yaml` order.
pub type Changes = fn(slug: &str) -> Option<Change>;

/// What a decoder with a mistake does differently.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// Changes the bytes of the file.
    Bytes(fn(&Anatomy) -> EditedFile),
    /// Replaces a decision of the reading.
    Reading(fn(&mut Reading)),
    /// Changes the decoded map.
    Map(fn(&mut Ptm)),
    /// Edits formulas.
    Edits(&'static [Edit]),
}
