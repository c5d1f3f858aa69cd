//! The texts and tables of the site: `spec-cases/site/texts.yaml`, which describes each of them.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The source of [`Texts`].
pub(super) const TEXTS: &str = include_str!("../../spec-cases/site/texts.yaml");

/// A name or an address, and a text about it.
type Pair = (String, String);

/// Texts by the name of what they describe.
pub(super) type Named = BTreeMap<String, String>;

/// The texts and tables of the site.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Texts {
    pub navigation: Vec<Pair>,
    pub glossary: Named,
    pub topics: Vec<Pair>,
    pub steps: Vec<Pair>,
    pub counts: Vec<Pair>,
    pub drawings: Vec<Drawing>,
    pub flow: Vec<(String, String, String)>,
    pub expectations: Named,
    pub ruling_kinds: Named,
    pub severities: Named,
}

/// The parts of a kind of file, each with the section that describes it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Drawing {
    pub name: String,
    pub text: Vec<Pair>,
    pub bytes: Vec<Pair>,
}
