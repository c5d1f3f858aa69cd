//! Recipes as they are written in case files.

use serde::Deserialize;

use super::words::{FieldText, Words, number, word};
use crate::codec::jpeg_ls::PresetParameters;
use crate::generate::Recipe;
use crate::generate::plan::{Compression, Stream};
use crate::generate::recipe::Indices;
use crate::generate::spelling::{Line, Spelling};

/// A recipe in a case file: its differences from the default file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MakeRecord {
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
    compression: CompressionRecord,
    #[serde(default)]
    spelling: SpellingRecord,
}

/// A compression in a case file: its differences from the default one.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct CompressionRecord {
    parameter: Option<String>,
    structure: Option<String>,
    references: Option<String>,
    order: Option<String>,
    /// These three are repeated.
    transforms: Option<String>,
    motion_x: Option<String>,
    motion_y: Option<String>,
    /// True if planes that are not predicted also have transforms and vectors.
    everywhere: Option<String>,
    records: Option<String>,
    residuals: Option<String>,
    restart_interval: Option<String>,
    optimised_tables: Option<String>,
    baseline: Option<String>,
    sampling: Option<String>,
    step: Option<String>,
    table_numbers: Option<String>,
    tables_together: Option<String>,
    jfif: Option<String>,
    presets: Option<String>,
    component: Option<String>,
    frame_moved: Option<String>,
    /// True if the settings apply only to the streams of every second plane.
    alternates: Option<String>,
}

/// A header spelling in a case file: its differences from the default one.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct SpellingRecord {
    /// Names of lines, or `all`.
    space_before_newline: Option<String>,
    /// 1 or 2.
    size_lines: Option<String>,
    /// 1 or 2.
    scale_bias_lines: Option<String>,
    gap: Option<String>,
    count: Option<String>,
    newline_after_table: Option<String>,
    matrix_line: Option<String>,
    lists: Option<String>,
}

impl MakeRecord {
    /// Builds the recipe with the given words filled in.
    pub fn recipe(&self, words: &Words) -> Result<Recipe, String> {
        let size = words.fill(&self.size).parse()?;
        let mut recipe = Recipe::ordinary(words.fill(&self.format).parse()?, size);
        self.scene.parse(words, &mut recipe.scene)?;
        self.seed.number("seed", words, &mut recipe.seed)?;
        self.scale.parse(words, &mut recipe.scale)?;
        self.bias.parse(words, &mut recipe.bias)?;
        self.matrix.parse(words, &mut recipe.matrix)?;
        self.entries.number("entries", words, &mut recipe.entries)?;
        if let Some(indices) = self.indices.filled(words) {
            recipe.indices = parse_indices(&indices)?;
        }
        if let Some(first) = self.first_byte.filled(words) {
            recipe.first = Some(number("first_byte", &first)?);
        }
        self.compression.apply(&mut recipe.compression, words)?;
        self.spelling.apply(&mut recipe.spelling, words)?;
        recipe.check()?;
        Ok(recipe)
    }
}

impl SpellingRecord {
    fn apply(&self, to: &mut Spelling, words: &Words) -> Result<(), String> {
        if let Some(lines) = self.space_before_newline.filled(words) {
            to.space_before_newline = match lines.as_str() {
                "all" => Line::ALL.to_vec(),
                _ => lines
                    .split_whitespace()
                    .map(word)
                    .collect::<Result<_, _>>()?,
            };
        }
        let lines = ["2", "1"];
        let two_lines = &mut to.size_on_two_lines;
        self.size_lines
            .yes_or_no("size_lines", lines, words, two_lines)?;
        let two_lines = &mut to.scale_bias_on_two_lines;
        self.scale_bias_lines
            .yes_or_no("scale_bias_lines", lines, words, two_lines)?;
        self.gap.number("gap", words, &mut to.gap)?;
        self.count.parse(words, &mut to.count)?;
        let newline = &mut to.newline_after_table;
        self.newline_after_table
            .flag("newline_after_table", words, newline)?;
        self.matrix_line
            .number("matrix_line", words, &mut to.matrix_line)?;
        self.lists.word(words, &mut to.lists)
    }
}

impl CompressionRecord {
    fn apply(&self, plan: &mut Compression, words: &Words) -> Result<(), String> {
        let planes = plan.order.len();
        self.parameter
            .number("parameter", words, &mut plan.parameter)?;
        if let Some(structure) = self.structure.filled(words) {
            plan.set_structure(word(&structure)?);
        }
        if let Some(references) = self.references.numbers("references", words)? {
            plan.references = references;
        }
        if let Some(order) = self.order.numbers("order", words)? {
            plan.order = order;
        }
        if plan.references.len() != planes || plan.order.len() != planes {
            return Err(format!(
                "references and order must have {planes} numbers in this format"
            ));
        }
        let mut everywhere = false;
        self.everywhere.flag("everywhere", words, &mut everywhere)?;
        if let Some(transforms) = self.transforms.numbers("transforms", words)? {
            plan.transforms = plan.cycled(&transforms, everywhere);
        }
        if let Some(motion) = self.motion_x.numbers("motion_x", words)? {
            plan.motion_x = plan.cycled(&motion, everywhere);
        }
        if let Some(motion) = self.motion_y.numbers("motion_y", words)? {
            plan.motion_y = plan.cycled(&motion, everywhere);
        }
        if let Some(records) = self.records.filled(words) {
            let records = records.split_whitespace().map(str::parse);
            plan.records = records.collect::<Result<_, _>>()?;
        }
        self.residuals.word(words, &mut plan.residuals)?;
        self.alternates
            .flag("alternates", words, &mut plan.alternates)?;
        self.apply_to_streams(&mut plan.stream, words)
    }

    fn apply_to_streams(&self, to: &mut Stream, words: &Words) -> Result<(), String> {
        let jpeg = &mut to.jpeg;
        let interval = &mut jpeg.restart_interval;
        self.restart_interval
            .number("restart_interval", words, interval)?;
        self.optimised_tables
            .flag("optimised_tables", words, &mut jpeg.optimized)?;
        self.baseline.flag("baseline", words, &mut jpeg.baseline)?;
        if let Some(sampling) = self.sampling.filled(words) {
            let factors = sampling.split_once('x');
            let (across, down) = factors.ok_or("expected sampling factors such as 2x1")?;
            jpeg.sampling = (number("sampling", across)?, number("sampling", down)?);
        }
        if let Some(step) = self.step.filled(words) {
            jpeg.step = Some(number("step", &step)?);
        }
        if let Some(numbers) = self.table_numbers.numbers("table_numbers", words)? {
            let numbers = numbers.try_into();
            jpeg.table_numbers =
                Some(numbers.map_err(|_| "expected three numbers in table_numbers")?);
        }
        self.tables_together
            .flag("tables_together", words, &mut jpeg.tables_together)?;
        self.jfif.flag("jfif", words, &mut to.jfif)?;
        self.component
            .number("component", words, &mut to.component)?;
        self.frame_moved
            .flag("frame_moved", words, &mut to.frame_moved)?;
        if let Some(presets) = self.presets.numbers("presets", words)? {
            let [maxval, t1, t2, t3, reset] = presets[..] else {
                return Err("expected presets such as MAXVAL T1 T2 T3 RESET".to_owned());
            };
            to.presets = Some(PresetParameters {
                maxval,
                t1,
                t2,
                t3,
                reset,
            });
        }
        Ok(())
    }
}

/// Parses `any`, `below-256`, `bytes-differ`, or a list of numbers.
fn parse_indices(text: &str) -> Result<Indices, String> {
    let numbers = || -> Result<Vec<u32>, _> { text.split_whitespace().map(str::parse).collect() };
    let indices = match (text, text.strip_prefix("below-")) {
        (_, Some(limit)) => limit.parse().map(Indices::Below),
        ("any", _) => Ok(Indices::Any),
        ("bytes-differ", _) => Ok(Indices::BytesDiffer),
        _ => numbers().map(Indices::These),
    };
    indices.map_err(|_| format!("unknown indices {text:?}"))
}
