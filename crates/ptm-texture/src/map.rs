//! Texture maps, which consist of levels of texels.
//!
//! A map has one to three dimensions and at least one level. Level 0 is the base, and the last level is the pinnacle. The
//! texels of a level are ordered along t0 first, then t1, then t2, beginning at t0 = t1 = t2 = 0 (ruling `texel-order`).
//!
//! Format notes
//! - t0 = t1 = 0 is the *lower* left of the image.
//! - A texel with luminance L represents the color (L, L, L) (R-CMP-14).
//! - Levels may have any size and are used as given. [`TextureMap::with_box_levels`] creates a conventional mipmap.

use std::fmt;
use std::str::FromStr;

use super::entry::{Color, enumerants};
use super::rules::Rules;
use crate::error::Error;

enumerants! {
    /// Components of a texel.
    TexelKind ["PEXTexelType"] {
        /// Luminance.
        L,
        /// Luminance and alpha.
        LA,
        /// Red, green, blue.
        RGB,
        /// Red, green, blue, alpha.
        RGBA,
    }
}

impl TexelKind {
    /// Returns the number of components.
    #[must_use]
    pub const fn components(self) -> usize {
        match self {
            TexelKind::L => 1,
            TexelKind::LA => 2,
            TexelKind::RGB => 3,
            TexelKind::RGBA => 4,
        }
    }
}

/// Indices of two neighboring cells along a dimension, each with its weight. The weights sum to 1.
pub type CellPair = [(usize, f64); 2];

/// Sample of a texture map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texel {
    kind: TexelKind,
    /// Components, followed by zeros.
    values: [f64; 4],
}

impl Texel {
    /// Creates a texel. Returns `None` if the number of components does not match the kind.
    #[must_use]
    pub fn new(kind: TexelKind, components: &[f64]) -> Option<Texel> {
        let mut values = [0.0; 4];
        let target = values.get_mut(..components.len())?;
        target.copy_from_slice(components);
        (components.len() == kind.components()).then_some(Texel { kind, values })
    }

    /// Creates a texel with a color and no alpha.
    #[must_use]
    pub const fn rgb([r, g, b]: Color) -> Texel {
        Texel {
            kind: TexelKind::RGB,
            values: [r, g, b, 0.0],
        }
    }

    /// Returns the kind of the texel.
    #[must_use]
    pub const fn kind(&self) -> TexelKind {
        self.kind
    }

    /// Returns the components of the texel.
    #[must_use]
    pub fn components(&self) -> &[f64] {
        &self.values[..self.kind.components()]
    }

    /// Returns the components, followed by zeros.
    pub(super) const fn values(&self) -> [f64; 4] {
        self.values
    }

    /// Returns the alpha component, if the texel has one (R-CMP-15).
    #[must_use]
    pub fn alpha(&self) -> Option<f64> {
        match self.kind {
            TexelKind::LA => Some(self.values[1]),
            TexelKind::RGBA => Some(self.values[3]),
            _ => None,
        }
    }

    /// Returns the luminance, if the texel has no color components.
    #[must_use]
    pub fn luminance(&self) -> Option<f64> {
        matches!(self.kind, TexelKind::L | TexelKind::LA).then_some(self.values[0])
    }

    /// Returns a texel whose components are changed by `change`, which gets the index and the value of a component.
    #[must_use]
    pub fn map_components(mut self, change: impl Fn(usize, f64) -> f64) -> Texel {
        for c in 0..self.kind.components() {
            self.values[c] = change(c, self.values[c]);
        }
        self
    }

    /// Returns the weighted sum of texels of the same kind.
    pub fn sum(kind: TexelKind, parts: impl Iterator<Item = (Texel, f64)>) -> Texel {
        let mut values = [0.0; 4];
        for (texel, weight) in parts {
            for (value, part) in values.iter_mut().zip(texel.values) {
                *value += weight * part;
            }
        }
        Texel { kind, values }
    }
}

/// Returns the color of a texel: (R, G, B) or (L, L, L) (R-CMP-14).
#[must_use]
pub fn texel_color(texel: &Texel) -> Color {
    let v = texel.values;
    match texel.luminance() {
        Some(luminance) => [luminance; 3],
        None => [v[0], v[1], v[2]],
    }
}

/// Level of a texture map.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Number of texels along t0, t1 and t2; 1 for directions beyond the dimensions of the map.
    pub size: [usize; 3],
    /// `size[0] * size[1] * size[2]` texels; t0 varies fastest.
    pub texels: Vec<Texel>,
}

/// Texture map with levels from the base to the pinnacle.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureMap {
    dimensions: usize,
    kind: TexelKind,
    levels: Vec<Level>,
}

impl TextureMap {
    /// Creates a map with one to three dimensions.
    ///
    /// # Errors
    /// Returns an error if `dimensions` is not 1, 2 or 3, if there is no valid base level, or if a level is invalid.
    pub fn new(dimensions: usize, levels: Vec<Level>) -> Result<TextureMap, Error> {
        if !(1..=3).contains(&dimensions) {
            return Err(Error::Dimensions(dimensions));
        }
        let first = levels.first().and_then(|level| level.texels.first());
        let kind = first.ok_or(Error::NoBaseLevel)?.kind;
        for (number, level) in levels.iter().enumerate() {
            let (size, count) = (level.size, level.texels.len());
            let mut sides = size.iter();
            let texels = sides.try_fold(1_usize, |product, &side| product.checked_mul(side));
            if texels != Some(count) || count == 0 {
                return Err(Error::TexelCount {
                    level: number,
                    size,
                    count,
                });
            }
            if size[dimensions..].iter().any(|&side| side != 1) {
                return Err(Error::TooManyDimensions {
                    level: number,
                    size,
                    dimensions,
                });
            }
            if level.texels.iter().any(|texel| texel.kind != kind) {
                return Err(Error::MixedTexels { level: number });
            }
        }
        Ok(TextureMap {
            dimensions,
            kind,
            levels,
        })
    }

    /// Returns the number of dimensions, which equals the number of coordinates of a sample (R-PAR-03).
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Returns the kind of the texels.
    #[must_use]
    pub fn kind(&self) -> TexelKind {
        self.kind
    }

    /// Returns the levels from the base to the pinnacle. There is at least one.
    #[must_use]
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Returns the map as a stage stores it.
    #[must_use]
    pub fn stored(mut self, rules: &Rules) -> TextureMap {
        for texel in self.levels.iter_mut().flat_map(|level| &mut level.texels) {
            *texel = texel.map_components(|_, value| (rules.stored_component)(value));
        }
        self
    }

    /// Returns a map with the same base level followed by box-filtered levels that halve the size, down to one texel. Each texel
    /// is the average of the area that it covers (ruling `level-making`).
    #[must_use]
    pub fn with_box_levels(self) -> TextureMap {
        let mut levels = vec![self.levels.into_iter().next().expect("a map has a base")];
        while levels[levels.len() - 1].size != [1, 1, 1] {
            levels.push(half_size_level(&levels[levels.len() - 1]));
        }
        TextureMap { levels, ..self }
    }
}

/// Returns a component of a texel unchanged: components are real numbers.
#[must_use]
pub fn stored_component(value: f64) -> f64 {
    value
}

/// Box-filters a level to half its size, rounded down.
fn half_size_level(fine: &Level) -> Level {
    let size = fine.size.map(|side| (side / 2).max(1));
    let coverage = |d: usize| (0..size[d]).map(move |at| covered_cells(at, fine.size[d], size[d]));
    let coverage: [Vec<Vec<(usize, f64)>>; 3] = [0, 1, 2].map(|d| coverage(d).collect());
    let mut texels = Vec::with_capacity(size[0] * size[1] * size[2]);
    for z in &coverage[2] {
        for y in &coverage[1] {
            for x in &coverage[0] {
                let parts = z.iter().flat_map(|&(k, wz)| {
                    y.iter().flat_map(move |&(j, wy)| {
                        x.iter().map(move |&(i, wx)| ([i, j, k], wx * wy * wz))
                    })
                });
                let parts = parts.map(|(at, w)| (fine.texels[texel_offset(fine.size, at)], w));
                texels.push(Texel::sum(fine.texels[0].kind, parts));
            }
        }
    }
    Level { size, texels }
}

/// Returns the fine cells that coarse cell `at` covers, with their weights. `fine` and `coarse` are cell counts.
fn covered_cells(at: usize, fine: usize, coarse: usize) -> Vec<(usize, f64)> {
    let (low, high) = (at * fine, (at + 1) * fine);
    // In units of 1/(fine · coarse): fine cell k runs from k·coarse to (k + 1)·coarse.
    let overlap = |k: usize| {
        let (from, to) = (low.max(k * coarse), high.min((k + 1) * coarse));
        (k, (to - from) as f64 / fine as f64)
    };
    (low / coarse..high.div_ceil(coarse)).map(overlap).collect()
}

/// Returns the index of the texel with coordinates `at` in a level. t0 varies fastest, then t1, then t2 (ruling `texel-order`).
#[must_use]
pub fn texel_offset(size: [usize; 3], at: [usize; 3]) -> usize {
    (at[2] * size[1] + at[1]) * size[0] + at[0]
}
