//! Cases as they are written in case files.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::cases::{Case, Expect, Source};
use super::values::{HandPiece, HandValues, format_of};
use super::words::Words;
use super::{damages, recipes::MakeRecord};
use crate::error::{Error, Result};
use crate::protocol::frame::View;
use ptm::codec::Coding;
use ptm_generate::{Model, Recipe, plan::Residuals, spelling::Count, write};

/// A record of a case file. With `for_each`, it defines a case for every combination of the listed words.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseRecord {
    pub id: String,
    clauses: Vec<String>,
    because: String,
    ruling: Option<String>,
    #[serde(default)]
    pub for_each: BTreeMap<String, Vec<String>>,
    make: Option<MakeRecord>,
    bytes: Option<Vec<HandPiece>>,
    values: Option<HandValues>,
    pub twin_of: Option<String>,
    damage: Option<String>,
    /// Open choices that affect the case, separated by spaces, or `none`.
    shows: Option<String>,
    expect: Expect,
    views: Option<Vec<String>>,
    #[serde(default)]
    first: bool,
}

impl CaseRecord {
    /// Builds the case with the given words filled in. `twin` is the case that `twin_of` names, if it precedes this one.
    pub fn case(&self, words: &Words, twin: Option<&Case>) -> Result<Case> {
        let source = self.source(words, twin)?;
        if self.expect == Expect::Spelling && self.make.is_none() {
            return Error::invalid("a case with `expect: spelling` must have a recipe (`make`)");
        }
        let views = self.views(words, &source, twin)?;
        let shows = self.shows.as_ref().map(|shows| {
            let shows = words.fill(shows);
            let axes = shows.split_whitespace().filter(|&axis| axis != "none");
            axes.map(str::to_owned).collect()
        });
        let because = words.fill(&self.because);
        Ok(Case {
            id: words.id(&self.id),
            clauses: self.clauses.clone(),
            because: because.split_whitespace().collect::<Vec<_>>().join(" "),
            ruling: self.ruling.clone(),
            expect: self.expect,
            views,
            first: self.first,
            open_choices: shows.or_else(|| twin?.open_choices.clone()),
            twin_of: self.twin_of.as_ref().map(|twin| words.id(twin)),
            source,
            prepared_file: None,
        })
    }

    fn source(&self, words: &Words, twin: Option<&Case>) -> Result<Source> {
        match (&self.make, &self.bytes, &self.twin_of) {
            (Some(make), None, None) => Ok(Source::Recipe(make.recipe(words)?, None)),
            (None, Some(pieces), None) => {
                for piece in pieces {
                    piece.bytes(Count::default(), false)?;
                }
                let (format, values) = (format_of(pieces)?, self.values.clone());
                if let Some(values) = &values {
                    values.check(format)?;
                }
                Ok(Source::Hand(format, pieces.clone(), values))
            }
            (None, None, Some(id)) => {
                let id = words.id(id);
                let twin = twin.ok_or_else(|| format!("the twin {id} must precede the case"))?;
                self.damaged_source(words, twin)
                    .map_err(|error| Error::Invalid(format!("the twin {id} {error}").into()))
            }
            _ => Error::invalid("a case must have exactly one of make, bytes and twin_of"),
        }
    }

    fn damaged_source(&self, words: &Words, twin: &Case) -> Result<Source> {
        if twin.twin_of.is_some() {
            return Error::invalid("is itself an edit");
        }
        let recipe = twin.recipe().ok_or("has no recipe")?.clone();
        let name = self.damage.as_ref().ok_or("needs a damage")?;
        let damage = damages::find(&words.fill(name))
            .map_err(|error| Error::Invalid(format!("has an {error}").into()))?;
        let model = Model::paint(&recipe);
        let damaged = damage.apply(&write(&recipe, &model), &model);
        damaged.map_err(|error| {
            Error::Recipe(error).in_place(format!("cannot have damage {}", damage.name))
        })?;
        Ok(Source::Recipe(recipe, Some(damage)))
    }

    fn views(&self, words: &Words, source: &Source, twin: Option<&Case>) -> Result<Vec<View>> {
        let views = match (&self.views, source, &self.values, twin) {
            (Some(views), ..) => {
                (views.iter().map(|view| words.fill(view).parse())).collect::<Result<_, _>>()?
            }
            (None, Source::Hand(..), Some(values), _) => values.views()?,
            (None, _, _, Some(twin)) => twin.views.clone(),
            _ => vec![View::Raw, View::Coef, View::DEFAULT_RGB.parse()?],
        };
        if let Source::Recipe(recipe, _) = source {
            check_views(recipe, &views)?;
        }
        if let (Source::Hand(..), Some(values)) = (source, &self.values) {
            let known = values.views()?;
            if let Some(unknown) = views.iter().find(|view| !known.contains(view)) {
                return Error::invalid(format!("the case has no values for the view {unknown}"));
            }
        }
        Ok(views)
    }
}

/// Checks that a case uses only the raw view if a different inverse DCT may change a sample from 255 to 0. The raw view is
/// compared modulo 256, so these values differ by one there.
fn check_views(recipe: &Recipe, views: &[View]) -> Result<()> {
    let lossy = recipe.format.coding() == Some(Coding::Jpeg)
        && recipe.compression.residuals == Residuals::Natural;
    if !lossy || views.iter().all(|view| *view == View::Raw) {
        return Ok(());
    }
    let model = Model::paint(recipe);
    let mut samples = model.samples.iter().zip(&model.slack);
    match samples.any(|(&sample, &slack)| slack > 0 && sample.min(255 - sample) < slack) {
        true => Error::invalid("the samples are too close to 0 or 255 for any view except raw"),
        false => Ok(()),
    }
}
