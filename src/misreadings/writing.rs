//! The mistakes of the catalog, made by writers.
//!
//! `spec-cases/writers/mistakes.yaml` has the texts; slug and clause are those of the misreading.

use std::sync::LazyLock;

use serde::Deserialize;

use super::misreading::Misreading;
use crate::kit::yaml;

/// A mistake of a writer, in the place where a reader misreads.
pub type Miswriting = Misreading<&'static Misreading>;

/// A record of the YAML file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WritingWords {
    slug: String,
    effect: String,
    fix: String,
}

/// The catalog, read on first use.
static ALL: LazyLock<Vec<Miswriting>> = LazyLock::new(|| {
    let yaml = include_str!("../../spec-cases/writers/mistakes.yaml");
    read(yaml).unwrap_or_else(|error| unreachable!("mistakes.yaml, which a test reads: {error}"))
});

fn read(yaml: &str) -> Result<Vec<Miswriting>, String> {
    let records = yaml::records::<WritingWords>(yaml)?.into_iter();
    let join = |(line, words): (usize, WritingWords)| {
        let reader = super::find(&words.slug)
            .ok_or_else(|| format!("line {line}: unknown misreading {}", words.slug))?;
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

/// Returns all mistakes of writers, in the order of the sections.
pub fn all() -> impl Iterator<Item = &'static Miswriting> {
    ALL.iter()
}

/// Returns the mistake with this slug.
#[must_use]
pub fn find(slug: &str) -> Option<&'static Miswriting> {
    all().find(|mistake| mistake.slug == slug)
}
