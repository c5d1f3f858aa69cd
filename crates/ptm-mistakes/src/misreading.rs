//! Records of misreadings.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;

use super::change::Change;
use super::step::Step;
use crate::error::{Error, Result};
use crate::formula::{Edit, Formula, Stage};
use ptm_suite::kit::yaml;

/// A mistake: its record in `misreadings.yaml`, and the change that it makes. The PTM suite and the texture suite share the
/// record type, but have different changes.
#[derive(Clone, Debug)]
pub struct Misreading<A = Change> {
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
    /// Step that the mistake changes, unless it edits formulas. Only misreadings of PTM files state this.
    pub step: Option<&'static Step>,
    /// What a decoder with this mistake does differently.
    pub change: A,
}

impl<A> Misreading<A> {
    /// Creates a misreading outside the catalog: without slug, texts, and a named step.
    #[must_use]
    pub const fn unlisted(clause: &'static str, change: A) -> Misreading<A> {
        Misreading {
            slug: "",
            clause,
            violates: None,
            reading_of: None,
            effect: "",
            fix: "",
            symptom: Symptom::Values,
            sightings: Vec::new(),
            step: None,
            change,
        }
    }
}

impl Misreading {
    /// Returns the stage of decoding that the mistake changes.
    #[must_use]
    pub fn stage(&self) -> Stage {
        if let Change::Edits(edits) = self.change {
            let stages = edits.iter().map(|edit| edit.formula.stage());
            return stages.min().unwrap_or(Stage::Color);
        }
        self.step.map_or(Stage::File, |step| step.stage)
    }

    /// Returns true if the mistake may cause a refusal. Other mistakes only change values.
    #[must_use]
    pub fn may_refuse(&self) -> bool {
        if let Change::Edits(edits) = self.change {
            return edits.iter().any(|edit| edit.formula.may_refuse());
        }
        self.step.is_none_or(|step| step.may_refuse)
    }

    /// Returns the formulas that the mistake changes.
    #[must_use]
    pub fn formulas(&self) -> Vec<Formula> {
        if let Change::Edits(edits) = self.change {
            return edits.iter().map(|edit| edit.formula).collect();
        }
        self.step.map_or_else(Vec::new, Step::formulas)
    }

    /// Returns true if both mistakes change the same step: the bytes, the decoded map, a decision or a formula.
    #[must_use]
    pub fn changes_same_step(&self, other: &Misreading) -> bool {
        match (self.step, other.step) {
            (Some(step), Some(other)) => step == other,
            // Two mistakes that edit different formulas change different steps.
            _ => !self.formulas().is_empty() && self.formulas() == other.formulas(),
        }
    }

    /// Returns true if the mistake changes a decision of `Reading` or edits formulas. A decoder makes each decision in only one
    /// way.
    #[must_use]
    pub const fn is_decision(&self) -> bool {
        !matches!(self.change, Change::Bytes(_) | Change::Map(_))
    }
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
    /// Name of the step that a function changes.
    step: Option<String>,
    /// Edits of formulas, indexed by the name of the formula.
    #[serde(default)]
    edits: BTreeMap<String, String>,
}

/// Joins each record in a YAML file with the change that the mistake makes: the change for its slug, or the change that
/// `change_from_edits` creates from its formula edits.
///
/// The strings are leaked, which is harmless because each catalog is created only once. Returns an error that names the
/// offending line.
pub fn load_catalog<A>(
    yaml: &str,
    change_from_slug: impl Fn(&str) -> Option<A>,
    change_from_edits: impl Fn(&'static [Edit]) -> Option<A>,
) -> Result<Vec<Misreading<A>>> {
    let mut all = Vec::new();
    for (line, record) in yaml::records::<MisreadingRecord>(yaml)? {
        let slug: &str = record.slug.leak();
        let at_line = |message: String| Error::Record { line, message };
        let mut edits = Vec::new();
        for (name, text) in &record.edits {
            edits.push(Edit::parse(name, text).map_err(|error| at_line(error.to_string()))?);
        }
        let change = if edits.is_empty() {
            change_from_slug(slug)
        } else {
            change_from_edits(edits.leak())
        };
        let find_step =
            |name: String| Step::find(&name).ok_or_else(|| at_line(format!("unknown step {name}")));
        all.push(Misreading {
            slug,
            clause: record.clause.leak(),
            violates: record.violates.map(|violates| &*violates.leak()),
            reading_of: record.reading_of.map(|ruling| &*ruling.leak()),
            effect: record.effect.leak(),
            fix: record.fix.leak(),
            symptom: record.shows,
            sightings: record.seen,
            step: record.step.map(find_step).transpose()?,
            change: change.ok_or_else(|| at_line(format!("{slug} is not implemented")))?,
        });
    }
    Ok(all)
}
