//! Evaluates a map: planes → final coefficients (2.4) → color under a light (1.0).
//!
//! Format notes
//! - A final coefficient is a real number. Nothing is rounded before the end (ruling `final-coefficient`).
//! - All polynomials share one set of scales and biases. Colors, Cr and Cb are used unscaled.
//! - Luminance times color is divided by 255 and then clamped (ruling `color`).

#![allow(
    clippy::must_use_candidate,
    reason = "the decoder calls the functions of decisions"
)]

use crate::reading::Reading;
use crate::types::{ColorMatrix, Planes, ScaleBias, Shape, Size};

/// Final values of a map: coefficients after scale and bias, and the other channels unchanged.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Width and height.
    pub size: Size,
    /// Shape of each texel.
    pub shape: Shape,
    /// `height * width * channels` values, in the order of [`Planes::samples`].
    pub values: Vec<f64>,
}

/// Image of a map under one light.
#[derive(Clone, Debug, PartialEq)]
pub struct RelitImage {
    /// Width and height.
    pub size: Size,
    /// `height * width * 3` unrounded values from 0 to 255: red, green and blue of every texel, top row first.
    pub values: Vec<f64>,
}

impl RelitImage {
    /// Rounds the values to the nearest integers. The text does not specify rounding, so no verdict depends on it.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        self.values
            .iter()
            .map(|&value| value.round() as u8)
            .collect()
    }
}

/// Computes the final coefficients of a map (clause 2.4/8).
#[must_use]
pub fn compute_coefficients(
    scale_bias: &ScaleBias,
    planes: &Planes,
    reading: &Reading,
) -> Coefficients {
    Coefficients {
        size: planes.size,
        shape: planes.shape,
        values: (reading.finals)(scale_bias, planes, reading),
    }
}

/// Computes the image under a light from the final coefficients.
#[must_use]
pub fn evaluate(coefficients: &Coefficients, lu: f64, lv: f64, reading: &Reading) -> RelitImage {
    let light = (reading.light)(lu, lv);
    let shape = &coefficients.shape;
    let color = |texel: &[f64]| (reading.texel_color)(shape, texel, light, reading);
    let texels = coefficients.values.chunks_exact(shape.channels());
    let values = texels.flat_map(color).map(reading.clamp).collect();
    RelitImage {
        size: coefficients.size,
        values,
    }
}

/// Computes the color of a texel from its final values (clauses 1.0/1, 2.6/4 and 2.7.3/4). The color is not clamped.
pub fn texel_color(
    shape: &Shape,
    texel: &[f64],
    (lu, lv): (f64, f64),
    reading: &Reading,
) -> [f64; 3] {
    let polynomial = |a: &[f64]| (reading.polynomial)(a, lu, lv);
    match shape {
        Shape::Rgb => [&texel[..6], &texel[6..12], &texel[12..]].map(polynomial),
        Shape::Lrgb => {
            let luminance = (reading.luminance)(polynomial(&texel[..6]));
            [texel[6], texel[7], texel[8]].map(|color| (reading.modulate)(luminance, color))
        }
        Shape::Lum(matrix) => {
            lum_color(matrix, polynomial(&texel[..6]), texel[6], texel[7], reading)
        }
    }
}

/// Multiplies the matrix `m` by (Y, Cr, Cb, 1) (clauses 2.6/4–5).
#[must_use]
pub fn lum_color(m: &ColorMatrix, y: f64, cr: f64, cb: f64, reading: &Reading) -> [f64; 3] {
    let [cr, cb] = [cr, cb].map(reading.lum_chroma);
    let [y, cr, cb] = (reading.lum_values)((reading.lum_luminance)(y), cr, cb);
    let v = (reading.lum_vector)(y, cr, cb);
    (reading.lum_matrix)(m)
        .map(|[m0, m1, m2, t]| m0 * v[0] + m1 * v[1] + m2 * v[2] + (reading.lum_translation)(t))
}

/// Returns the light unchanged: +u is right, +v is up (clause 1.0/2, ruling `light`).
pub fn light(lu: f64, lv: f64) -> (f64, f64) {
    (lu, lv)
}

/// Evaluates the polynomial of §1.0 (clause 1.0/1).
pub fn polynomial(a: &[f64], lu: f64, lv: f64) -> f64 {
    a[0] * lu * lu + a[1] * lv * lv + a[2] * lu * lv + a[3] * lu + a[4] * lv + a[5]
}

/// Computes (raw − bias) · scale (clause 2.4/8). All polynomials share the same six scales and biases (clause 2.4/9).
pub fn final_coefficient(raw: u8, channel: usize, set: &ScaleBias) -> f64 {
    (f64::from(raw) - set.bias[channel % 6]) * set.scale[channel % 6]
}

/// Applies scale and bias to the coefficients. Colors, Cr and Cb remain unchanged (clause 2.4/9).
pub fn final_values(set: &ScaleBias, planes: &Planes, reading: &Reading) -> Vec<f64> {
    let coefficients = planes.shape.coefficients();
    let mut values = Vec::with_capacity(planes.samples.len());
    for texel in planes.texels() {
        for (channel, &raw) in texel.iter().enumerate() {
            values.push(if channel < coefficients {
                (reading.final_coefficient)(raw, channel, set)
            } else {
                f64::from(raw)
            });
        }
    }
    values
}

/// Returns Cr or Cb as stored (ruling `lum-chroma`).
pub fn lum_chroma(stored: f64) -> f64 {
    stored
}

/// Returns Cr or Cb relative to 128 (alternative to ruling `lum-chroma`). In the range from 0 to 1, the middle is 128/255.
pub fn centered_lum_chroma(stored: f64) -> f64 {
    stored - 128.0
}

/// Returns the values that the vector consists of, unchanged: Y, Cr and Cb (clause 2.6/4).
pub fn lum_values(y: f64, cr: f64, cb: f64) -> [f64; 3] {
    [y, cr, cb]
}

/// Returns the vector Y, Cr, Cb (ruling `lum-vector`).
pub fn lum_vector(y: f64, cr: f64, cb: f64) -> [f64; 3] {
    [y, cr, cb]
}

/// Returns the vector Cr, Y, Cb (alternative to ruling `lum-vector`).
pub fn lum_vector_cr_first(y: f64, cr: f64, cb: f64) -> [f64; 3] {
    [cr, y, cb]
}

/// Returns the translation unchanged: like the values, it ranges from 0 to 255 (ruling `lum-range`).
pub fn lum_translation(t: f64) -> f64 {
    t
}

/// Scales a translation from 0 … 1 to 0 … 255 (alternative to ruling `lum-range`).
pub fn scaled_lum_translation(t: f64) -> f64 {
    t * 255.0
}

/// Returns the luminance unchanged (rulings `luminance-clamp` and `lum-clamp`).
pub fn luminance(value: f64) -> f64 {
    value
}

/// Limits luminance to 255 (alternative to rulings `luminance-clamp` and `lum-clamp`). In LRGB and tables, a negative luminance
/// gives the color 0 in any case.
pub fn clamped_luminance(value: f64) -> f64 {
    value.min(255.0)
}

/// Limits Y to 0…255 (alternative to ruling `lum-clamp`). The matrix may multiply it by a negative number.
pub fn clamped_lum_luminance(value: f64) -> f64 {
    value.clamp(0.0, 255.0)
}

/// Computes luminance times color, divided by 255 (clause 2.7.3/4, ruling `color`).
pub fn modulate(luminance: f64, color: f64) -> f64 {
    luminance * color / 255.0
}

/// Clamps a final color to 0 … 255 (clause 2.7.3/5, ruling `color`).
pub fn clamp(value: f64) -> f64 {
    value.clamp(0.0, 255.0)
}
