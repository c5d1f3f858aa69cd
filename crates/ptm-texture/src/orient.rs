//! Orientation, interpolation and perspective correction: from the coordinates of vertices to those of samples.
//!
//! The coordinates of every method are transformed by the orientation matrix (R-ORI-01) and then interpolated across the
//! facet (R-ORI-03). In a perspective view, the interpolated coordinates are corrected before sampling (R-ORI-04).
//!
//! Format notes
//! - t' = O·(t0, t1, t2, 1), where O is stored in row-major order. The result is divided by w if w is neither 0 nor 1
//!   (ruling `orientation-w`).
//! - The specification of the correction method Vertex is too vague to implement (ruling `vertex-correction`).

use super::entry::{Matrix, Vector};
use super::no_value::NoValue;
use super::primitive::{Correction, Frequency, Interpolation, Site};
use super::rules::Rules;

/// Transforms coordinates by the orientation matrix.
#[must_use]
pub fn orient(matrix: &Matrix, t: Vector, rules: &Rules) -> Vector {
    (rules.orient)(matrix, t)
}

/// Computes O·(t, 1), divided by w (R-ORI-01, rulings `matrix-storage`, `orientation-w`).
pub fn rows_times_column(matrix: &Matrix, t: Vector) -> Vector {
    let row =
        |r: usize| matrix[r][0] * t[0] + matrix[r][1] * t[1] + matrix[r][2] * t[2] + matrix[r][3];
    let w = match row(3) {
        0.0 => 1.0,
        w => w,
    };
    [row(0) / w, row(1) / w, row(2) / w]
}

/// Interpolates coordinates inside a facet. For each corner, `ts` contains the coordinates, `b` the screen-space weight, and `w`
/// the homogeneous coordinate.
///
/// # Errors
/// Returns [`NoValue::ImplementationDefined`] for the correction method Vertex.
pub fn interpolate(
    ts: &[Vector],
    b: &[f64],
    w: &[f64],
    correction: Correction,
    rules: &Rules,
) -> Result<Vector, NoValue> {
    match correction {
        Correction::None => Ok((rules.linear)(ts, b, w)),
        Correction::Pixel => Ok((rules.hyperbolic)(ts, b, w)),
        Correction::Vertex => Err(NoValue::ImplementationDefined("vertex-correction")),
    }
}

pub fn interpolate_linearly(ts: &[Vector], b: &[f64], _w: &[f64]) -> Vector {
    [0, 1, 2].map(|c| ts.iter().zip(b).map(|(t, b)| b * t[c]).sum())
}

/// Interpolates with perspective correction: t is the quotient of t/w and 1/w, which are linear on the screen (R-ORI-04).
pub fn interpolate_in_perspective(ts: &[Vector], b: &[f64], w: &[f64]) -> Vector {
    let weights: Vec<f64> = b.iter().zip(w).map(|(b, w)| b / w).collect();
    let sum: f64 = weights.iter().sum();
    interpolate_linearly(ts, &weights, w).map(|t| t / sum)
}

/// Returns the sampling site of a texture: facet, vertex or pixel (R-CMP-22).
#[must_use]
pub fn site(interpolation: Interpolation, frequency: Frequency, rules: &Rules) -> Site {
    (rules.site)(interpolation, frequency)
}

/// Returns the sampling site: every pixel for Pixel, or the site of the reflectance calculation for `InterpDep` (R-CMP-22).
#[expect(
    clippy::match_same_arms,
    reason = "one line per row of the table is easier to read"
)]
pub fn sampling_site(interpolation: Interpolation, frequency: Frequency) -> Site {
    match (frequency, interpolation) {
        (Frequency::Pixel, _) => Site::Pixel,
        (_, Interpolation::None) => Site::Facet,
        (_, Interpolation::Color) => Site::Vertex,
        (_, Interpolation::DotProduct | Interpolation::Normal) => Site::Pixel,
    }
}
