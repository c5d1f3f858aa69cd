//! Painted maps whose planes, coefficients and colors are known by construction.
//!
//! Painting uses whole numbers only, so a recipe gives the same values on every machine. What a file means is computed
//! here from what was painted, not by decoding the file.

use std::collections::HashMap;
use std::str::FromStr;

use super::plan::Compression;
use super::planes;
use super::recipe::{Indices, Recipe};
use crate::ptm::{Format, Size};

/// What is painted into the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// Every sample its own pseudo-random byte.
    Noise,
    /// 0 or 255, pseudo-random.
    Extremes,
    /// Slopes: to the right, downwards and from channel to channel.
    Ramp,
    /// Each channel one value of its own, all texels alike.
    Stripes,
    /// One value everywhere.
    Flat(u8),
    /// As noise, but the coefficients are 128 save a5, so that no light changes anything.
    Unlit,
    /// As unlit, and Cr equals a5: luminance and Cr are one under scale 1 and bias 0.
    LuminanceIsCr,
    /// Every sample its own pseudo-random byte from 96 to 159, far from both ends.
    Soft,
    /// As noise, within two rings of one value.
    Framed(u8),
    /// One value along every line from the bottom left to the top right; across, four values in turn.
    Diagonals,
    /// Two values in turn, column by column; their sum is odd.
    Columns,
    /// Two values in turn, row by row; their sum is odd.
    Rows,
}

impl FromStr for Scene {
    type Err = String;

    /// `noise`, `extremes`, `ramp`, `stripes`, `flat-200`, `unlit`, `luminance-is-cr`, `soft`, `framed-128`, `diagonals`, `columns`, `rows`.
    fn from_str(name: &str) -> Result<Scene, String> {
        Ok(match name {
            "noise" => Scene::Noise,
            "extremes" => Scene::Extremes,
            "ramp" => Scene::Ramp,
            "stripes" => Scene::Stripes,
            "unlit" => Scene::Unlit,
            "luminance-is-cr" => Scene::LuminanceIsCr,
            "soft" => Scene::Soft,
            "diagonals" => Scene::Diagonals,
            "columns" => Scene::Columns,
            "rows" => Scene::Rows,
            _ => {
                let value = |prefix| {
                    name.strip_prefix(prefix)
                        .and_then(|value| value.parse().ok())
                };
                let scene = value("flat-")
                    .map(Scene::Flat)
                    .or(value("framed-").map(Scene::Framed));
                scene.ok_or_else(|| format!("unknown scene {name:?}"))?
            }
        })
    }
}

/// The values of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Which format.
    pub format: Format,
    /// Width and height.
    pub size: Size,
    /// `height * width * channels` stored values, texel after texel, top row first.
    pub samples: Vec<u8>,
    /// The table's entries one after the other; empty without one.
    pub table: Vec<u8>,
    /// The entry of each texel, top row first; empty without a table.
    pub indices: Vec<u32>,
    /// The scales.
    pub scale: [f64; 6],
    /// The biases.
    pub bias: [f64; 6],
    /// The sixteen numbers of the matrix, columns first.
    pub matrix: [f64; 16],
    /// The streams of a compressed format.
    pub compressed: Option<Compressed>,
    /// For each of the samples, how far another inverse DCT may be off, counted around the circle of 256 values; empty
    /// where none can be.
    pub slack: Vec<u8>,
}

/// What a compressed file holds (2.9).
#[derive(Clone, Debug, PartialEq)]
pub struct Compressed {
    /// The lists.
    pub plan: Compression,
    /// The planes, in their own order.
    pub planes: Vec<StoredPlane>,
}

/// A plane as it is stored (2.9.8).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredPlane {
    /// The JPEG or JPEG-LS stream.
    pub stream: Vec<u8>,
    /// Positions in the stored raster, and values.
    pub records: Vec<(u32, u8)>,
}

impl StoredPlane {
    /// Five bytes a record: the position, high byte first, and the value (clauses 2.9.8/5–8).
    #[must_use]
    pub fn side_information(&self) -> Vec<u8> {
        self.records
            .iter()
            .flat_map(|&(position, value)| [&position.to_be_bytes()[..], &[value]].concat())
            .collect()
    }
}

impl Model {
    /// Paints the values of `recipe`.
    #[must_use]
    pub fn paint(recipe: &Recipe) -> Model {
        let channels = recipe.format.channels();
        let texels = recipe.size.texels();
        let mut model = Model {
            format: recipe.format,
            size: recipe.size,
            samples: (0..texels * channels)
                .map(|i| sample(recipe, i / channels, i % channels))
                .collect(),
            table: Vec::new(),
            indices: Vec::new(),
            scale: recipe.scale.values,
            bias: recipe.bias.values,
            matrix: recipe.matrix.values,
            compressed: None,
            slack: Vec::new(),
        };
        if recipe.format.is_compressed() {
            let planes::Encoding {
                samples,
                slack,
                compressed,
            } = planes::encode(recipe, &|texel, channel| sample(recipe, texel, channel));
            (model.samples, model.slack, model.compressed) = (samples, slack, Some(compressed));
        } else if recipe.format.has_table() {
            model.paint_table(recipe);
        } else if let Some(first) = recipe.first {
            // The payload begins with a0 of the bottom left texel.
            model.samples[(texels - recipe.size.width as usize) * channels] = first;
        }
        model
    }

    /// The values of a map that exists, in the header and the format of `recipe`: `samples` as in [`Model::samples`].
    ///
    /// A table has the distinct texels in the order in which they are stored. What a lossy compression leaves of the
    /// samples is the model's.
    pub fn of(recipe: &Recipe, samples: &[u8]) -> Result<Model, String> {
        let channels = recipe.format.channels();
        let mut model = Model {
            format: recipe.format,
            size: recipe.size,
            samples: samples.to_vec(),
            table: Vec::new(),
            indices: Vec::new(),
            scale: recipe.scale.values,
            bias: recipe.bias.values,
            matrix: recipe.matrix.values,
            compressed: None,
            slack: Vec::new(),
        };
        if recipe.format.is_compressed() {
            let encoding = planes::encode(recipe, &|texel, channel| {
                samples[texel * channels + channel]
            });
            model.samples = encoding.samples;
            model.slack = encoding.slack;
            model.compressed = Some(encoding.compressed);
        } else if recipe.format.has_table() {
            model.collect_table()?;
        }
        Ok(model)
    }

    /// A table of the distinct texels, and the indices that name them.
    fn collect_table(&mut self) -> Result<(), String> {
        const MOST: usize = 65_536;
        let (size, width) = (self.entry_size(), self.size.width as usize);
        let mut known: HashMap<&[u8], u32> = HashMap::new();
        let mut indices = vec![0; self.size.texels()];
        let mut table = Vec::new();
        // From the bottom row up, as they are stored.
        for row in (0..self.size.height as usize).rev() {
            let texels = row * width..(row + 1) * width;
            for (index, texel) in indices[texels.clone()].iter_mut().zip(texels) {
                let entry = &self.samples[9 * texel..][..size];
                let next = known.len() as u32;
                *index = *known.entry(entry).or_insert_with(|| {
                    table.extend_from_slice(entry);
                    next
                });
            }
        }
        let entries = known.len();
        if entries > MOST {
            return Err(format!(
                "{entries} texels are distinct, and two bytes name at most {MOST} entries"
            ));
        }
        (self.indices, self.table) = (indices, table);
        Ok(())
    }

    /// The table, the indices, and the samples that come of them.
    fn paint_table(&mut self, recipe: &Recipe) {
        let size = self.entry_size();
        self.table = (0..recipe.entries as usize * size)
            .map(|i| sample(recipe, i / size, i % size))
            .collect();
        if let Some(first) = recipe.first {
            self.table[0] = first;
        }
        self.indices = (0..self.size.texels())
            .map(|texel| index(recipe, texel))
            .collect();
        for (texel, &index) in self.samples.chunks_exact_mut(9).zip(&self.indices) {
            texel[..size].copy_from_slice(&self.table[index as usize * size..][..size]);
        }
    }

    /// Bytes of a table entry: 6, or 9 where the colour is in the table.
    #[must_use]
    pub fn entry_size(&self) -> usize {
        if self.format == Format::PtmCLut { 9 } else { 6 }
    }

    /// Entries of the table.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.table.len() / self.entry_size()
    }

    /// `height * width * channels` final values: (raw − bias) · scale for coefficients, the byte itself for the rest.
    #[must_use]
    pub fn coefficients(&self) -> Vec<f64> {
        let channels = self.format.channels();
        let polynomials = if channels == 18 { 18 } else { 6 };
        let value = |(i, &byte): (usize, &u8)| match i % channels {
            channel if channel < polynomials => {
                (f64::from(byte) - self.bias[channel % 6]) * self.scale[channel % 6]
            }
            _ => f64::from(byte),
        };
        self.samples.iter().enumerate().map(value).collect()
    }

    /// `height * width * 3` colors from 0 to 255 under the light (`u`, `v`), not rounded.
    #[must_use]
    pub fn picture(&self, u: f64, v: f64) -> Vec<f64> {
        let powers = [u * u, v * v, u * v, u, v, 1.0];
        let polynomial = |a: &[f64]| {
            a.iter()
                .zip(powers)
                .map(|(a, power)| a * power)
                .sum::<f64>()
        };
        let color = |texel: &[f64]| match texel.len() {
            18 => [
                polynomial(&texel[..6]),
                polynomial(&texel[6..12]),
                polynomial(&texel[12..]),
            ],
            9 => [6, 7, 8].map(|channel| polynomial(&texel[..6]) * texel[channel] / 255.0),
            _ => {
                let input = [polynomial(&texel[..6]), texel[6], texel[7], 1.0];
                [0, 1, 2].map(|row| {
                    (0..4)
                        .map(|column| self.matrix[4 * column + row] * input[column])
                        .sum()
                })
            }
        };
        let coefficients = self.coefficients();
        coefficients
            .chunks_exact(self.format.channels())
            .flat_map(color)
            .map(|value| value.clamp(0.0, 255.0))
            .collect()
    }

    /// How far each of the final values may be off where inverse DCTs differ; empty where none may.
    #[must_use]
    pub fn coefficient_slack(&self) -> Vec<f64> {
        let channels = self.format.channels();
        let polynomials = if channels == 18 { 18 } else { 6 };
        let slack = |(i, &slack): (usize, &u8)| match i % channels {
            channel if channel < polynomials => f64::from(slack) * self.scale[channel % 6].abs(),
            _ => f64::from(slack),
        };
        self.slack.iter().enumerate().map(slack).collect()
    }

    /// How far each color may be off; empty where none may.
    #[must_use]
    pub fn picture_slack(&self, u: f64, v: f64) -> Vec<f64> {
        let powers = [u * u, v * v, u * v, u, v, 1.0];
        let sum = |a: &[f64], weigh: fn(f64) -> f64| {
            a.iter()
                .zip(powers)
                .map(|(a, power)| weigh(a * power))
                .sum::<f64>()
        };
        let color = |(values, slack): (&[f64], &[f64])| match values.len() {
            18 => [0, 6, 12].map(|channel| sum(&slack[channel..channel + 6], f64::abs)),
            _ => {
                // The largest that a product can be off where both factors are.
                let (luminance, off) = (
                    sum(&values[..6], |term| term).abs(),
                    sum(&slack[..6], f64::abs),
                );
                [6, 7, 8].map(|channel| {
                    (off * (values[channel] + slack[channel]) + luminance * slack[channel]) / 255.0
                })
            }
        };
        let channels = self.format.channels();
        let (values, slack) = (self.coefficients(), self.coefficient_slack());
        values
            .chunks_exact(channels)
            .zip(slack.chunks_exact(channels))
            .flat_map(color)
            .collect()
    }
}

/// The painted byte of a channel of a texel, or of an entry.
pub(super) fn sample(recipe: &Recipe, texel: usize, channel: usize) -> u8 {
    let (width, height) = (recipe.size.width as usize, recipe.size.height as usize);
    let (x, y) = (texel % width, texel / width);
    let noise = hash(recipe.seed, texel, channel) as u8;
    match recipe.scene {
        Scene::Noise => noise,
        Scene::Extremes => noise % 2 * 255,
        Scene::Ramp => (x * 7 + y * 29 + channel * 53 + recipe.seed as usize) as u8,
        Scene::Stripes => (10 + channel * 13 + recipe.seed as usize) as u8,
        Scene::Flat(value) => value,
        Scene::Unlit if channel < 5 => 128,
        Scene::Unlit => noise,
        Scene::LuminanceIsCr if channel < 5 => 128,
        Scene::LuminanceIsCr if channel == 6 => hash(recipe.seed, texel, 5) as u8,
        Scene::LuminanceIsCr => noise,
        Scene::Framed(value) if x.min(y) < 2 || x + 2 >= width || y + 2 >= height => value,
        Scene::Framed(_) => noise,
        Scene::Soft => 96 + noise % 64,
        // Along a line x + y is the same, because y runs downwards here.
        Scene::Diagonals => hash(recipe.seed, (x + y) % 4, channel) as u8,
        Scene::Columns => two(recipe.seed, x, channel),
        Scene::Rows => two(recipe.seed, y, channel),
    }
}

/// One of two bytes of different parity, in turn.
fn two(seed: u32, place: usize, channel: usize) -> u8 {
    let even = hash(seed, 0, channel) as u8;
    if place.is_multiple_of(2) {
        even
    } else {
        hash(seed, 1, channel) as u8 & 0xfe | !even & 1
    }
}

/// The entry of a texel.
fn index(recipe: &Recipe, texel: usize) -> u32 {
    let entries = recipe.entries;
    let any = hash(recipe.seed ^ 0x5bd1, texel, 99);
    match &recipe.indices {
        Indices::Any => match texel {
            1 => entries - 1,
            2 => 0,
            _ => any % entries,
        },
        Indices::Below(limit) => any % entries.min(*limit),
        Indices::BytesDiffer => {
            // Walk on to the next index whose bytes differ; of two neighbours one always does.
            let start = any % entries;
            (0..entries)
                .map(|step| (start + step) % entries)
                .find(|index| index % 256 != index / 256)
                .unwrap_or(0)
        }
        Indices::These(list) => list[texel % list.len()],
    }
}

/// A pseudo-random number for a place: the finaliser of `MurmurHash3` over seed, texel and channel.
pub(super) fn hash(seed: u32, texel: usize, channel: usize) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b1)
        ^ (texel as u32).wrapping_mul(0x85eb_ca77)
        ^ (channel as u32).wrapping_mul(0xc2b2_ae3d);
    h = (h ^ h >> 16).wrapping_mul(0x85eb_ca6b);
    h = (h ^ h >> 13).wrapping_mul(0xc2b2_ae35);
    h ^ h >> 16
}
