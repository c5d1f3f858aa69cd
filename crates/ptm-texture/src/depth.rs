//! Sampling hints: the mipmap depth at which a pixel is sampled, and the choice between minification and magnification.
//!
//! A bias of −1 moves one level toward the base, and a bias of 2 moves two levels away from it (R-HNT-02, R-HNT-03).
//! Frequency hints below 1 reduce blur in their direction (R-HNT-06). The map is minified if a pixel covers more than one
//! texel, and magnified if it covers less than one (R-SMP-02, R-SMP-03).
//!
//! Format notes
//! - The chapter's suggested formulas are lost, and other formulas are allowed (R-HNT-01), so no verdict depends on this module
//!   (ruling `depth-formula`).
//! - The map is magnified if a pixel covers exactly one texel. If directions disagree, the largest span decides (ruling
//!   `one-texel`). The bias changes the depth, but not the choice between minification and magnification (ruling
//!   `bias-and-mode`).

use super::entry::Vector;
use super::rules::Rules;

/// Changes in texture coordinates from a pixel to its neighbors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Change from a pixel to the one on its right.
    pub dt_dx: Vector,
    /// Change from a pixel to the one above it.
    pub dt_dy: Vector,
}

/// Returns the depth at which a map is sampled: the base-2 logarithm of the largest span after each span is multiplied by its
/// frequency hint (ruling `depth-formula`), plus a bias in levels (R-HNT-02, R-HNT-03). `size` is the size of the base level,
/// with one number per dimension.
#[must_use]
pub fn sample_depth(size: &[usize], footprint: &Footprint, bias: f64, frequency: [f64; 3]) -> f64 {
    let spans = spans(size, footprint).into_iter().zip(frequency);
    let weighted = spans.map(|(span, hint)| span * hint);
    weighted.fold(0.0, f64::max).log2() + bias
}

/// Returns true if the magnification method applies to a pixel. `size` is the size of the base level.
#[must_use]
pub fn is_magnified(size: &[usize], footprint: &Footprint, bias: f64, rules: &Rules) -> bool {
    (rules.is_magnified)(&spans(size, footprint), bias)
}

/// Returns true if a pixel spans at most one texel in each direction (ruling `one-texel`), whatever the bias is (ruling
/// `bias-and-mode`).
#[must_use]
pub fn span_at_most_one_texel(spans: &[f64], _bias: f64) -> bool {
    spans.iter().all(|&span| span <= 1.0)
}

/// Returns true if a pixel spans at most one texel of the level that is `bias` levels above the base (alternative to ruling
/// `bias-and-mode`).
#[must_use]
pub fn biased_depth_at_most_zero(spans: &[f64], bias: f64) -> bool {
    spans.iter().all(|&span| span * bias.exp2() <= 1.0)
}

/// Returns the number of base-level texels that a pixel spans in each direction of the map.
fn spans(size: &[usize], footprint: &Footprint) -> Vec<f64> {
    let span =
        |(c, &side): (usize, &usize)| side as f64 * footprint.dt_dx[c].hypot(footprint.dt_dy[c]);
    size.iter().enumerate().take(3).map(span).collect()
}
