//! The catalog from the other side: what a writer does that makes the same mistake.
//!
//! `spec-cases/writers/mistakes.yaml` has the words; slug and clause are those of the misreading.

use std::sync::LazyLock;

use serde::Deserialize;

use super::misreading::Misreading;
use crate::kit::yaml;

/// A mistake of a writer. It acts where a reader misreads.
pub type Miswriting = Misreading<&'static Misreading>;

/// A mistake as the YAML has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Words {
    slug: String,
    effect: String,
    fix: String,
}

/// Read when the first one is asked for, once.
static ALL: LazyLock<Vec<Miswriting>> = LazyLock::new(|| {
    let yaml = include_str!("../../spec-cases/writers/mistakes.yaml");
    read(yaml).unwrap_or_else(|error| unreachable!("mistakes.yaml, which a test reads: {error}"))
});

fn read(yaml: &str) -> Result<Vec<Miswriting>, String> {
    let records = yaml::records::<Words>(yaml)?.into_iter();
    let join = |(line, words): (usize, Words)| {
        let reader = super::named(&words.slug)
            .ok_or_else(|| format!("line {line}: no misreading is called {}", words.slug))?;
        Ok(Misreading {
            slug: reader.slug,
            clause: reader.clause,
            effect: words.effect.leak(),
            fix: words.fix.leak(),
            shows: reader.shows,
            seen: Vec::new(),
            at: reader,
        })
    };
    records.map(join).collect()
}

/// All mistakes of writers, in the order of the sections.
pub fn all() -> impl Iterator<Item = &'static Miswriting> {
    ALL.iter()
}

/// The mistake of that name.
#[must_use]
pub fn named(slug: &str) -> Option<&'static Miswriting> {
    all().find(|mistake| mistake.slug == slug)
}
