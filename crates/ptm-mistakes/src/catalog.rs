//! The catalog of all misreadings of the PTM suite.

use std::sync::LazyLock;

use super::change::Change;
use super::misreading::{Misreading, load_catalog};
use super::{
    buffers, codecs, header, layout, lists, lookup, luminance, motion, places, precision,
    prediction, side_information, transforms,
};

/// The catalog, loaded on first use.
static ALL: LazyLock<Vec<Misreading>> = LazyLock::new(|| {
    let sections = [
        header::CHANGES,
        buffers::CHANGES,
        lookup::CHANGES,
        luminance::CHANGES,
        layout::CHANGES,
        lists::CHANGES,
        transforms::CHANGES,
        motion::CHANGES,
        prediction::CHANGES,
        places::CHANGES,
        side_information::CHANGES,
        codecs::CHANGES,
        precision::CHANGES,
    ];
    let yaml = ptm_spec_cases::MISREADINGS;
    let change_of = |slug: &str| sections.iter().find_map(|changes| changes(slug));
    load_catalog(yaml, change_of, |edits| Some(Change::Edits(edits)))
        .unwrap_or_else(|error| unreachable!("invalid embedded misreadings.yaml: {error}"))
});

/// Returns all misreadings, in the order of sections.
pub fn all() -> impl Iterator<Item = &'static Misreading> {
    behaviors().filter(|behavior| behavior.reading_of.is_none())
}

/// Returns all misreadings, and the readings of open questions that public readers and writers have.
pub fn behaviors() -> impl Iterator<Item = &'static Misreading> {
    ALL.iter()
}

/// Returns the misreading or the reading with this slug, if any.
#[must_use]
pub fn find(slug: &str) -> Option<&'static Misreading> {
    behaviors().find(|behavior| behavior.slug == slug)
}
