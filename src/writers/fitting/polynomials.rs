//! The appearance of a map under lights: three polynomials per texel, for all formats.

use crate::evaluate::{clamp, modulate, polynomial};
use crate::ptm::{Ptm, Shape};
use crate::writers::fitting::pictures::{Photograph, PictureSet};

/// The final coefficients of red, green and blue of each texel, top row first; for LRGB those of luminance times color.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomials(pub Vec<[[f64; 6]; 3]>);

impl Polynomials {
    /// Returns the polynomials of a map; None for LUM, which no fitter is asked for.
    #[must_use]
    pub fn new(ptm: &Ptm) -> Option<Polynomials> {
        Polynomials::with_values(ptm, [0, 1, 2, 3, 4, 5], |raw, scale, bias| {
            (raw - bias) * scale
        })
    }

    /// Returns those of a map with coefficient `i` at place `order[i]`: `value` of raw value, scale and bias.
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
            _ => colored(&six(&raw[..6]), [raw[6], raw[7], raw[8]]),
        };
        let is_lum = matches!(ptm.planes.shape, Shape::Lum(_));
        (!is_lum).then(|| Polynomials(ptm.planes.texels().map(texel).collect()))
    }

    /// Returns the image under a light, 0 to 255, not rounded.
    pub(super) fn shown(&self, [u, v]: [f64; 2]) -> impl Iterator<Item = f64> {
        let values = self.0.iter().flatten();
        values.map(move |a| clamp(polynomial(a, u, v)))
    }

    /// Returns the root mean square error of the map for each photograph.
    #[must_use]
    pub fn errors(&self, set: &PictureSet) -> Vec<f64> {
        let error = |of: &Photograph| {
            let pixels = of.pixels.iter().map(|&value| f64::from(value));
            root_mean_square(self.shown(of.direction()).zip(pixels).map(|(a, b)| a - b))
        };
        set.photographs.iter().map(error).collect()
    }

    /// Returns the distance of two maps under the lights of a set.
    pub(super) fn distance(&self, other: &Polynomials, set: &PictureSet) -> f64 {
        let lights = set.photographs.iter().map(Photograph::direction);
        root_mean_square(lights.flat_map(|light| {
            let pairs = self.shown(light).zip(other.shown(light));
            pairs.map(|(a, b)| a - b)
        }))
    }
}

/// Computes luminance times color (clause 2.7.3/4).
pub(super) fn colored(luminance: &[f64; 6], color: [u8; 3]) -> [[f64; 6]; 3] {
    color.map(|color| luminance.map(|a| modulate(a, f64::from(color))))
}

/// Returns the root mean square; 0 for no values.
pub(super) fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_u32);
    for value in values {
        sum += value * value;
        count += 1;
    }
    (sum / f64::from(count.max(1))).sqrt()
}
