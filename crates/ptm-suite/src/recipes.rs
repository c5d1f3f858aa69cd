//! Recipes as they are written in case files.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::words::{Words, flag, number, numbers, word, yes_or_no};
use crate::error::{Error, Result};
use ptm::codec::jpeg_ls::PresetParameters;
use ptm_generate::Recipe;
use ptm_generate::plan::{Compression, Stream};
use ptm_generate::recipe::Indices;
use ptm_generate::spelling::{Line, Spelling};

/// A recipe in a case file: its differences from the default file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MakeRecord {
    format: String,
    size: String,
    scene: Option<String>,
    seed: Option<String>,
    scale: Option<String>,
    bias: Option<String>,
    matrix: Option<String>,
    entries: Option<String>,
    indices: Option<String>,
    first_byte: Option<String>,
    #[serde(default)]
    compression: SettingTexts,
    #[serde(default)]
    spelling: SettingTexts,
}

/// Differences from the default compression or spelling, by name.
type SettingTexts = BTreeMap<String, String>;

impl MakeRecord {
    /// Builds the recipe with the given words filled in.
    ///
    /// # Errors
    /// Returns a message that names the invalid setting.
    pub fn recipe(&self, words: &Words) -> Result<Recipe> {
        let size = words.fill(&self.size).parse()?;
        let mut recipe = Recipe::default_for(words.fill(&self.format).parse()?, size);
        let entries = |text: &str| number("entries", text);
        let first = |text: &str| number("first_byte", text).map(Some);
        words.set(&mut recipe.scene, self.scene.as_ref(), str::parse)?;
        words.set(&mut recipe.seed, self.seed.as_ref(), |text| {
            number("seed", text)
        })?;
        words.set(&mut recipe.scale, self.scale.as_ref(), str::parse)?;
        words.set(&mut recipe.bias, self.bias.as_ref(), str::parse)?;
        words.set(&mut recipe.matrix, self.matrix.as_ref(), str::parse)?;
        words.set(&mut recipe.entries, self.entries.as_ref(), entries)?;
        words.set(&mut recipe.indices, self.indices.as_ref(), parse_indices)?;
        words.set(&mut recipe.first_byte, self.first_byte.as_ref(), first)?;
        set_compression(&self.compression, words, &mut recipe.compression)?;
        for (name, text) in &self.spelling {
            set_spelling(&mut recipe.spelling, name, &words.fill(text))?;
        }
        recipe.check()?;
        Ok(recipe)
    }
}

/// Sets one field of a header's spelling.
fn set_spelling(spelling: &mut Spelling, name: &str, text: &str) -> Result<()> {
    match name {
        "space_before_newline" if text == "all" => {
            spelling.space_before_newline = Line::ALL.to_vec();
        }
        "space_before_newline" => {
            let lines = text.split_whitespace().map(word);
            spelling.space_before_newline = lines.collect::<Result<_, _>>()?;
        }
        "size_lines" => spelling.size_on_two_lines = yes_or_no(name, text, ["2", "1"])?,
        "scale_bias_lines" => spelling.scale_bias_on_two_lines = yes_or_no(name, text, ["2", "1"])?,
        "leading_zeros" => spelling.leading_zeros = number(name, text)?,
        "gap" => spelling.gap = number(name, text)?,
        "count" => spelling.count = text.parse()?,
        "newline_after_table" => spelling.newline_after_table = flag(name, text)?,
        "matrix_line" => spelling.matrix_line = number(name, text)?,
        "lists" => spelling.lists = word(text)?,
        _ => return Error::invalid(format!("unknown field `{name}`")),
    }
    Ok(())
}

/// Settings on which other settings depend, in the order in which they are applied.
const FIRST_SETTINGS: [&str; 4] = ["structure", "references", "order", "everywhere"];

fn set_compression(settings: &SettingTexts, words: &Words, plan: &mut Compression) -> Result<()> {
    let planes = plan.order.len();
    // True if planes that are not predicted also have transforms and vectors.
    let mut everywhere = false;
    for name in FIRST_SETTINGS {
        let Some(text) = settings.get(name) else {
            continue;
        };
        let text = &words.fill(text);
        match name {
            "structure" => plan.set_structure(word(text)?),
            "references" => plan.references = numbers(name, text)?,
            "order" => plan.order = numbers(name, text)?,
            _ => everywhere = flag(name, text)?,
        }
    }
    if plan.references.len() != planes || plan.order.len() != planes {
        return Error::invalid(format!(
            "references and order must have {planes} numbers in this format"
        ));
    }
    for (name, text) in settings {
        let text = &words.fill(text);
        match name.as_str() {
            "parameter" => plan.parameter = number(name, text)?,
            // These three lists are repeated.
            "transforms" => plan.transforms = plan.cycle(&numbers(name, text)?, everywhere),
            "motion_x" => plan.motion_x = plan.cycle(&numbers(name, text)?, everywhere),
            "motion_y" => plan.motion_y = plan.cycle(&numbers(name, text)?, everywhere),
            "records" => {
                let records = text.split_whitespace().map(str::parse);
                plan.records = records.collect::<Result<_, _>>()?;
            }
            "residuals" => plan.residuals = word(text)?,
            // The settings apply only to the streams of every second plane.
            "alternates" => plan.even_planes_only = flag(name, text)?,
            name if FIRST_SETTINGS.contains(&name) => {}
            name => set_stream(&mut plan.stream, name, text)?,
        }
    }
    Ok(())
}

/// Sets one field of the spelling of the streams.
fn set_stream(stream: &mut Stream, name: &str, text: &str) -> Result<()> {
    let jpeg = &mut stream.jpeg;
    match name {
        "restart_interval" => jpeg.restart_interval = number(name, text)?,
        "optimized_tables" => jpeg.optimized = flag(name, text)?,
        "baseline" => jpeg.baseline = flag(name, text)?,
        "sampling" => {
            let factors = text.split_once('x');
            let (across, down) = factors.ok_or("expected sampling factors such as 2x1")?;
            jpeg.sampling = (number(name, across)?, number(name, down)?);
        }
        "step" => jpeg.step = Some(number(name, text)?),
        "table_numbers" => {
            let numbers = numbers(name, text)?.try_into();
            jpeg.table_numbers =
                Some(numbers.map_err(|_| "expected three numbers in table_numbers")?);
        }
        "tables_together" => jpeg.tables_together = flag(name, text)?,
        "jfif" => stream.jfif = flag(name, text)?,
        "component" => stream.component = number(name, text)?,
        "frame_moved" => stream.moves_frame_header = flag(name, text)?,
        "precision" => stream.precision = number(name, text)?,
        "presets" => {
            let [maxval, t1, t2, t3, reset] = numbers(name, text)?[..] else {
                return Error::invalid("expected presets in the form MAXVAL T1 T2 T3 RESET");
            };
            stream.presets = Some(PresetParameters {
                maxval,
                t1,
                t2,
                t3,
                reset,
            });
        }
        _ => return Error::invalid(format!("unknown field `{name}`")),
    }
    Ok(())
}

/// Parses `any`, `below-256`, `bytes-differ`, or a list of numbers.
fn parse_indices(text: &str) -> Result<Indices> {
    let numbers = || -> Result<Vec<u32>, _> { text.split_whitespace().map(str::parse).collect() };
    let indices = match (text, text.strip_prefix("below-")) {
        (_, Some(limit)) => limit.parse().map(Indices::Below),
        ("any", _) => Ok(Indices::Any),
        ("bytes-differ", _) => Ok(Indices::BytesDiffer),
        _ => numbers().map(Indices::List),
    };
    indices.map_err(|_| Error::Invalid(format!("unknown indices {text:?}").into()))
}
