//! Minimization of an existing file while a decoder fails on it in the same way.
//!
//! The file is converted to the input of a writer, and written again after every step, so that sizes and lists are always
//! consistent. If the default spelling of the header hides the failure, the file is not changed.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::shrink::{shrink, smaller_sizes};
use crate::decode::{decode, fields};
use crate::generate::planes::{Compressed, StoredPlane};
use crate::generate::{Model, Recipe, write};
use crate::ptm::{Field, Format, Size};

/// Returns the smallest file reached from `file` by steps after each of which it still `fails`; None if `file` is malformed, or
/// no longer fails with the default spelling of its header.
pub fn reduce(file: &[u8], stop: &AtomicBool, fails: &impl Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
    let parts = Parts::parse(file)?;
    let written = |parts: Parts| (parts.write(), parts);
    let start = written(parts);
    if !fails(&start.0) {
        return None;
    }
    let smallest = shrink(
        start,
        |(file, _)| Some(file.len()),
        |(_, parts)| parts.steps().into_iter().map(written).collect(),
        stop,
        |(file, _)| fails(file),
    );
    Some(smallest.0)
}

/// Input of a writer.
#[derive(Clone)]
struct Parts {
    recipe: Recipe,
    model: Model,
}

/// Simplifications of the numbers of a file.
const NUMBER_SIMPLIFICATIONS: [fn(&mut Parts); 2] = [
    |parts| parts.recipe.scale = "1 1 1 1 1 1".parse().expect("constant numbers"),
    |parts| parts.recipe.bias = "0 0 0 0 0 0".parse().expect("constant numbers"),
];

/// Simplifications of a plane of a compressed file.
const PLANE_SIMPLIFICATIONS: [fn(&mut Parts, usize); 7] = [
    |parts, plane| parts.compressed().planes[plane].records.clear(),
    |parts, plane| {
        let records = &mut parts.compressed().planes[plane].records;
        records.truncate(records.len() / 2);
    },
    Parts::make_gray,
    |parts, plane| {
        let plan = &mut parts.compressed().plan;
        plan.references[plane] = -1;
        (
            plan.transforms[plane],
            plan.motion_x[plane],
            plan.motion_y[plane],
        ) = (0, 0, 0);
    },
    |parts, plane| parts.compressed().plan.transforms[plane] = 0,
    |parts, plane| parts.compressed().plan.motion_x[plane] = 0,
    |parts, plane| parts.compressed().plan.motion_y[plane] = 0,
];

impl Parts {
    fn parse(file: &[u8]) -> Option<Parts> {
        let ptm = decode(file).ok()?;
        let fields = Fields {
            file,
            fields: fields(file).0,
        };
        let mut recipe = Recipe::ordinary(ptm.header.format, ptm.header.size);
        recipe.scale = fields.text("2.4/3", 0..6).parse().ok()?;
        recipe.bias = fields.text("2.4/4", 0..6).parse().ok()?;
        if recipe.format == Format::Lum {
            recipe.matrix = fields.text("2.6/2", 0..16).parse().ok()?;
        }
        let mut model = Model::uncompressed(&recipe, ptm.planes.samples);
        if recipe.format.has_table() {
            model.table = fields.bytes("2.5/3", 0)?.to_vec();
            recipe.entries = model.entries() as u32;
            model.indices = indices(fields.bytes("2.8.1/1", 0)?, model.entries(), recipe.size);
        } else if recipe.format.coding().is_some() {
            fields.read_plan(&mut recipe)?;
            let planes = (0..recipe.format.channels())
                .map(|plane| fields.plane(plane))
                .collect::<Option<_>>()?;
            let plan = recipe.compression.clone();
            model.compressed = Some(Compressed { plan, planes });
        }
        Some(Parts { recipe, model })
    }

    fn write(&self) -> Vec<u8> {
        write(&self.recipe, &self.model).bytes
    }

    /// Returns all inputs that are one step simpler.
    fn steps(&self) -> Vec<Parts> {
        let simpler = |change: &dyn Fn(&mut Parts)| {
            let mut parts = self.clone();
            change(&mut parts);
            parts
        };
        let sizes = smaller_sizes(self.recipe.size).into_iter();
        let mut all: Vec<Parts> = sizes.filter_map(|size| self.crop_to(size)).collect();
        all.extend(NUMBER_SIMPLIFICATIONS.map(|change| simpler(&change)));
        if self.recipe.format.has_table() {
            all.extend([1, 2, 4].map(|share| self.with_fewer_entries(share)));
        }
        if let Some(Compressed { planes, .. }) = &self.model.compressed {
            for plane in 0..planes.len() {
                all.extend(
                    PLANE_SIMPLIFICATIONS.map(|change| simpler(&|parts| change(parts, plane))),
                );
            }
        }
        all
    }

    fn compressed(&mut self) -> &mut Compressed {
        self.model.compressed.as_mut().expect("a compressed format")
    }

    /// Crops the map to its top left corner.
    fn crop_to(&self, size: Size) -> Option<Parts> {
        let (old, Size { width, height }) = (self.recipe.size, size);
        let mut parts = self.clone();
        (parts.recipe.size, parts.model.size) = (size, size);
        let channels = self.recipe.format.channels();
        parts.model.samples = crop(&self.model.samples, channels, old, width, height);
        if self.recipe.format.has_table() {
            parts.model.indices = crop(&self.model.indices, 1, old, width, height);
        }
        if let Some(Compressed { planes, .. }) = &self.model.compressed {
            for (plane, new) in planes.iter().zip(&mut parts.compressed().planes) {
                *new = self.crop_plane(plane, width, height)?;
            }
        }
        Some(parts)
    }

    /// A plane is stored bottom row first, so its top left corner is at the end of the raster.
    fn crop_plane(&self, plane: &StoredPlane, width: u32, height: u32) -> Option<StoredPlane> {
        let old = self.recipe.size;
        let coding = self.recipe.compression.coding;
        let residual = (coding.decode(&plane.stream, old.width, old.height)).ok()?;
        let gone = old.height - height;
        let kept = &residual[(gone * old.width) as usize..];
        let rest = Size {
            width: old.width,
            height,
        };
        let crop_to = crop(kept, 1, rest, width, height);
        let parameter = self.recipe.compression.parameter;
        let moved = |&(position, value): &(u32, u8)| {
            let (x, y) = (position % old.width, position / old.width);
            (x < width && y >= gone).then(|| ((y - gone) * width + x, value))
        };
        Some(StoredPlane {
            stream: coding.encode(&crop_to, (width, height), parameter),
            records: plane.records.iter().filter_map(moved).collect(),
        })
    }

    /// Makes all residuals of a plane 128.
    fn make_gray(&mut self, plane: usize) {
        let Size { width, height } = self.recipe.size;
        let residual = vec![128; self.recipe.size.texels()];
        let parameter = self.recipe.compression.parameter;
        let stream = (self.recipe.compression.coding).encode(&residual, (width, height), parameter);
        self.compressed().planes[plane].stream = stream;
    }

    /// Keeps the first `1 / share` of the entries in use and reduces each index modulo their number.
    fn with_fewer_entries(&self, share: u32) -> Parts {
        let mut parts = self.clone();
        let in_use = self.model.indices.iter().max().map_or(1, |&last| last + 1);
        let kept = (in_use / share).max(1);
        parts
            .model
            .table
            .truncate(kept as usize * self.model.format.entry_size());
        parts.recipe.entries = kept;
        parts
            .model
            .indices
            .iter_mut()
            .for_each(|index| *index %= kept);
        parts
    }
}

/// Crops a raster with `channels` values per texel to its top left corner.
fn crop<T: Copy>(values: &[T], channels: usize, old: Size, width: u32, height: u32) -> Vec<T> {
    values
        .chunks_exact(old.width as usize * channels)
        .take(height as usize)
        .flat_map(|row| &row[..width as usize * channels])
        .copied()
        .collect()
}

/// Returns the indices, top row first.
fn indices(stored: &[u8], entries: usize, size: Size) -> Vec<u32> {
    let wide: Vec<u32> = if entries <= 256 {
        stored.iter().map(|&index| u32::from(index)).collect()
    } else {
        let wide = |pair: &[u8]| u32::from(pair[0]) | u32::from(pair[1]) << 8;
        stored.chunks_exact(2).map(wide).collect()
    };
    wide.chunks_exact(size.width as usize)
        .rev()
        .flatten()
        .copied()
        .collect()
}

/// Fields of a decoded file.
struct Fields<'a> {
    file: &'a [u8],
    fields: Vec<Field>,
}

impl<'a> Fields<'a> {
    fn fields_of_clause(&self, clause: &'static str) -> impl Iterator<Item = &'a [u8]> {
        let fields = self
            .fields
            .iter()
            .filter(move |field| field.clause == clause);
        fields.map(|field| &self.file[field.range.clone()])
    }

    fn bytes(&self, clause: &'static str, n: usize) -> Option<&'a [u8]> {
        self.fields_of_clause(clause).nth(n)
    }

    /// Joins some of the fields of a clause with spaces.
    fn text(&self, clause: &'static str, range: Range<usize>) -> String {
        let words: Vec<_> = self
            .fields_of_clause(clause)
            .skip(range.start)
            .take(range.len())
            .map(String::from_utf8_lossy)
            .collect();
        words.join(" ")
    }

    fn numbers<T: std::str::FromStr>(&self, clause: &'static str) -> Option<Vec<T>> {
        let number = |word: &[u8]| std::str::from_utf8(word).ok()?.parse().ok();
        self.fields_of_clause(clause).map(number).collect()
    }

    /// Copies the compression parameters (2.9.1–2.9.5) to `recipe`. Returns `None` if one of them cannot be read.
    fn read_plan(&self, recipe: &mut Recipe) -> Option<()> {
        let count = recipe.format.channels();
        let motion: Vec<i32> = self.numbers("2.9.3/1")?;
        let plan = &mut recipe.compression;
        plan.parameter = *self.numbers("2.9.1/1")?.first()?;
        plan.transforms = self.numbers("2.9.2/1")?;
        plan.motion_x = motion[..count].to_vec();
        plan.motion_y = motion[count..].to_vec();
        plan.order = self.numbers("2.9.4/1")?;
        plan.references = self.numbers("2.9.5/1")?;
        Some(())
    }

    fn plane(&self, plane: usize) -> Option<StoredPlane> {
        let record = |record: &[u8]| {
            let [a, b, c, d, value] = record.try_into().ok()?;
            Some((u32::from_be_bytes([a, b, c, d]), value))
        };
        let records = self.bytes("2.9.8/4", plane)?.chunks(5);
        Some(StoredPlane {
            stream: self.bytes("2.9.8/2", plane)?.to_vec(),
            records: records.map(record).collect::<Option<_>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::cases::{Case, Expect, Suite, TableSpelling};

    fn small_files() -> impl Iterator<Item = (String, Vec<u8>)> {
        let suite = Suite::load().expect("the suite loads");
        let small = |case: &Case| {
            case.expect == Expect::Decode
                && case
                    .recipe()
                    .is_some_and(|recipe| recipe.size.texels() < 200)
        };
        let file = |case: Case| {
            (
                case.id.clone(),
                case.build(TableSpelling::default()).file.clone(),
            )
        };
        suite.cases.into_iter().filter(small).map(file)
    }

    #[test]
    fn every_reduction_step_is_a_different_legal_file() {
        for (i, (id, file)) in small_files().enumerate() {
            let parts = Parts::parse(&file).expect("a legal file");
            let planes = |file: &[u8]| decode(file).expect("a legal file").planes;
            assert_eq!(planes(&parts.write()), planes(&file), "{id}");
            for parts in parts.steps().into_iter().filter(|_| i % 20 == 0) {
                assert_eq!(planes(&parts.write()).size, parts.recipe.size, "{id}");
            }
        }
    }

    #[test]
    fn failing_texel_is_isolated() {
        let recipe = Recipe::ordinary(Format::Rgb, "40x30".parse().expect("a size"));
        let file = write(&recipe, &Model::paint(&recipe)).bytes;
        let fails = |file: &[u8]| decode(file).is_ok_and(|ptm| ptm.planes.samples.len() >= 18 * 6);
        let small = reduce(&file, &AtomicBool::new(false), &fails).expect("it fails");
        assert_eq!(
            decode(&small).expect("a legal file").planes.samples.len(),
            18 * 6
        );
    }
}
