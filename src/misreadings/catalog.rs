//! The catalog of all misreadings of the PTM suite.

use std::sync::LazyLock;

use super::at::At;
use super::misreading::{Misreading, load_catalog};
use super::{
    buffers, codecs, header, layout, lists, lookup, luminance, motion, places, prediction,
    side_information, transforms,
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
    ];
    let yaml = include_str!("../../spec-cases/misreadings.yaml");
    load_catalog(yaml, sections.into_iter().flatten(), |edits| {
        Some(At::Edits(edits))
    })
    .unwrap_or_else(|error| unreachable!("misreadings.yaml, which a test reads: {error}"))
});

/// Returns all misreadings, in the order of sections.
pub fn all() -> impl Iterator<Item = &'static Misreading> {
    ALL.iter()
}

/// Returns the misreading with this slug, if any.
#[must_use]
pub fn find(slug: &str) -> Option<&'static Misreading> {
    all().find(|misreading| misreading.slug == slug)
}
