//! A texture map from a PTM under a light.
//!
//! The image of the map under the light (u, v), clamped to 0 … 255, becomes a map of RGB texels from 0 to 1, with the base
//! level only.
//!
//! Format notes
//! - A PTM stores its bottom row first and a texture map begins at the lower left, so their orders agree. Images
//!   of this library run from the top, so rows are turned once, here.
//! - Texels are not rounded; a viewer that keeps eight bits rounds halves up (ruling `ptm-texels`).

use super::map::{Level, Texel, TextureMap};
use super::rules::Rules;
use crate::evaluate::{Coefficients, RelitImage};

/// The rounding of the values of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rounding {
    /// No rounding.
    None,
    /// To 256 levels.
    EightBits,
}

impl TextureMap {
    /// Returns the map of a PTM under the light (`lu`, `lv`).
    #[must_use]
    pub fn from_ptm(
        coefficients: &Coefficients,
        lu: f64,
        lv: f64,
        rounding: Rounding,
        rules: &Rules,
    ) -> TextureMap {
        let picture = coefficients.evaluate(lu, lv);
        let value = |value: f64| match rounding {
            Rounding::None => value / 255.0,
            Rounding::EightBits => (rules.to_eight_bits)(value) / 255.0,
        };
        let colors = (rules.rows)(&picture).into_iter();
        let texels = colors.map(|color| Texel::rgb(color.map(value)));
        let size = [picture.size.width as usize, picture.size.height as usize, 1];
        let base = Level {
            size,
            texels: texels.collect(),
        };
        TextureMap::new(2, vec![base]).expect("a PTM has at least one texel")
    }
}

/// Returns the texels of an image, bottom row first (ruling `ptm-rows`).
pub(crate) fn rows_from_bottom(picture: &RelitImage) -> Vec<[f64; 3]> {
    let width = picture.size.width as usize;
    let rows = picture.values.chunks_exact(3 * width).rev();
    rows.flat_map(|row| row.chunks_exact(3).map(|c| [c[0], c[1], c[2]]))
        .collect()
}

/// Returns the nearest whole number, halves up (ruling `ptm-texels`).
pub(crate) fn halves_up(value: f64) -> f64 {
    (value + 0.5).floor()
}
