//! What the text says and leaves open: its clauses, and the rulings of the reference.

use serde::Deserialize;

use super::load::spec_file;
use crate::kit::yaml::from_yaml;

/// A rule of the text, in our words.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clause {
    /// Section and ordinal: `2.3/2`.
    pub id: String,
    /// The rule.
    pub rule: String,
    /// How it is covered.
    pub status: ClauseStatus,
    /// The ruling, where the status is `ruled`.
    pub ruling: Option<String>,
    /// The reason, where the clause is not tested.
    pub why: Option<String>,
}

/// How a clause is covered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ClauseStatus {
    /// By cases, and by a misreading that violates it and is caught.
    Tested,
    /// It is about something else than what a reader does.
    Informative,
    /// No file can show it.
    Untestable,
    /// By cases, under a ruling, because the text leaves it open.
    Ruled,
}

/// How the reference reads what the text leaves open.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ruling {
    /// A slug.
    pub id: String,
    /// The clauses concerned.
    pub clauses: Vec<String>,
    /// What is left open.
    pub question: String,
    /// The reference's own reading.
    pub reading: String,
    /// Other readings, where they are right too.
    #[serde(default)]
    pub also: Vec<String>,
    /// Who reads how, or what real files show.
    pub evidence: String,
    /// What it means for a verdict.
    pub kind: RulingKind,
}

/// What a ruling means for a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RulingKind {
    /// A decoder that reads otherwise fails.
    Must,
    /// Each listed reading is right, one of them throughout.
    Choice,
    /// Refusing and reading as the reference does are both right.
    Lenient,
    /// Any answer is right; it is reported.
    #[serde(rename = "implementation-defined")]
    ImplementationDefined,
}

impl RulingKind {
    /// As it is written.
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

/// The clauses of the text.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn clauses() -> Result<Vec<Clause>, String> {
    let files = [
        spec_file!("", "clauses.yaml"),
        spec_file!("", "clauses-2.9.yaml"),
    ];
    let read = |(name, text): (&str, &str)| {
        from_yaml::<Vec<Clause>>(text).map_err(|error| format!("{name}: {error}"))
    };
    Ok(files
        .into_iter()
        .map(read)
        .collect::<Result<Vec<_>, _>>()?
        .concat())
}

/// The rulings of the reference.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn rulings() -> Result<Vec<Ruling>, String> {
    from_yaml(include_str!("../../spec-cases/rulings.yaml"))
        .map_err(|error| format!("rulings.yaml: {error}"))
}
