//! Clauses of the specification, and rulings on the questions that it leaves open.

use crate::error::Result;
use serde::Deserialize;

use crate::kit::yaml::from_files;

/// A rule of the specification, in our own words.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clause {
    /// Section and ordinal, such as `2.3/2`.
    pub id: String,
    /// The rule.
    pub rule: String,
    /// Coverage of the clause.
    pub status: ClauseStatus,
    /// The ruling, if the status is `ruled`.
    pub ruling: Option<String>,
    /// The reason why the clause is not tested, if it is not.
    pub why: Option<String>,
}

/// Coverage of a clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClauseStatus {
    /// Tested by cases that catch a misreading of the clause.
    Tested,
    /// The clause is not about the behavior of a reader.
    Informative,
    /// No file can reveal whether a reader follows the clause.
    Untestable,
    /// Tested by cases under a ruling, because the text leaves the question open.
    Ruled,
}

/// The decision of the reference on a point that the text leaves open.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ruling {
    /// Slug of the ruling.
    pub id: String,
    /// Clauses that the ruling interprets.
    pub clauses: Vec<String>,
    /// The open question.
    pub question: String,
    /// The reading of the reference.
    pub reading: String,
    /// Other readings that are also correct.
    #[serde(default, rename = "also")]
    pub alternatives: Vec<String>,
    /// Field of `Reading` whose function decides a choice about PTM files.
    pub step: Option<String>,
    /// The behavior of known readers, or properties of real files.
    pub evidence: String,
    /// The effect on verdicts.
    pub kind: RulingKind,
    /// The reason why a ruling of kind [`RulingKind::Must`] may fail a decoder. The rulings of the texture suite have none: there,
    /// each case has a basis.
    pub rests_on: Option<Basis>,
}

/// The reason why another reading of a ruling fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// The words of the specification, or of a standard that it names, leave no other reading.
    Text,
    /// A real file decides.
    File,
    /// Independent public readers decide.
    Readers,
    /// The text gives the file no value, so any image is wrong.
    Undefined,
}

impl Basis {
    /// Returns the name used in `rulings.yaml`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Basis::Text => "text",
            Basis::File => "file",
            Basis::Readers => "readers",
            Basis::Undefined => "undefined",
        }
    }

    /// Describes the basis, as a sentence without a period.
    #[must_use]
    pub const fn describe(self) -> &'static str {
        match self {
            Basis::Text => {
                "the words of the specification, or of a standard that it names, leave no other reading"
            }
            Basis::File => "a real file decides it, by the measurement in the evidence",
            Basis::Readers => {
                "independent public readers decide it; readers that decide otherwise contradict themselves or another clause"
            }
            Basis::Undefined => {
                "the text gives such a file no value, so a refusal or \"unsupported\" is correct, and any image is wrong"
            }
        }
    }
}

/// The effect of a ruling on verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RulingKind {
    /// A decoder with a different reading fails.
    Must,
    /// Each listed reading is correct if it is used throughout.
    Choice,
    /// The file may be refused, or read as the reference reads it.
    Lenient,
    /// Any answer is correct, and a difference is reported.
    #[serde(rename = "implementation-defined")]
    ImplementationDefined,
}

impl RulingKind {
    /// Returns the name used in documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            RulingKind::Must => "must",
            RulingKind::Choice => "choice",
            RulingKind::Lenient => "lenient",
            RulingKind::ImplementationDefined => "implementation-defined",
        }
    }
}

/// Returns the section of a clause: `2.4` for `2.4/8`, `R-TBL` for `R-TBL-04`.
#[must_use]
pub fn section_of(clause: &str) -> &str {
    let ends = clause.split_once('/').or_else(|| clause.rsplit_once('-'));
    ends.map_or(clause, |(section, _)| section)
}

/// Returns all clauses, in the order of the specification.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn clauses() -> Result<Vec<Clause>> {
    Ok(from_files::<Vec<Clause>>(ptm_spec_cases::CLAUSES)?.concat())
}

/// Returns all rulings.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn rulings() -> Result<Vec<Ruling>> {
    Ok(from_files::<Vec<Ruling>>(ptm_spec_cases::RULINGS)?.concat())
}
