//! The clauses of the text, and the rulings of the reference on what it leaves open.

use serde::Deserialize;

use crate::kit::{embedded, yaml::from_yaml};

/// A rule of the specification, in our own words.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clause {
    /// Section and ordinal: `2.3/2`.
    pub id: String,
    /// The rule.
    pub rule: String,
    /// The way it is covered.
    pub status: ClauseStatus,
    /// The ruling, if the status is `ruled`.
    pub ruling: Option<String>,
    /// The reason, if the clause is not tested.
    pub why: Option<String>,
}

/// The way a clause is covered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClauseStatus {
    /// By cases, and by a misreading that violates it and is caught.
    Tested,
    /// It is not about the behavior of a reader.
    Informative,
    /// No file can show it.
    Untestable,
    /// By cases, under a ruling, because the text leaves it open.
    Ruled,
}

/// The decision of the reference on a point that the text leaves open.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ruling {
    /// A slug.
    pub id: String,
    /// The clauses that it concerns.
    pub clauses: Vec<String>,
    /// The open question.
    pub question: String,
    /// The reading of the reference.
    pub reading: String,
    /// Other readings, if they are right too.
    #[serde(default)]
    pub also: Vec<String>,
    /// The behavior of known readers, or properties of real files.
    pub evidence: String,
    /// The effect on verdicts.
    pub kind: RulingKind,
}

/// The effect of a ruling on verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RulingKind {
    /// A decoder with another reading fails.
    Must,
    /// Each listed reading is right, if used throughout.
    Choice,
    /// The file may be refused, or read as by the reference.
    Lenient,
    /// Any answer is right; it is reported.
    #[serde(rename = "implementation-defined")]
    ImplementationDefined,
}

impl RulingKind {
    /// Returns its name.
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

/// Returns the clauses of the text.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn clauses() -> Result<Vec<Clause>, String> {
    let files = embedded!["spec-cases", "clauses.yaml", "clauses-2.9.yaml"];
    let read = |(name, text): &(&str, &str)| {
        from_yaml::<Vec<Clause>>(text).map_err(|error| format!("{name}: {error}"))
    };
    let files: Result<Vec<_>, _> = files.iter().map(read).collect();
    Ok(files?.concat())
}

/// Returns the rulings of the reference.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn rulings() -> Result<Vec<Ruling>, String> {
    from_yaml(include_str!("../../spec-cases/rulings.yaml"))
        .map_err(|error| format!("rulings.yaml: {error}"))
}
