//! Cases of the writer suite: requests with expected results.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::generate::plan::Residuals;
use crate::generate::recipe::Indices;
use crate::generate::{Model, Recipe};
use crate::kit::yaml::records;
use crate::ptm::{Coding, Format};
use crate::suite::cases::{Expect, Suite};
use crate::suite::recipes::MakeRecord;
use crate::suite::words::Words;
use crate::writers::request::{PredictionAdvice, RequestHeader, WriteRequest};

/// Embedded requests.
const REQUESTS: &str = include_str!("../../spec-cases/writers/requests.yaml");

/// Request to a writer, with the expected result.
#[derive(Clone, Debug)]
pub struct WriterCase {
    /// Permanent slug.
    pub id: String,
    /// Clauses that the case tests.
    pub clauses: Vec<String>,
    /// Purpose of the case, in a sentence.
    pub because: String,
    /// Expected result: a file with the values, or a refusal.
    pub expect: Expect,
    /// True if the case is requested before all others.
    pub first: bool,
    /// True if the case is in the smoke subset.
    pub smoke: bool,
    /// Contents of the requested file.
    recipe: Recipe,
}

/// Request as written in YAML. With `for_each`, it expands to one case for every combination of the listed words.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RequestRecord {
    id: String,
    clauses: Vec<String>,
    because: String,
    #[serde(default)]
    for_each: BTreeMap<String, Vec<String>>,
    make: MakeRecord,
    expect: Expect,
    #[serde(default)]
    first: bool,
    /// Ids of expanded cases in the smoke subset, or `[all]` for all of them.
    #[serde(default)]
    smoke: Vec<String>,
}

impl Suite<WriterCase> {
    /// Loads the embedded suite of requests.
    ///
    /// # Errors
    /// Returns a message that names the line or the request with the error.
    pub fn load_writer_requests() -> Result<Suite<WriterCase>, String> {
        let records = records(REQUESTS).map_err(|error| format!("requests.yaml: {error}"))?;
        let mut cases: Vec<WriterCase> = Vec::new();
        for (line, record) in records {
            let record: RequestRecord = record;
            for words in Words::combinations(&record.for_each) {
                let id = words.id(&record.id);
                let named = |error| format!("requests.yaml: line {line}: {id}: {error}");
                if cases.iter().any(|case| case.id == id) {
                    return Err(named("duplicate request".to_owned()));
                }
                cases.push(record.case(&words).map_err(named)?);
            }
        }
        Ok(Suite { cases })
    }
}

impl RequestRecord {
    fn case(&self, words: &Words) -> Result<WriterCase, String> {
        let mut recipe = self.make.recipe(words)?;
        if recipe.format.has_table() {
            // Use every entry in the planes, if there are enough texels.
            recipe.indices = Indices::These((0..recipe.entries).collect());
        }
        recipe.compression.residuals = Residuals::Natural;
        let id = words.id(&self.id);
        Ok(WriterCase {
            smoke: self.first || self.smoke.contains(&id) || self.smoke == ["all"],
            id,
            clauses: self.clauses.clone(),
            because: words.fill(&self.because),
            expect: self.expect,
            first: self.first,
            recipe,
        })
    }
}

impl WriterCase {
    /// Returns the requested format.
    #[must_use]
    pub fn format(&self) -> Format {
        self.recipe.format
    }

    /// Returns the number of distinct polynomials in the planes for formats with a table, or `None` for other formats.
    #[must_use]
    pub fn entries(&self) -> Option<u32> {
        let has_table = self.recipe.format.has_table();
        has_table.then_some(self.recipe.entries)
    }

    /// Returns the request, with the placeholder `{planes}` as the path of the planes.
    #[must_use]
    pub fn request(&self) -> WriteRequest {
        let recipe = &self.recipe;
        let format = recipe.format;
        let plan = &recipe.compression;
        let predicts = format.coding().is_some() && plan.predicts();
        WriteRequest {
            header: RequestHeader {
                format: format.name().to_owned(),
                width: recipe.size.width,
                height: recipe.size.height,
                scale: recipe.scale.values,
                bias: recipe.bias.values.map(|bias| bias as i64),
                matrix: (format == Format::Lum).then_some(recipe.matrix.values),
                quality: (format.coding() == Some(Coding::Jpeg)).then_some(plan.parameter),
                near: (format.coding() == Some(Coding::JpegLs)).then_some(plan.parameter),
                prediction: predicts.then(|| PredictionAdvice {
                    references: plan.references.clone(),
                    order: plan.order.clone(),
                    transforms: plan.transforms.clone(),
                    motion_x: plan.motion_x.clone(),
                    motion_y: plan.motion_y.clone(),
                }),
                planes: "{planes}".to_owned(),
            },
            format,
            samples: self.samples(),
        }
    }

    /// Returns the generated samples before compression.
    fn samples(&self) -> Vec<u8> {
        let mut plain = self.recipe.clone();
        if plain.format.coding().is_some() {
            plain.format = plain.format.uncompressed();
        }
        Model::paint(&plain).samples
    }
}
