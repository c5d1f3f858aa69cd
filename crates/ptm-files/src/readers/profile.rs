//! Profiles of readers.

use std::sync::LazyLock;

use serde::Deserialize;

use super::limits::Limit;
use crate::error::{Error, Result};
use ptm::Format;
use ptm_mistakes::Misreading;
use ptm_suite::kit::yaml;

/// A reader, as described in `readers.yaml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReaderProfile {
    /// Short name by which the reader is selected.
    pub name: String,
    /// Repository (owner and name), or the name of a reader that has no repository.
    pub reader: String,
    /// Version or commit that was examined, if known.
    pub version: Option<String>,
    /// Short names of the supported formats.
    #[serde(rename = "reads")]
    pub formats: Vec<String>,
    /// Evidence for the supported formats.
    pub evidence: Evidence,
    /// Misreadings of the reader.
    #[serde(default)]
    pub misreadings: Vec<KnownMisreading>,
    /// Other limits of the reader.
    #[serde(default)]
    pub limits: Vec<KnownLimit>,
}

/// A kind of evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Evidence {
    /// The reader was run on the cases of the suite.
    Run,
    /// The source code of the reader was examined.
    Code,
}

/// A known misreading of a reader.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownMisreading {
    /// The slug of the misreading in `misreadings.yaml`.
    pub slug: String,
    /// Evidence for the misreading.
    pub evidence: Evidence,
}

/// A known limit of a reader.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownLimit {
    /// The known limit.
    pub limit: Limit,
    /// Evidence for the limit.
    pub evidence: Evidence,
}

static ALL: LazyLock<Vec<ReaderProfile>> = LazyLock::new(|| {
    parse_profiles(ptm_spec_cases::READERS)
        .unwrap_or_else(|error| unreachable!("invalid embedded readers.yaml: {error}"))
});

/// Returns the known readers.
#[must_use]
pub fn profiles() -> &'static [ReaderProfile] {
    &ALL
}

/// Parses a file such as `readers.yaml`.
///
/// # Errors
/// Returns a message that names the offending line or reader.
pub fn parse_profiles(text: &str) -> Result<Vec<ReaderProfile>> {
    let records = yaml::records::<ReaderProfile>(text)?;
    let profiles: Vec<ReaderProfile> = records.into_iter().map(|(_, profile)| profile).collect();
    for profile in &profiles {
        profile.check()?;
    }
    Ok(profiles)
}

impl ReaderProfile {
    /// Returns true if the reader supports a format.
    #[must_use]
    pub fn reads(&self, format: Format) -> bool {
        self.formats.iter().any(|name| name == format.short_name())
    }

    /// Returns the catalog entries of the reader's misreadings, in the order of the profile.
    pub(super) fn active_misreadings(&self) -> Vec<&'static Misreading> {
        let slugs = self.misreadings.iter().map(|known| &known.slug);
        slugs.filter_map(|slug| ptm_mistakes::find(slug)).collect()
    }

    fn check(&self) -> Result<()> {
        let fail = |why: String| Error::impossible(format!("{}: {why}", self.name));
        for name in &self.formats {
            if !Format::ALL.iter().any(|format| format.short_name() == name) {
                return fail(format!("unknown format {name}"));
            }
        }
        for known in &self.misreadings {
            if ptm_mistakes::find(&known.slug).is_none() {
                return fail(format!("unknown misreading {}", known.slug));
            }
        }
        // If two misreadings changed the same decision, the second would replace the first.
        let mut seen: Vec<&Misreading> = Vec::new();
        for misreading in self.active_misreadings() {
            if !misreading.is_decision() {
                continue;
            }
            if let Some(other) = seen
                .iter()
                .find(|other| other.changes_same_step(misreading))
            {
                let (first, second) = (other.slug, misreading.slug);
                return fail(format!("{first} and {second} change the same decision"));
            }
            seen.push(misreading);
        }
        Ok(())
    }
}
