//! The catalog of all misreadings of the PTM suite.

use std::sync::LazyLock;

use super::hook::Hook;
use super::misreading::{Misreading, load_catalog};
use super::{
    buffers, codecs, header, layout, lists, lookup, luminance, motion, places, prediction,
    side_information, transforms,
};

/// The catalog, loaded on first use.
static ALL: LazyLock<Vec<Misreading>> = LazyLock::new(|| {
    let sections = [
        header::STEPS,
        buffers::STEPS,
        lookup::STEPS,
        luminance::STEPS,
        layout::STEPS,
        lists::STEPS,
        transforms::STEPS,
        motion::STEPS,
        prediction::STEPS,
        places::STEPS,
        side_information::STEPS,
        codecs::STEPS,
    ];
    let yaml = ptm_spec_cases::MISREADINGS;
    let step_of = |slug: &str| sections.iter().find_map(|step_of| step_of(slug));
    load_catalog(yaml, step_of, |edits| Some(Hook::Edits(edits)))
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
