//! Sampling hints: the depth in the levels at which a pixel samples, and minification or magnification.
//!
//! A bias of −1 moves one level toward the base, 2 two levels away from it (R-HNT-02, R-HNT-03). Frequency hints below 1 reduce
//! blur in their direction (R-HNT-06). A pixel over more than one texel is minified, over less than one magnified (R-SMP-02,
//! R-SMP-03).
//!
//! Format notes
//! - The suggested formulas are lost, and others are allowed anyway (R-HNT-01): no verdict depends on this module
//!   (ruling `depth-formula`).
//! - A pixel over exactly one texel is magnified; if directions disagree, the larger one decides (ruling `one-texel`).

use super::entry::Vector;

/// The difference of texture coordinates from a pixel to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// To the pixel on the right.
    pub dt_dx: Vector,
    /// To the pixel above.
    pub dt_dy: Vector,
}

/// Returns the depth at which a map of base size `size` (one number for each dimension) is sampled: the base-2 logarithm of the
/// widest span, weighted by its hint (ruling `depth-formula`), and a bias in levels (R-HNT-02, R-HNT-03).
#[must_use]
pub fn sample_depth(size: &[usize], footprint: &Footprint, bias: f64, frequency: [f64; 3]) -> f64 {
    let spans = spans(size, footprint).into_iter().zip(frequency);
    let weighted = spans.map(|(span, hint)| span * hint);
    weighted.fold(0.0, f64::max).log2() + bias
}

/// Returns true if a pixel covers a texel or less of a map of base size `size` (ruling `one-texel`).
#[must_use]
pub fn magnifies(size: &[usize], footprint: &Footprint) -> bool {
    spans(size, footprint).iter().all(|&span| span <= 1.0)
}

/// Returns the number of texels of the base level that a pixel spans, in each direction of the map.
fn spans(size: &[usize], footprint: &Footprint) -> Vec<f64> {
    let span =
        |(c, &side): (usize, &usize)| side as f64 * footprint.dt_dx[c].hypot(footprint.dt_dy[c]);
    size.iter().enumerate().take(3).map(span).collect()
}
