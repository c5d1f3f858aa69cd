//! Writing mistakes that correspond to misreadings in the catalog.
//!
//! The mistakes are described in `spec-cases/writers/mistakes.yaml`. A mistake has the same slug and clause as its misreading.

use std::sync::LazyLock;

use serde::Deserialize;

use super::misreading::Misreading;
use crate::error::{Error, Result};
use ptm_suite::kit::yaml;

/// A writer's mistake that corresponds to a misreading.
pub type WriterMistake = Misreading<&'static Misreading>;

/// A record in `mistakes.yaml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WriterMistakeRecord {
    slug: String,
    effect: String,
    fix: String,
}

/// The catalog, loaded on first use.
static ALL: LazyLock<Vec<WriterMistake>> = LazyLock::new(|| {
    let yaml = ptm_spec_cases::writers::MISTAKES;
    read(yaml).unwrap_or_else(|error| unreachable!("invalid embedded mistakes.yaml: {error}"))
});

fn read(yaml: &str) -> Result<Vec<WriterMistake>> {
    let records = yaml::records::<WriterMistakeRecord>(yaml)?.into_iter();
    let join = |(line, record): (usize, WriterMistakeRecord)| {
        let misreading = super::find(&record.slug).ok_or_else(|| Error::Record {
            line,
            message: format!("unknown misreading {}", record.slug),
        })?;
        Ok(Misreading {
            slug: misreading.slug,
            clause: misreading.clause,
            violates: None,
            reading_of: None,
            effect: record.effect.leak(),
            fix: record.fix.leak(),
            symptom: misreading.symptom,
            sightings: Vec::new(),
            step: misreading.step,
            change: misreading,
        })
    };
    records.map(join).collect()
}

/// Returns all writing mistakes, in section order.
pub fn all() -> impl Iterator<Item = &'static WriterMistake> {
    ALL.iter()
}

/// Returns the mistake with this slug, if any.
#[must_use]
pub fn find(slug: &str) -> Option<&'static WriterMistake> {
    all().find(|mistake| mistake.slug == slug)
}
