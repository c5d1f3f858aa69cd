//! Converts a PTM, lit from one direction, to a texture map.
//!
//! The image of the PTM under the light (u, v) is clamped to 0 … 255 and scaled to 0 … 1. It is the only level of the map.
//!
//! Format notes
//! - A PTM stores its bottom row first, and a texture map begins at the lower left, so the orders agree. Images in this
//!   library begin with the top row, so the rows are reversed here.
//! - Texels are not rounded. A viewer that stores eight bits rounds halves up (ruling `ptm-texels`).

use super::map::{Level, Texel, TextureMap};
use super::rules::Rules;
use ptm::evaluate::{Coefficients, RelitImage};

/// Rounding of the values of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rounding {
    /// Values are not rounded.
    None,
    /// Values are rounded to 256 levels.
    EightBits,
}

impl TextureMap {
    /// Creates a texture map from a PTM under the light (`lu`, `lv`).
    #[must_use]
    pub fn from_ptm(
        coefficients: &Coefficients,
        lu: f64,
        lv: f64,
        rounding: Rounding,
        rules: &Rules,
    ) -> TextureMap {
        let image = coefficients.evaluate(lu, lv);
        let value = |value: f64| match rounding {
            Rounding::None => value / 255.0,
            Rounding::EightBits => (rules.to_eight_bits)(value) / 255.0,
        };
        let colors = (rules.rows)(&image).into_iter();
        let texels = colors.map(|color| Texel::rgb(color.map(value)));
        let size = [image.size.width as usize, image.size.height as usize, 1];
        let base = Level {
            size,
            texels: texels.collect(),
        };
        TextureMap::new(2, vec![base]).expect("a PTM has at least one texel")
    }
}

/// Returns the texels of an image, bottom row first (ruling `ptm-rows`).
pub fn rows_bottom_up(image: &RelitImage) -> Vec<[f64; 3]> {
    let width = image.size.width as usize;
    let rows = image.values.chunks_exact(3 * width).rev();
    rows.flat_map(|row| row.chunks_exact(3).map(|c| [c[0], c[1], c[2]]))
        .collect()
}

/// Rounds to the nearest integer, with halves rounded up (ruling `ptm-texels`).
pub fn round_half_up(value: f64) -> f64 {
    (value + 0.5).floor()
}
