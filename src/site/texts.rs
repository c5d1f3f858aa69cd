//! The texts and tables of the site: `spec-cases/site/texts.yaml`, which describes each of them.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The source of [`Texts`].
pub(super) const TEXTS: &str = include_str!("../../spec-cases/site/texts.yaml");

/// A name or an address, and a text about it.
type NamedText = (String, String);

/// Texts by the name of what they describe.
pub(super) type NamedTexts = BTreeMap<String, String>;

/// The texts and tables of the site.
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

/// The parts of a kind of file, each with the section that describes it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawing {
    pub name: String,
    pub text: Vec<NamedText>,
    pub bytes: Vec<NamedText>,
}
