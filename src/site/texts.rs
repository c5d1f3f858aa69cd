//! Texts and tables of the site. See `spec-cases/site/texts.yaml` for descriptions of the fields.

use std::collections::BTreeMap;

use serde::Deserialize;

/// YAML source of [`Texts`].
pub(super) const TEXTS: &str = include_str!("../../spec-cases/site/texts.yaml");

/// Name or URL, and the associated text.
type NamedText = (String, String);

/// Descriptions by name.
pub(super) type NamedTexts = BTreeMap<String, String>;

/// Texts and tables of the site.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Texts {
    pub navigation: Vec<NamedText>,
    pub glossary: NamedTexts,
    pub topics: Vec<NamedText>,
    pub steps: Vec<NamedText>,
    pub counts: Vec<NamedText>,
    pub drawings: Vec<Drawing>,
    pub flow: Vec<(String, String, String)>,
    pub expectations: NamedTexts,
    pub ruling_kinds: NamedTexts,
    pub severities: NamedTexts,
}

/// Diagram of a kind of file: its parts and the sections that describe them.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawing {
    pub name: String,
    pub text: Vec<NamedText>,
    pub bytes: Vec<NamedText>,
}
