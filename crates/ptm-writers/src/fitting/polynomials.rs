//! Uniform representation of maps for evaluation: three polynomials per texel.

use crate::fitting::photographs::{ImageSet, Photograph};
use ptm::evaluate::{clamp, modulate, polynomial};
use ptm::{Ptm, Shape};

/// Final coefficients of red, green and blue for each texel, top row first. For LRGB, each polynomial is the luminance polynomial
/// multiplied by the color.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomials(pub Vec<[[f64; 6]; 3]>);

impl Polynomials {
    /// Returns the polynomials of a map, or `None` for LUM, which is never requested from fitters.
    #[must_use]
    pub fn new(ptm: &Ptm) -> Option<Polynomials> {
        let value = |raw, scale, bias| (raw - bias) * scale;
        Polynomials::with_values(ptm, [0, 1, 2, 3, 4, 5], value)
    }

    /// Returns the polynomials of a map whose coefficient `i` is stored at index `order[i]` and computed by `value` from the raw
    /// value, the scale and the bias.
    pub(super) fn with_values(
        ptm: &Ptm,
        order: [usize; 6],
        value: fn(f64, f64, f64) -> f64,
    ) -> Option<Polynomials> {
        let set = &ptm.header.scale_bias;
        let six = |raw: &[u8]| -> [f64; 6] {
            order.map(|i| value(f64::from(raw[i]), set.scale[i], set.bias[i]))
        };
        let texel = |raw: &[u8]| match ptm.planes.shape {
            Shape::Rgb => [six(&raw[..6]), six(&raw[6..12]), six(&raw[12..])],
            _ => multiply_by_color(&six(&raw[..6]), [raw[6], raw[7], raw[8]]),
        };
        let is_lum = matches!(ptm.planes.shape, Shape::Lum(_));
        (!is_lum).then(|| Polynomials(ptm.planes.texels().map(texel).collect()))
    }

    /// Evaluates the polynomials under a light. The values are clamped to 0…255 but not rounded.
    pub(super) fn evaluate(&self, [u, v]: [f64; 2]) -> impl Iterator<Item = f64> {
        let values = self.0.iter().flatten();
        values.map(move |a| clamp(polynomial(a, u, v)))
    }

    /// Returns the root-mean-square error for each photograph.
    #[must_use]
    pub fn errors(&self, set: &ImageSet) -> Vec<f64> {
        let error = |photo: &Photograph| {
            let pairs = self.evaluate(photo.direction()).zip(&photo.pixels);
            root_mean_square(pairs.map(|(a, &pixel)| a - f64::from(pixel)))
        };
        set.photographs.iter().map(error).collect()
    }

    /// Returns the root-mean-square difference between two maps under the lights of a set.
    pub(super) fn distance(&self, other: &Polynomials, set: &ImageSet) -> f64 {
        let lights = set.photographs.iter().map(Photograph::direction);
        root_mean_square(lights.flat_map(|light| {
            let pairs = self.evaluate(light).zip(other.evaluate(light));
            pairs.map(|(a, b)| a - b)
        }))
    }
}

/// Multiplies a luminance polynomial by a color (clause 2.7.3/4).
pub(super) fn multiply_by_color(luminance: &[f64; 6], color: [u8; 3]) -> [[f64; 6]; 3] {
    color.map(|color| luminance.map(|a| modulate(a, f64::from(color))))
}

/// Returns the root mean square, or 0 if there are no values.
pub(super) fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_u32);
    for value in values {
        sum += value * value;
        count += 1;
    }
    (sum / f64::from(count.max(1))).sqrt()
}
