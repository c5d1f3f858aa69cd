//! Profiles of readers.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::limits::Limit;
use super::unusual::UnusualKind;
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
    /// Name by which people know the program, if it differs from the repository.
    #[serde(default)]
    pub title: Option<String>,
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
    /// Behavior on kinds of files that the reference refuses.
    #[serde(default)]
    pub unusual: Vec<UnusualBehavior>,
}

/// A kind of evidence, the stronger one first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Evidence {
    /// The reader was run.
    Run,
    /// The source code of the reader was examined.
    Code,
}

impl Evidence {
    /// Returns the name used in `readers.yaml` and in machine-readable output.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Evidence::Run => "run",
            Evidence::Code => "code",
        }
    }

    /// Describes the evidence.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Evidence::Run => "the reader was run",
            Evidence::Code => "its source was read",
        }
    }
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

/// What a reader shows for a kind of file that the reference refuses.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UnusualBehavior {
    /// The kind of file.
    pub kind: UnusualKind,
    /// Short names of the formats that the row is about; empty for all formats.
    #[serde(default)]
    pub formats: Vec<String>,
    /// What the reader shows.
    pub shows: UnusualResult,
    /// The visible fault, if the reader shows a wrong image.
    #[serde(default, rename = "how")]
    pub fault: String,
    /// Evidence for the behavior.
    pub evidence: Evidence,
}

/// What a reader shows for a kind of file that the reference refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnusualResult {
    /// The same as for the corresponding legal file.
    Same,
    /// A wrong image.
    Wrong,
    /// No image.
    Nothing,
}

impl UnusualResult {
    /// Describes the behavior as a predicate: "the reader …".
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            UnusualResult::Same => "shows",
            UnusualResult::Wrong => "shows a wrong image of",
            UnusualResult::Nothing => "refuses",
        }
    }
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

    /// Returns the behavior on a kind of file, if it is known for the format. The format may be unknown, because versions other
    /// than 1.2 are not parsed.
    pub(super) fn behavior(
        &self,
        kind: UnusualKind,
        format: Option<Format>,
    ) -> Option<&UnusualBehavior> {
        let is_about = |row: &&UnusualBehavior| {
            let mut formats = row.formats.iter();
            row.formats.is_empty() || formats.any(|name| is_short_name(name, format))
        };
        let mut rows = self.unusual.iter().filter(|row| row.kind == kind);
        rows.find(is_about)
    }

    /// Returns the weakest evidence for the formats and for these misreadings.
    pub(super) fn evidence_for(&self, misreadings: &[&'static str]) -> Evidence {
        let rows = self.misreadings.iter();
        let rows = rows.filter(|row| misreadings.contains(&row.slug.as_str()));
        rows.map(|row| row.evidence)
            .fold(self.evidence, Evidence::max)
    }

    /// Returns the catalog entries of the reader's misreadings, in the order of the profile.
    pub(super) fn active_misreadings(&self) -> Vec<&'static Misreading> {
        let slugs = self.misreadings.iter().map(|known| &known.slug);
        slugs.filter_map(|slug| ptm_mistakes::find(slug)).collect()
    }

    /// Checks the names of formats and misreadings, and that the misreadings do not exclude each other.
    fn check(&self) -> Result<()> {
        let fail = |why: String| Error::impossible(format!("{}: {why}", self.name));
        let limited = self.unusual.iter().flat_map(|row| &row.formats);
        for name in self.formats.iter().chain(limited) {
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

fn is_short_name(name: &str, format: Option<Format>) -> bool {
    format.is_some_and(|format| format.short_name() == name)
}
