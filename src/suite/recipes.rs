//! Recipes as cases write them.

use serde::Deserialize;

use super::words::{Words, number};
use crate::codec::jpeg_ls::PresetParameters;
use crate::generate::Recipe;
use crate::generate::plan::Compression;
use crate::generate::recipe::Indices;
use crate::generate::spelling::{Line, Spelling};

/// A recipe as it is written: what differs from the ordinary file.
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

/// How planes are compressed, as it is written: what differs from the ordinary way.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct CompressionRecord {
    parameter: Option<String>,
    structure: Option<String>,
    references: Option<String>,
    order: Option<String>,
    /// These three go round and round.
    transforms: Option<String>,
    motion_x: Option<String>,
    motion_y: Option<String>,
    /// Whether planes that are not predicted have transforms and vectors too.
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
    /// Whether only the streams of every second plane are so.
    alternates: Option<String>,
}

/// A spelling as it is written: what differs from the plain one.
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
    /// The recipe with these words.
    pub fn recipe(&self, words: &Words) -> Result<Recipe, String> {
        let size = words.fill(&self.size).parse()?;
        let mut recipe = Recipe::ordinary(words.fill(&self.format).parse()?, size);
        words.parse(&mut recipe.scene, self.scene.as_ref())?;
        words.number("seed", &mut recipe.seed, self.seed.as_ref())?;
        words.parse(&mut recipe.scale, self.scale.as_ref())?;
        words.parse(&mut recipe.bias, self.bias.as_ref())?;
        words.parse(&mut recipe.matrix, self.matrix.as_ref())?;
        words.number("entries", &mut recipe.entries, self.entries.as_ref())?;
        if let Some(indices) = &self.indices {
            recipe.indices = parse_indices(&words.fill(indices))?;
        }
        if let Some(first) = &self.first_byte {
            recipe.first = Some(number("first_byte", &words.fill(first))?);
        }
        self.compression.apply(&mut recipe.compression, words)?;
        self.spelling.apply(&mut recipe.spelling, words)?;
        recipe.check()?;
        Ok(recipe)
    }
}

impl SpellingRecord {
    fn apply(&self, spelling: &mut Spelling, words: &Words) -> Result<(), String> {
        if let Some(lines) = &self.space_before_newline {
            let lines = words.fill(lines);
            let named: Result<Vec<Line>, String> = match lines.as_str() {
                "all" => Ok(Line::ALL.to_vec()),
                _ => lines.split_whitespace().map(str::parse).collect(),
            };
            spelling.space_before_newline = named?;
        }
        let two = |name, slot: &mut bool, text: &Option<String>| {
            words.either(name, ["2", "1"], slot, text.as_ref())
        };
        two(
            "size_lines",
            &mut spelling.size_on_two_lines,
            &self.size_lines,
        )?;
        two(
            "scale_bias_lines",
            &mut spelling.scale_bias_on_two_lines,
            &self.scale_bias_lines,
        )?;
        words.number("gap", &mut spelling.gap, self.gap.as_ref())?;
        words.parse(&mut spelling.count, self.count.as_ref())?;
        let newline = &mut spelling.newline_after_table;
        words.flag(
            "newline_after_table",
            newline,
            self.newline_after_table.as_ref(),
        )?;
        words.number(
            "matrix_line",
            &mut spelling.matrix_line,
            self.matrix_line.as_ref(),
        )?;
        words.parse(&mut spelling.lists, self.lists.as_ref())
    }
}

impl CompressionRecord {
    fn apply(&self, plan: &mut Compression, words: &Words) -> Result<(), String> {
        let planes = plan.order.len();
        words.number("parameter", &mut plan.parameter, self.parameter.as_ref())?;
        if let Some(structure) = &self.structure {
            plan.set_structure(words.fill(structure).parse()?);
        }
        if let Some(references) = words.numbers("references", self.references.as_ref())? {
            plan.references = references;
        }
        if let Some(order) = words.numbers("order", self.order.as_ref())? {
            plan.order = order;
        }
        if plan.references.len() != planes || plan.order.len() != planes {
            return Err(format!(
                "references and order have {planes} numbers in this format"
            ));
        }
        let mut everywhere = false;
        words.flag("everywhere", &mut everywhere, self.everywhere.as_ref())?;
        if let Some(transforms) = words.numbers("transforms", self.transforms.as_ref())? {
            plan.transforms = plan.cycled(&transforms, everywhere);
        }
        if let Some(motion) = words.numbers("motion_x", self.motion_x.as_ref())? {
            plan.motion_x = plan.cycled(&motion, everywhere);
        }
        if let Some(motion) = words.numbers("motion_y", self.motion_y.as_ref())? {
            plan.motion_y = plan.cycled(&motion, everywhere);
        }
        if let Some(records) = &self.records {
            let records = words.fill(records);
            let records: Result<_, String> = records.split_whitespace().map(str::parse).collect();
            plan.records = records?;
        }
        words.parse(&mut plan.residuals, self.residuals.as_ref())?;
        words.flag("alternates", &mut plan.alternates, self.alternates.as_ref())?;
        self.apply_to_streams(plan, words)
    }

    fn apply_to_streams(&self, plan: &mut Compression, words: &Words) -> Result<(), String> {
        let stream = &mut plan.stream;
        let interval = &mut stream.restart_interval;
        words.number("restart_interval", interval, self.restart_interval.as_ref())?;
        words.flag(
            "optimised_tables",
            &mut stream.optimized,
            self.optimised_tables.as_ref(),
        )?;
        words.flag("baseline", &mut stream.baseline, self.baseline.as_ref())?;
        words.flag("jfif", &mut stream.jfif, self.jfif.as_ref())?;
        if let Some(sampling) = &self.sampling {
            let sampling = words.fill(sampling);
            let factors = sampling.split_once('x');
            let (across, down) = factors.ok_or("sampling factors are written 2x1")?;
            stream.sampling = (number("sampling", across)?, number("sampling", down)?);
        }
        if let Some(step) = &self.step {
            stream.step = Some(number("step", &words.fill(step))?);
        }
        if let Some(numbers) = words.numbers("table_numbers", self.table_numbers.as_ref())? {
            let numbers = numbers.try_into();
            stream.table_numbers = Some(numbers.map_err(|_| "table_numbers are three")?);
        }
        let together = &mut stream.tables_together;
        words.flag("tables_together", together, self.tables_together.as_ref())?;
        let component = &mut stream.component;
        words.number("component", component, self.component.as_ref())?;
        let moved = &mut stream.frame_moved;
        words.flag("frame_moved", moved, self.frame_moved.as_ref())?;
        if let Some(presets) = words.numbers::<u16>("presets", self.presets.as_ref())? {
            let [maxval, t1, t2, t3, reset] = presets[..] else {
                return Err("presets are MAXVAL T1 T2 T3 RESET".to_owned());
            };
            stream.presets = Some(PresetParameters {
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

/// `any`, `below-256`, `bytes-differ`, or a list of numbers.
fn parse_indices(text: &str) -> Result<Indices, String> {
    if let Some(limit) = text.strip_prefix("below-") {
        return limit
            .parse()
            .map(Indices::Below)
            .map_err(|_| format!("unknown indices {text:?}"));
    }
    match text {
        "any" => Ok(Indices::Any),
        "bytes-differ" => Ok(Indices::BytesDiffer),
        _ => {
            let list: Result<Vec<u32>, _> = text.split_whitespace().map(str::parse).collect();
            list.map(Indices::These)
                .map_err(|_| format!("unknown indices {text:?}"))
        }
    }
}
