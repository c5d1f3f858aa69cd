//! The suite of texture cases, embedded, and files of cases in the same form.

use std::sync::OnceLock;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::kit::yaml::from_yaml;
use crate::suite::cases::Suite;
use crate::suite::clauses::{Clause, Ruling};
use crate::suite::dialect::Axis;
use crate::suite::load::spec_file;
use crate::suite::texture::fixtures;
use crate::suite::texture::question::{Question, Refusal};

const FILES: &[(&str, &str)] = &[
    spec_file!("texture/cases/", "table.yaml"),
    spec_file!("texture/cases/", "parameterization.yaml"),
    spec_file!("texture/cases/", "orientation.yaml"),
    spec_file!("texture/cases/", "sampling.yaml"),
    spec_file!("texture/cases/", "boundary.yaml"),
    spec_file!("texture/cases/", "composition.yaml"),
    spec_file!("texture/cases/", "stage.yaml"),
    spec_file!("texture/cases/", "ptm.yaml"),
];

/// One question with its answer.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextureCase {
    /// A permanent name.
    pub id: String,
    /// The requirements it is about, the nearest first.
    #[serde(alias = "req")]
    pub clauses: Vec<String>,
    /// What the answer rests on.
    pub basis: Basis,
    /// The ruling, where the chapter's words alone do not settle the answer.
    pub ruling: Option<String>,
    /// The step that is asked for.
    pub op: String,
    /// What it is asked about; maps may be named.
    #[serde(default)]
    pub given: Value,
    /// The answer.
    pub expect: Value,
    /// What other readings answer.
    #[serde(default, alias = "alt")]
    pub also: Vec<Also>,
    /// How far a number may be off, where that is not the ordinary tolerance.
    pub tol: Option<f64>,
    /// The arithmetic.
    #[serde(alias = "why")]
    pub because: String,
    /// Whether it is asked before all others, to see if anybody answers.
    #[serde(default)]
    pub first: bool,
    /// The question, once it has been read.
    #[serde(skip)]
    read: OnceLock<Result<Question, Refusal>>,
    /// The choices of which another reading changes the answer, once they are known.
    #[serde(skip)]
    pub(super) concerned: OnceLock<Vec<Axis>>,
}

/// What an expected answer rests on.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// The chapter says it.
    Text,
    /// Another public PEX text says it.
    Sibling,
    /// Lost in the chapter, rebuilt from its words and its relatives; no rival is known.
    Inferred,
    /// One of several readings.
    Reading,
    /// Left to the implementation.
    Impl,
}

/// What another reading answers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Also {
    /// Its name.
    pub reading: String,
    /// Fields that put the reference into this reading.
    #[serde(default)]
    pub given: Value,
    /// Its answer.
    pub expect: Value,
}

impl Suite<TextureCase> {
    /// The suite of texture questions that is part of the program.
    ///
    /// # Errors
    /// What is wrong with which file.
    pub fn of_textures() -> Result<Suite<TextureCase>, String> {
        let read = |(name, text): &(&str, &str)| {
            cases_of(text).map_err(|error| format!("{name}: {error}"))
        };
        let files: Result<Vec<Vec<TextureCase>>, String> = FILES.iter().map(read).collect();
        Ok(Suite {
            cases: files?.concat(),
        })
    }
}

/// The cases of a file: a list, or a document whose `cases` are one.
///
/// # Errors
/// What is wrong, and where.
pub fn cases_of(text: &str) -> Result<Vec<TextureCase>, String> {
    let file: Value = from_yaml(text)?;
    let cases = match file {
        Value::Array(cases) => cases,
        Value::Object(mut file) => match file.remove("cases") {
            Some(Value::Array(cases)) => cases,
            _ => return Err("expected a list under \"cases\"".to_owned()),
        },
        _ => return Err("expected a list of cases".to_owned()),
    };
    let read = |(number, value): (usize, Value)| {
        let name = value["id"].as_str().unwrap_or("no id").to_owned();
        serde_json::from_value(value)
            .map_err(|error| format!("case {} ({name}): {error}", number + 1))
    };
    cases.into_iter().enumerate().map(read).collect()
}

impl TextureCase {
    /// The question as it is put: one JSON object.
    #[must_use]
    pub fn question(&self) -> Value {
        let given = match &self.given {
            Value::Null => json!({}),
            given => fixtures::spelled_out(given),
        };
        json!({ "op": self.op, "given": given })
    }

    /// The question, read.
    ///
    /// # Errors
    /// If the case is not one.
    pub fn read(&self) -> Result<&Question, Refusal> {
        let read = self
            .read
            .get_or_init(|| Question::from_value(&self.question()));
        read.as_ref().map_err(Refusal::clone)
    }
}

/// The requirements of the chapter.
///
/// # Errors
/// What is wrong with the file.
pub fn clauses() -> Result<Vec<Clause>, String> {
    from_yaml(include_str!("../../../spec-cases/texture/clauses.yaml"))
        .map_err(|error| format!("texture/clauses.yaml: {error}"))
}

/// The rulings.
///
/// # Errors
/// What is wrong with the file.
pub fn rulings() -> Result<Vec<Ruling>, String> {
    from_yaml(include_str!("../../../spec-cases/texture/rulings.yaml"))
        .map_err(|error| format!("texture/rulings.yaml: {error}"))
}
