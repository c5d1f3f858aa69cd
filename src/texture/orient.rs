//! Orientation, interpolation and perspective correction: coordinates between vertex and sample.
//!
//! Coordinates of every method are transformed by the orientation matrix (R-ORI-01), and then interpolated across the facet
//! (R-ORI-03). In a perspective view interpolated coordinates are corrected before sampling (R-ORI-04).
//!
//! Format notes
//! - t' = O·(t0, t1, t2, 1), with O stored row-major; divided by its w if that is neither 0 nor 1 (ruling
//!   `orientation-w`).
//! - Correction Vertex is too vague to be computed (ruling `vertex-correction`).

use super::entry::{Matrix, Vector};
use super::no_value::NoValue;
use super::primitive::{Correction, Frequency, Interpolation, Site};
use super::rules::Rules;

/// Returns coordinates after the orientation matrix.
#[must_use]
pub fn orient(matrix: &Matrix, t: Vector, rules: &Rules) -> Vector {
    (rules.orient)(matrix, t)
}

/// Computes O·(t, 1), divided by w (R-ORI-01, rulings `matrix-storage`, `orientation-w`).
pub(crate) fn rows_times_column(matrix: &Matrix, t: Vector) -> Vector {
    let row =
        |r: usize| matrix[r][0] * t[0] + matrix[r][1] * t[1] + matrix[r][2] * t[2] + matrix[r][3];
    let w = match row(3) {
        0.0 => 1.0,
        w => w,
    };
    [row(0) / w, row(1) / w, row(2) / w]
}

/// Interpolates inside a facet: coordinates `ts` at its corners, weights `b` of the corners on the screen, and their `w`.
///
/// # Errors
/// [`NoValue::ImplementationDefined`] under correction Vertex.
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

/// Returns the weighted sum of the corners.
pub(crate) fn linear(ts: &[Vector], b: &[f64], _w: &[f64]) -> Vector {
    [0, 1, 2].map(|c| ts.iter().zip(b).map(|(t, b)| b * t[c]).sum())
}

/// Returns t, the quotient of t/w and 1/w, which are linear on the screen (R-ORI-04).
pub(crate) fn hyperbolic(ts: &[Vector], b: &[f64], w: &[f64]) -> Vector {
    let shares: Vec<f64> = b.iter().zip(w).map(|(b, w)| b / w).collect();
    let whole: f64 = shares.iter().sum();
    linear(ts, &shares, w).map(|t| t / whole)
}

/// Returns the places where a texture is sampled (R-CMP-22).
#[must_use]
pub fn site(interpolation: Interpolation, frequency: Frequency, rules: &Rules) -> Site {
    (rules.site)(interpolation, frequency)
}

/// Samples pixels with frequency Pixel; `InterpDep` follows the reflectance calculation (R-CMP-22).
#[expect(
    clippy::match_same_arms,
    reason = "a table reads better with a line for each of its rows"
)]
pub(crate) fn as_often_as_lit(interpolation: Interpolation, frequency: Frequency) -> Site {
    match (frequency, interpolation) {
        (Frequency::Pixel, _) => Site::Pixel,
        (_, Interpolation::None) => Site::Facet,
        (_, Interpolation::Color) => Site::Vertex,
        (_, Interpolation::DotProduct | Interpolation::Normal) => Site::Pixel,
    }
}
