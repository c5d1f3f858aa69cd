//! Precision of sampling: how far a correct sample may be from the exact one (ruling `filter-precision`).
//!
//! Texture units store weights with eight bits. A filter weight is rounded to a multiple of 1/256, so its error is at most
//! 1/512, and 0 and 1 are exact. The weights of the 2ⁿ texels are also multiples of 1/256, so they are not the products of
//! rounded filter weights. The weight of a level is truncated to a multiple of 1/256, so its error is less than 1/256.
//!
//! An average is a sum over the sets S of directions of c · Π f over the directions of S, where f is the upper weight of a
//! direction, and c is the *mixed difference* of the texels: of two neighbors for one direction, of two such differences for two
//! directions. Rounding changes f by at most 1/512, and rounding the weight of a corner changes a product by at most 1/512. The
//! largest mixed difference of a set, at any position in the other directions, bounds the effect of each:
//!
//! ```text
//! tolerance of an average = Σ over S of (largest mixed difference of S) · min over S of min(f, 1 − f, 1/512)
//! tolerance between levels = interpolated tolerance + (difference of levels) · min(weight, 1/256)
//! ```
//!
//! Format notes
//! - If the texels are a linear function of their indices, the mixed differences of several directions are 0. What remains is
//!   the sum over directions of the texel difference divided by 512.
//! - The tolerance is added to the one for arithmetic in single precision. The closest texel has none.

use super::map::Texel;
use super::primitive::MapValue;

/// Maximum error of a filter weight that is rounded to a multiple of 1/256.
pub const MAX_WEIGHT_ERROR: f64 = 1.0 / 512.0;

/// Maximum error of the weight of a level, which is truncated to a multiple of 1/256.
pub const MAX_LEVEL_WEIGHT_ERROR: f64 = 1.0 / 256.0;

/// Deviation that is allowed for each component of a texel.
pub type Tolerance = [f64; 4];

/// Exact sample of a map, and the deviation that is allowed for each component.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleratedSample {
    /// Exact sample.
    pub value: MapValue,
    /// Tolerance of each component; 0 for components that the sample lacks.
    pub tolerance: Tolerance,
}

impl ToleratedSample {
    /// Creates a sample without a tolerance.
    #[must_use]
    pub fn exact(value: MapValue) -> ToleratedSample {
        ToleratedSample {
            value,
            tolerance: [0.0; 4],
        }
    }
}

/// Texel that results from filtering, and its tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Filtered {
    pub texel: Texel,
    pub tolerance: Tolerance,
}

impl Filtered {
    /// Creates the result of a filter that does not compute: a texel of the map.
    pub fn exact(texel: Texel) -> Filtered {
        Filtered {
            texel,
            tolerance: [0.0; 4],
        }
    }

    /// Interpolates between two levels. `weight` is the weight of the upper level.
    pub fn interpolate(lower: &Filtered, upper: &Filtered, weight: f64) -> Filtered {
        let parts = [(lower.texel, 1.0 - weight), (upper.texel, weight)];
        let [a, b] = [lower.texel.values(), upper.texel.values()];
        let [ta, tb] = [lower.tolerance, upper.tolerance];
        let error = weight.clamp(0.0, MAX_LEVEL_WEIGHT_ERROR);
        Filtered {
            texel: Texel::sum(lower.texel.kind(), parts.into_iter()),
            tolerance: [0, 1, 2, 3].map(|c| {
                let interpolated = (1.0 - weight) * ta[c] + weight * tb[c];
                interpolated + error * ((b[c] - a[c]).abs() + (tb[c] - ta[c]).abs())
            }),
        }
    }
}

/// Returns the tolerance of the average of `corners`. Bit d of the index of a corner is set if the corner is the upper neighbor
/// in direction d, and `weights[d]` is the weight of the upper neighbors.
pub fn tolerance_of_average(corners: &[Texel], weights: &[f64]) -> Tolerance {
    let mut tolerance = [0.0; 4];
    for set in 1..corners.len() {
        let error = (0..weights.len())
            .filter(|d| set >> d & 1 == 1)
            .map(|d| weights[d].min(1.0 - weights[d]).max(0.0))
            .fold(MAX_WEIGHT_ERROR, f64::min);
        let largest = largest_mixed_difference(corners, set);
        for (sum, difference) in tolerance.iter_mut().zip(largest) {
            *sum += error * difference;
        }
    }
    tolerance
}

/// Returns the largest magnitude of the mixed difference in the directions of `set`, for each component: the texels of the
/// corners that differ from each other only in these directions, with alternating signs.
fn largest_mixed_difference(corners: &[Texel], set: usize) -> [f64; 4] {
    let mut largest = [0.0_f64; 4];
    for base in (0..corners.len()).filter(|corner| corner & set == 0) {
        let mut difference = [0.0; 4];
        for corner in (0..corners.len()).filter(|corner| corner & !set == base) {
            let sign = if (corner & set).count_ones().is_multiple_of(2) {
                1.0
            } else {
                -1.0
            };
            for (sum, value) in difference.iter_mut().zip(corners[corner].values()) {
                *sum += sign * value;
            }
        }
        for (largest, difference) in largest.iter_mut().zip(difference) {
            *largest = largest.max(difference.abs());
        }
    }
    largest
}
