//! Painted maps whose planes, coefficients and colors are known by construction.
//!
//! The values of a file are computed from the painted scene, not by decoding the file.

use std::collections::HashMap;

use super::paint::{entry_of_texel, sample};
use super::planes::{self, Compressed};
use super::recipe::Recipe;
use crate::error::{Error, Result};
use ptm::{Format, Size};

/// The values of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The format of the file.
    pub format: Format,
    /// Width and height.
    pub size: Size,
    /// `height * width * channels` stored values, texel by texel, top row first.
    pub samples: Vec<u8>,
    /// The concatenated entries of the table; empty without a table.
    pub table: Vec<u8>,
    /// The index of each texel's table entry, top row first; empty without a table.
    pub indices: Vec<u32>,
    /// The scales of the coefficients.
    pub scale: [f64; 6],
    /// The biases of the coefficients.
    pub bias: [f64; 6],
    /// The sixteen numbers of the matrix, column-major.
    pub matrix: [f64; 16],
    /// The streams of a compressed format.
    pub compressed: Option<Compressed>,
    /// For each sample, the maximum difference between the results of inverse DCTs, modulo 256; empty if they all agree.
    pub slack: Vec<u8>,
}

impl Model {
    /// Paints the values of `recipe`.
    #[must_use]
    pub fn paint(recipe: &Recipe) -> Model {
        let channels = recipe.format.channels();
        let texels = recipe.size.texels();
        let samples = (0..texels * channels).map(|i| sample(recipe, i / channels, i % channels));
        let mut model = Model::uncompressed(recipe, samples.collect());
        if recipe.format.coding().is_some() {
            model.compress(recipe);
        } else if recipe.format.has_table() {
            model.paint_table(recipe);
        } else if let Some(first) = recipe.first_byte {
            // The payload begins with a0 of the bottom-left texel.
            model.samples[(texels - recipe.size.width as usize) * channels] = first;
        }
        model
    }

    /// Creates the values of a file with the header of `recipe` and the given `samples`, laid out as in [`Model::samples`].
    ///
    /// The table contains the distinct texels in stored order. After lossy compression, the model contains the decoded samples.
    ///
    /// # Errors
    /// Returns an error if the map has more distinct texels than a table can have entries.
    pub fn new(recipe: &Recipe, samples: &[u8]) -> Result<Model> {
        let mut model = Model::uncompressed(recipe, samples.to_vec());
        if recipe.format.coding().is_some() {
            model.compress(recipe);
        } else if recipe.format.has_table() {
            model.collect_table()?;
        }
        Ok(model)
    }

    /// Returns a model without a table or streams.
    #[must_use]
    pub fn uncompressed(recipe: &Recipe, samples: Vec<u8>) -> Model {
        Model {
            format: recipe.format,
            size: recipe.size,
            samples,
            table: Vec::new(),
            indices: Vec::new(),
            scale: recipe.scale.values,
            bias: recipe.bias.values,
            matrix: recipe.matrix.values,
            compressed: None,
            slack: Vec::new(),
        }
    }

    /// Encodes the streams, and sets the samples to those that an exact decoder returns.
    fn compress(&mut self, recipe: &Recipe) {
        let compressed;
        (compressed, self.samples, self.slack) = planes::encode(recipe, &self.samples);
        self.compressed = Some(compressed);
    }

    /// Builds a table of the distinct texels, and the indices into it.
    fn collect_table(&mut self) -> Result<()> {
        const MAX_TABLE_ENTRIES: usize = 65_536;
        let (size, width) = (self.format.entry_size(), self.size.width as usize);
        let mut known: HashMap<&[u8], u32> = HashMap::new();
        let mut indices = vec![0; self.size.texels()];
        let mut table = Vec::new();
        // Rows are visited in stored order, from the bottom up.
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
        if entries > MAX_TABLE_ENTRIES {
            return Err(Error::TooManyEntries { texels: entries });
        }
        (self.indices, self.table) = (indices, table);
        Ok(())
    }

    /// Paints the table and the indices, and sets the resulting samples.
    fn paint_table(&mut self, recipe: &Recipe) {
        let size = self.format.entry_size();
        self.table = (0..recipe.entries as usize * size)
            .map(|i| sample(recipe, i / size, i % size))
            .collect();
        if let Some(first) = recipe.first_byte {
            self.table[0] = first;
        }
        self.indices = (0..self.size.texels())
            .map(|texel| entry_of_texel(recipe, texel))
            .collect();
        for (texel, &index) in self.samples.chunks_exact_mut(9).zip(&self.indices) {
            texel[..size].copy_from_slice(&self.table[index as usize * size..][..size]);
        }
    }

    /// Returns the number of entries in the table.
    #[must_use]
    pub fn entries(&self) -> usize {
        self.table.len() / self.format.entry_size()
    }

    /// Returns `height * width * channels` final values: (raw − bias) · scale for coefficients, and bytes for other channels.
    #[must_use]
    pub fn coefficients(&self) -> Vec<f64> {
        self.final_values(&self.samples, |raw, i| (raw - self.bias[i]) * self.scale[i])
    }

    /// Returns the final values of `samples`. The value of coefficient a*i* is `coefficient(raw, i)`.
    fn final_values(&self, samples: &[u8], coefficient: impl Fn(f64, usize) -> f64) -> Vec<f64> {
        let channels = self.format.channels();
        let polynomials = if channels == 18 { 18 } else { 6 };
        let value = |(i, &byte): (usize, &u8)| match i % channels {
            channel if channel < polynomials => coefficient(f64::from(byte), channel % 6),
            _ => f64::from(byte),
        };
        samples.iter().enumerate().map(value).collect()
    }

    /// Returns `height * width * 3` unrounded color values from 0 to 255 under the light (`u`, `v`).
    #[must_use]
    pub fn colors(&self, u: f64, v: f64) -> Vec<f64> {
        let powers = [u * u, v * v, u * v, u, v, 1.0];
        let polynomial = |a: &[f64]| -> f64 { (0..6).map(|i| a[i] * powers[i]).sum() };
        let color = |texel: &[f64]| match texel.len() {
            18 => [0, 6, 12].map(|channel| polynomial(&texel[channel..])),
            9 => [6, 7, 8].map(|channel| polynomial(&texel[..6]) * texel[channel] / 255.0),
            _ => {
                let input = [polynomial(&texel[..6]), texel[6], texel[7], 1.0];
                let product = |row, column| self.matrix[4 * column + row] * input[column];
                [0, 1, 2].map(|row| (0..4).map(|column| product(row, column)).sum())
            }
        };
        let coefficients = self.coefficients();
        let colors = coefficients.chunks_exact(self.format.channels());
        let colors = colors.flat_map(color);
        colors.map(|value| value.clamp(0.0, 255.0)).collect()
    }

    /// Returns the maximum difference that inverse DCTs cause in each final value, or an empty list if they all agree.
    #[must_use]
    pub fn coefficient_slack(&self) -> Vec<f64> {
        self.final_values(&self.slack, |slack, i| slack * self.scale[i].abs())
    }

    /// Returns the maximum difference that inverse DCTs cause in each color, or an empty list if they all agree.
    #[must_use]
    pub fn color_slack(&self, u: f64, v: f64) -> Vec<f64> {
        let powers = [u * u, v * v, u * v, u, v, 1.0];
        let sum = |a: &[f64], weigh: fn(f64) -> f64| -> f64 {
            (0..6).map(|i| weigh(a[i] * powers[i])).sum()
        };
        let color = |(values, slack): (&[f64], &[f64])| {
            if values.len() == 18 {
                [0, 6, 12].map(|channel| sum(&slack[channel..], f64::abs))
            } else {
                // This is the maximum deviation of a product of two values that both deviate.
                let luminance = sum(values, |term| term).abs();
                let deviation = sum(slack, f64::abs);
                [6, 7, 8]
                    .map(|c| (deviation * (values[c] + slack[c]) + luminance * slack[c]) / 255.0)
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
