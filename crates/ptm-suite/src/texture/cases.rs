//! The embedded suite of texture cases, and case files in the same format.

use std::collections::BTreeSet;
use std::fmt;

use crate::error::{Error, Result};
use std::sync::OnceLock;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::cases::{Expect, Suite};
use crate::clauses::{Clause, Ruling};
use crate::dialect::{Axis, RightDialects};
use crate::kit::digest::sha256;
use crate::kit::yaml::{from_files, from_yaml};
use crate::name::SuiteName;
use crate::test_case::{Listed, Output};
use crate::texture::choices::CHOICES;
use crate::texture::fixtures;
use crate::texture::question::{Question, Refusal};

/// A question with its expected answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextureCase {
    /// Permanent id.
    pub id: String,
    /// Tested requirements, the most relevant first.
    #[serde(alias = "req")]
    pub clauses: Vec<String>,
    /// Basis of the expected answer.
    pub basis: Basis,
    /// The ruling, if the text of the chapter does not determine the answer.
    pub ruling: Option<String>,
    /// The requested step.
    pub op: String,
    /// The arguments of the step; maps may be given by name.
    #[serde(default)]
    pub given: Value,
    /// Expected answer.
    pub expect: Value,
    /// Expected answers under other readings.
    #[serde(default, rename = "also", alias = "alt")]
    pub alternatives: Vec<OtherAnswer>,
    /// Tolerance for numbers, if it is not the default.
    #[serde(rename = "tol")]
    pub tolerance: Option<f64>,
    /// Purpose of the case, usually with the arithmetic.
    #[serde(alias = "why")]
    pub because: String,
    /// True if the case is requested before all others, to check that the program answers at all.
    #[serde(default)]
    pub first: bool,
    /// Parsed question, computed at first use.
    #[serde(skip)]
    parsed_question: OnceLock<Result<Question, Refusal>>,
    /// Choices whose readings change the answer, computed at first use.
    #[serde(skip)]
    pub(super) relevant_axes: OnceLock<Vec<Axis>>,
}

/// The basis of an expected answer.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// The text of the chapter.
    Text,
    /// Another public text about PEX.
    Sibling,
    /// A lost formula without a known alternative, reconstructed from the chapter and related texts.
    Inferred,
    /// One of several readings.
    Reading,
    /// Left to the implementation.
    Impl,
}

/// Expected answer under another reading.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherAnswer {
    /// Name of the reading.
    pub reading: String,
    /// Fields that select this reading in the reference.
    #[serde(default)]
    pub given: Value,
    /// Expected answer under this reading.
    pub expect: Value,
}

impl Suite<TextureCase> {
    /// Loads the embedded suite of texture questions.
    ///
    /// # Errors
    /// Returns a message that names the file and the error.
    pub fn load_texture() -> Result<Suite<TextureCase>> {
        let mut cases = Vec::new();
        for (name, text) in ptm_spec_cases::texture::CASES {
            cases.extend(parse_cases(text).map_err(|error| error.in_place(name))?);
        }
        Ok(Suite { cases })
    }
}

/// Parses a case file: a list, or a document with a list under `cases`.
///
/// # Errors
/// Returns the error and its location.
pub fn parse_cases(text: &str) -> Result<Vec<TextureCase>> {
    let file: Value = from_yaml(text)?;
    let cases = match file {
        Value::Array(cases) => cases,
        Value::Object(mut file) => match file.remove("cases") {
            Some(Value::Array(cases)) => cases,
            _ => return Error::invalid("expected a list under \"cases\""),
        },
        _ => return Error::invalid("expected a list of cases"),
    };
    let read = |(number, value): (usize, Value)| {
        let name = value["id"].as_str().unwrap_or("no id").to_owned();
        serde_json::from_value(value)
            .map_err(|error| format!("case {} ({name}): {error}", number + 1).into())
    };
    cases.into_iter().enumerate().map(read).collect()
}

impl TextureCase {
    /// Returns the JSON object that is sent.
    #[must_use]
    pub fn question(&self) -> Value {
        let given = match &self.given {
            Value::Null => json!({}),
            given => fixtures::expand_maps(given),
        };
        json!({ "op": self.op, "given": given })
    }

    /// Returns the file that is sent.
    #[must_use]
    pub fn to_file(&self) -> Vec<u8> {
        format!("{}\n", self.question()).into_bytes()
    }

    /// Returns the kind of the expected answer.
    #[must_use]
    pub fn expectation(&self) -> Expect {
        match self.basis {
            _ if self.must_be_refused() => Expect::Reject,
            Basis::Impl => Expect::ImplementationDefined,
            _ => Expect::Decode,
        }
    }

    /// Returns the step and, if the question contains a PTM, the feature for PTM maps.
    #[must_use]
    pub fn features(&self) -> BTreeSet<String> {
        let mut features = BTreeSet::from([self.op.clone()]);
        if self.given.to_string().contains("\"ptm\"") {
            features.insert("PTM maps".to_owned());
        }
        features
    }

    /// Compares an answer with the expected one. Returns the dialects in which it is right, and the difference from the answer of
    /// the reference.
    #[must_use]
    pub fn compare(&self, answer: &Value) -> (RightDialects, Option<String>) {
        let difference = self.expected(&CHOICES.reference()).difference(answer);
        let axes = self.relevant_axes();
        let right = if !axes.is_empty() {
            RightDialects::Depends {
                axes: axes.to_vec(),
                in_reference: difference.is_none(),
            }
        } else if self.must_be_refused() {
            // Any error message is accepted.
            RightDialects::Regardless(answer.get("error").is_some())
        } else {
            RightDialects::Regardless(difference.is_none())
        };
        (right, difference)
    }

    /// Returns the parsed question.
    ///
    /// # Errors
    /// Returns an error if the case does not contain a valid question.
    pub fn read(&self) -> Result<&Question, Refusal> {
        let read = || Question::from_value(&self.question());
        let question = self.parsed_question.get_or_init(read);
        question.as_ref().map_err(Refusal::clone)
    }
}

/// The single view of texture questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureView;

impl fmt::Display for TextureView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("texture")
    }
}

impl Output for Value {}

impl Listed for TextureCase {
    const SUITE: SuiteName = SuiteName::Texture;

    fn id(&self) -> &str {
        &self.id
    }

    fn clauses(&self) -> &[String] {
        &self.clauses
    }

    fn because(&self) -> String {
        let text = format!("{}: {}", self.op, self.because);
        match (self.basis, &self.ruling) {
            (Basis::Inferred, Some(ruling)) => format!(
                "{text}\nThe formula of the chapter is lost; ruling {ruling} gives a replacement and the reasons for it."
            ),
            _ => text,
        }
    }

    fn expectation_name(&self) -> &'static str {
        match self.basis {
            _ if self.must_be_refused() => "reject",
            Basis::Reading => "choice",
            Basis::Impl => "implementation-defined",
            Basis::Text | Basis::Sibling | Basis::Inferred => "value",
        }
    }

    fn digest(suite: &Suite<TextureCase>) -> String {
        let text = |case: &TextureCase| format!("{}{}{}", case.id, case.question(), case.expect);
        sha256(suite.cases.iter().map(text).collect::<String>().as_bytes())
    }

    fn reference_readings() -> Vec<(&'static str, &'static str)> {
        CHOICES.reference_readings()
    }
}

/// Returns the requirements of the texture mapping chapter.
///
/// # Errors
/// Returns a message that describes the error in the file.
pub fn clauses() -> Result<Vec<Clause>> {
    Ok(from_files::<Vec<Clause>>(ptm_spec_cases::texture::CLAUSES)?.concat())
}

/// Returns the rulings on open questions of the texture mapping chapter.
///
/// # Errors
/// Returns a message that describes the error in the file.
pub fn rulings() -> Result<Vec<Ruling>> {
    Ok(from_files::<Vec<Ruling>>(ptm_spec_cases::texture::RULINGS)?.concat())
}
