//! Minimizes an existing file while a decoder still fails on it in the same way.
//!
//! The file is converted to the input of a writer and written again after every step, so that sizes and lists are always
//! consistent. A failure that disappears with the default spelling of the header cannot be minimized.

use std::collections::HashMap;
use std::str::FromStr;
use std::sync::atomic::AtomicBool;

use super::shrink::{shrink, smaller_sizes};
use ptm::decode::{self, decode};
use ptm::decode::{indices::little_endian, planes::parse_records};
use ptm::{Format, Size};
use ptm_generate::planes::{Compressed, StoredPlane};
use ptm_generate::{Model, Recipe, write};

/// Simplifies `file` step by step while it still `fails`, and returns the smallest file. Returns `None` if `file` is malformed or
/// does not fail with the default spelling of its header.
pub fn reduce(file: &[u8], stop: &AtomicBool, fails: &impl Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
    let with_file = |parts: WriterInput| (parts.write(), parts);
    let start = with_file(WriterInput::parse(file)?);
    if !fails(&start.0) {
        return None;
    }
    let weigh = |(file, _): &(Vec<u8>, _)| Some(file.len());
    let steps =
        |(_, parts): &(_, WriterInput)| parts.simpler_inputs().into_iter().map(with_file).collect();
    Some(shrink(start, weigh, steps, stop, |(file, _)| fails(file)).0)
}

/// Input of the writer.
#[derive(Clone)]
struct WriterInput {
    recipe: Recipe,
    model: Model,
}

/// Simplifications of a plane in a compressed file.
const PLANE_SIMPLIFICATIONS: [fn(&mut WriterInput, usize); 7] = [
    |parts, plane| parts.compressed().planes[plane].records.clear(),
    |parts, plane| {
        let records = &mut parts.compressed().planes[plane].records;
        records.truncate(records.len() / 2);
    },
    |parts, plane| {
        let stream = parts.encode(&vec![128; parts.recipe.size.texels()]);
        parts.compressed().planes[plane].stream = stream;
    },
    |parts, plane| {
        let plan = &mut parts.compressed().plan;
        (plan.references[plane], plan.transforms[plane]) = (-1, 0);
        (plan.motion_x[plane], plan.motion_y[plane]) = (0, 0);
    },
    |parts, plane| parts.compressed().plan.transforms[plane] = 0,
    |parts, plane| parts.compressed().plan.motion_x[plane] = 0,
    |parts, plane| parts.compressed().plan.motion_y[plane] = 0,
];

impl WriterInput {
    fn parse(file: &[u8]) -> Option<WriterInput> {
        let ptm = decode(file).ok()?;
        let (format, size) = (ptm.header.format, ptm.header.size);
        let mut fields = Fields::default();
        for field in decode::fields(file).0 {
            let bytes = &file[field.range];
            fields.0.entry(field.clause).or_default().push(bytes);
        }
        let mut recipe = Recipe::default_for(format, size);
        recipe.scale = fields.text("2.4/3")?.parse().ok()?;
        recipe.bias = fields.text("2.4/4")?.parse().ok()?;
        if format == Format::Lum {
            recipe.matrix = fields.text("2.6/2")?.parse().ok()?;
        }
        let mut model = Model::uncompressed(&recipe, ptm.planes.samples);
        if format.has_table() {
            model.table = fields.0.get("2.5/3")?.concat();
            recipe.entries = model.entries() as u32;
            let stored = fields.0.get("2.8.1/1")?.concat();
            let indices = stored.chunks_exact(if recipe.entries <= 256 { 1 } else { 2 });
            let indices: Vec<u32> = indices.map(|index| little_endian(index) as u32).collect();
            let rows = indices.chunks_exact(size.width as usize).rev();
            model.indices = rows.flatten().copied().collect();
        } else if format.coding().is_some() {
            let plan = &mut recipe.compression;
            let motion: Vec<i32> = fields.numbers("2.9.3/1")?;
            let (x, y) = motion.split_at(format.channels());
            (plan.motion_x, plan.motion_y) = (x.to_vec(), y.to_vec());
            plan.parameter = *fields.numbers("2.9.1/1")?.first()?;
            plan.transforms = fields.numbers("2.9.2/1")?;
            plan.order = fields.numbers("2.9.4/1")?;
            plan.references = fields.numbers("2.9.5/1")?;
            let plan = plan.clone();
            let streams = fields.0.get("2.9.8/2")?.iter();
            let planes = streams.zip(fields.0.get("2.9.8/4")?);
            let planes = planes.map(|(stream, side)| {
                let (stream, records) = (stream.to_vec(), parse_records(side, 0, usize::MAX).ok()?);
                Some(StoredPlane { stream, records })
            });
            let planes = planes.collect::<Option<_>>()?;
            model.compressed = Some(Compressed { plan, planes });
        }
        Some(WriterInput { recipe, model })
    }

    fn write(&self) -> Vec<u8> {
        write(&self.recipe, &self.model).bytes
    }

    fn simpler_inputs(&self) -> Vec<WriterInput> {
        let sizes = smaller_sizes(self.recipe.size).into_iter();
        let mut all: Vec<WriterInput> = sizes.filter_map(|size| self.crop_to(size)).collect();
        let mut add = |change: &dyn Fn(&mut WriterInput)| {
            let mut simpler = self.clone();
            change(&mut simpler);
            all.push(simpler);
        };
        add(&|parts| parts.recipe.scale = "1 1 1 1 1 1".parse().expect("constant numbers"));
        add(&|parts| parts.recipe.bias = "0 0 0 0 0 0".parse().expect("constant numbers"));
        if self.recipe.format.has_table() {
            for divisor in [1, 2, 4] {
                add(&|parts| parts.keep_entries(divisor));
            }
        }
        let planes = self.model.compressed.as_ref();
        for plane in 0..planes.map_or(0, |compressed| compressed.planes.len()) {
            for change in PLANE_SIMPLIFICATIONS {
                add(&|parts| change(parts, plane));
            }
        }
        all
    }

    fn compressed(&mut self) -> &mut Compressed {
        self.model.compressed.as_mut().expect("a compressed format")
    }

    /// Crops the map to its top-left corner.
    fn crop_to(&self, size: Size) -> Option<WriterInput> {
        let (old, format) = (self.recipe.size, self.recipe.format);
        let mut parts = self.clone();
        (parts.recipe.size, parts.model.size) = (size, size);
        parts.model.samples = crop(&self.model.samples, format.channels(), old, size);
        if format.has_table() {
            parts.model.indices = crop(&self.model.indices, 1, old, size);
        }
        let planes = self.model.compressed.iter();
        for (i, plane) in planes.flat_map(|compressed| &compressed.planes).enumerate() {
            // A plane is stored bottom row first, so its top-left corner is at the end of the raster.
            let removed = old.height - size.height;
            let coding = self.recipe.compression.coding;
            let residual = coding.decode(&plane.stream, old.width, old.height).ok()?;
            let remaining = &residual[(removed * old.width) as usize..];
            let move_record = |&(position, value): &(u32, u8)| {
                let (x, y) = (position % old.width, position / old.width);
                (x < size.width && y >= removed).then(|| ((y - removed) * size.width + x, value))
            };
            let stream = parts.encode(&crop(remaining, 1, old, size));
            let records = plane.records.iter().filter_map(move_record).collect();
            parts.compressed().planes[i] = StoredPlane { stream, records };
        }
        Some(parts)
    }

    fn encode(&self, residual: &[u8]) -> Vec<u8> {
        let (size, plan) = (self.recipe.size, &self.recipe.compression);
        (plan.coding).encode(residual, (size.width, size.height), plan.parameter)
    }

    /// Keeps the first `1 / divisor` of the used entries, and reduces each index modulo the number of entries kept.
    fn keep_entries(&mut self, divisor: u32) {
        let WriterInput { recipe, model } = self;
        let used_entries = model.indices.iter().max().map_or(1, |&last| last + 1);
        recipe.entries = (used_entries / divisor).max(1);
        (model.table).truncate(recipe.entries as usize * model.format.entry_size());
        for index in &mut model.indices {
            *index %= recipe.entries;
        }
    }
}

/// Crops a raster with `channels` values per texel to its top-left corner.
fn crop<T: Copy>(values: &[T], channels: usize, old: Size, new: Size) -> Vec<T> {
    let rows = values.chunks_exact(old.width as usize * channels);
    let rows = rows.take(new.height as usize);
    let values = rows.flat_map(|row| &row[..new.width as usize * channels]);
    values.copied().collect()
}

/// Fields of a decoded file, by clause.
#[derive(Default)]
struct Fields<'a>(HashMap<&'static str, Vec<&'a [u8]>>);

impl Fields<'_> {
    /// Joins the fields of a clause with spaces.
    fn text(&self, clause: &str) -> Option<String> {
        let words = self.0.get(clause)?.join(&b' ');
        Some(String::from_utf8_lossy(&words).into_owned())
    }

    fn numbers<T: FromStr>(&self, clause: &str) -> Option<Vec<T>> {
        let text = self.text(clause)?;
        text.split(' ').map(|word| word.parse().ok()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm_suite::cases::{Expect, Suite, TableSpelling};

    #[test]
    fn every_reduction_step_is_a_different_legal_file() {
        let suite = Suite::load().expect("the suite loads");
        let legal = suite.cases.iter().filter(|case| {
            let recipe = case.recipe().filter(|_| case.expect == Expect::Decode);
            recipe.is_some_and(|recipe| recipe.size.texels() < 200)
        });
        for (i, case) in legal.enumerate() {
            let (id, file) = (&case.id, &case.build(TableSpelling::default()).file);
            let parts = WriterInput::parse(file).expect("a legal file");
            let planes = |file: &[u8]| decode(file).expect("a legal file").planes;
            assert_eq!(planes(&parts.write()), planes(file), "{id}");
            for parts in parts.simpler_inputs().into_iter().filter(|_| i % 20 == 0) {
                assert_eq!(planes(&parts.write()).size, parts.recipe.size, "{id}");
            }
        }
    }

    #[test]
    fn failing_texel_is_isolated() {
        let recipe = Recipe::default_for(Format::Rgb, "40x30".parse().expect("a size"));
        let file = write(&recipe, &Model::paint(&recipe)).bytes;
        let samples = |file: &[u8]| decode(file).map_or(0, |ptm| ptm.planes.samples.len());
        let fails = |file: &[u8]| samples(file) >= 18 * 6;
        let small = reduce(&file, &AtomicBool::new(false), &fails).expect("the file fails");
        assert_eq!(samples(&small), 18 * 6);
    }
}
