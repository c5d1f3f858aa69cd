//! Records of misreadings.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

use super::hook::Hook;
use crate::formula::Edit;
use ptm_suite::kit::yaml;

/// A mistake: its record in `misreadings.yaml`, and the step that it changes. The PTM suite and the texture suite share the
/// record type, but have different steps.
#[derive(Clone, Debug)]
pub struct Misreading<A = Hook> {
    /// Permanent name of the misreading.
    pub slug: &'static str,
    /// Clause that the decoder misreads.
    pub clause: &'static str,
    /// What makes it a mistake: the clause, if the words of the specification suffice, or a ruling. Under a ruling of kind choice
    /// or lenient, the mistake is none of the correct readings. Only misreadings of PTM files state this.
    pub violates: Option<&'static str>,
    /// The ruling under which the behavior is correct, if it is no mistake. Such records describe public readers and writers, and
    /// are not in [`all`](super::all).
    pub reading_of: Option<&'static str>,
    /// Effect, as a sentence without a subject: "reads …".
    pub effect: &'static str,
    /// Suggested fix, as a sentence without a period.
    pub fix: &'static str,
    /// Symptom of the mistake.
    pub symptom: Symptom,
    /// Public decoders that make the mistake.
    pub sightings: Vec<Sighting>,
    /// Step that the mistake changes.
    pub step: A,
}

/// The way in which a mistake shows in the answers of a decoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Symptom {
    /// The mistake only causes refusals of legal files.
    Refusals,
    /// The mistake only causes malformed files to be accepted.
    Acceptances,
    /// The mistake changes values, or its symptoms depend on the file.
    #[default]
    Values,
}

/// A public decoder that makes a mistake.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sighting {
    /// Name of the decoder. For a repository, its owner and name.
    pub reader: String,
    /// Version that was examined, if known.
    pub version: Option<String>,
}

impl fmt::Display for Sighting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.version {
            Some(version) => write!(f, "{} at {version}", self.reader),
            None => f.write_str(&self.reader),
        }
    }
}

/// A record in `misreadings.yaml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MisreadingRecord {
    slug: String,
    clause: String,
    violates: Option<String>,
    reading_of: Option<String>,
    effect: String,
    fix: String,
    #[serde(default)]
    shows: Symptom,
    #[serde(default)]
    seen: Vec<Sighting>,
    /// Edits of formulas, indexed by the name of the formula.
    #[serde(default)]
    edits: BTreeMap<String, String>,
}

/// Joins each record in a YAML file with the step that the mistake changes: the step for its slug, or the step that
/// `step_from_edits` creates from its formula edits.
///
/// The strings are leaked, which is harmless because each catalog is created only once. Returns an error that names the
/// offending line.
pub fn load_catalog<A>(
    yaml: &str,
    step_from_slug: impl Fn(&str) -> Option<A>,
    step_from_edits: impl Fn(&'static [Edit]) -> Option<A>,
) -> Result<Vec<Misreading<A>>, String> {
    let mut all = Vec::new();
    for (line, record) in yaml::records::<MisreadingRecord>(yaml)? {
        let slug: &str = record.slug.leak();
        let edits = (record.edits.iter()).map(|(name, text)| Edit::parse(name, text));
        let edits: Vec<Edit> = edits
            .collect::<Result<_, _>>()
            .map_err(|error| format!("line {line}: {error}"))?;
        let step = match edits.is_empty() {
            true => step_from_slug(slug),
            false => step_from_edits(edits.leak()),
        };
        all.push(Misreading {
            slug,
            clause: record.clause.leak(),
            violates: record.violates.map(|violates| &*violates.leak()),
            reading_of: record.reading_of.map(|ruling| &*ruling.leak()),
            effect: record.effect.leak(),
            fix: record.fix.leak(),
            symptom: record.shows,
            sightings: record.seen,
            step: step.ok_or_else(|| format!("line {line}: {slug} has no step"))?,
        });
    }
    Ok(all)
}
