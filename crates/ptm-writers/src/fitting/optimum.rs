//! Least-squares optimum for a set of photographs, quantized to a format.
//!
//! Format notes
//! - RGB uses three fits per texel. LRGB uses the best product of a luminance and a color: the fitted values of all
//!   channels, one row per light, are projected onto the color direction with the largest sum of squares.
//! - Each scale and bias applies to the whole map and is chosen for the range of one coefficient over all texels.

use crate::fitting::algebra::{LeastSquares, eigensystem};
use crate::fitting::photographs::{ImageSet, Photograph};
use crate::fitting::polynomials::{Polynomials, multiply_by_color};
use crate::request::new_map;
use ptm::evaluate::polynomial;
use ptm::{Format, Ptm, ScaleBias};

/// Best polynomials before quantization to bytes.
#[derive(Clone, Debug)]
pub(super) struct FittedMap {
    /// Polynomials with six coefficients: three per texel for RGB, one per texel for LRGB.
    polynomials: Vec<[f64; 6]>,
    /// Color of each texel for LRGB; empty for RGB.
    colors: Vec<[u8; 3]>,
}

/// Returns the best RGB or LRGB map for `set`.
#[must_use]
pub fn optimum(set: &ImageSet, format: Format) -> Ptm {
    FittedMap::new(set, &directions(set), format).quantize(set, format)
}

/// Returns true if the lights of `set` determine all six coefficients, with a margin for rounding errors.
pub(super) fn is_determined(set: &ImageSet) -> bool {
    LeastSquares::new(&directions(set), set.rank_tolerance()).is_determined
}

pub(super) fn directions(set: &ImageSet) -> Vec<[f64; 2]> {
    set.photographs.iter().map(Photograph::direction).collect()
}

/// Minimum range of a coefficient that is not constant, in gray levels. A smaller range is not visible.
const MIN_RANGE: f64 = 0.01;

impl FittedMap {
    /// Fits the photographs under `lights`, which may differ from the lights of the set.
    pub fn new(set: &ImageSet, lights: &[[f64; 2]], format: Format) -> FittedMap {
        let least_squares = LeastSquares::new(lights, set.rank_tolerance());
        let mut fitted = FittedMap {
            polynomials: Vec::new(),
            colors: Vec::new(),
        };
        for texel in 0..set.size.texels() {
            let channels = [0, 1, 2].map(|channel| {
                let values = set.photographs.iter();
                least_squares.fit(values.map(|p| f64::from(p.pixels[3 * texel + channel])))
            });
            if format == Format::Rgb {
                fitted.polynomials.extend(channels);
                continue;
            }
            let (luminance, color) = factor_color(&channels, lights);
            fitted.polynomials.push(luminance);
            fitted.colors.push(color);
        }
        fitted
    }

    /// Returns three polynomials per texel.
    pub fn polynomials(&self) -> Polynomials {
        if self.colors.is_empty() {
            return Polynomials(self.polynomials.as_chunks::<3>().0.to_vec());
        }
        let texels = self.polynomials.iter().zip(&self.colors);
        let texels = texels.map(|(a, &color)| multiply_by_color(a, color));
        Polynomials(texels.collect())
    }

    /// Chooses the scale and bias of each coefficient to fit its range.
    pub fn scale_bias(&self) -> ScaleBias {
        let mut set = ScaleBias {
            scale: [0.0; 6],
            bias: [0.0; 6],
        };
        for i in 0..6 {
            let values = self.polynomials.iter().map(|a| a[i]);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            let high = values.fold(f64::NEG_INFINITY, f64::max);
            let (scale, bias) = scale_and_bias(low, high);
            (set.scale[i], set.bias[i]) = (scale, bias);
        }
        set
    }

    /// Quantizes the map to bytes.
    pub fn quantize(&self, set: &ImageSet, format: Format) -> Ptm {
        let scale_bias = self.scale_bias();
        let raw = |a: &[f64; 6]| -> [u8; 6] {
            std::array::from_fn(|i| (a[i] / scale_bias.scale[i] + scale_bias.bias[i]).round() as u8)
        };
        let mut samples = Vec::new();
        for (texel, coefficients) in self.polynomials.iter().enumerate() {
            samples.extend(raw(coefficients));
            samples.extend(self.colors.get(texel).into_iter().flatten());
        }
        new_map(format, set.size, scale_bias, None, samples)
    }
}

/// Chooses the scale and bias of a coefficient with this range. Scales have seven digits.
fn scale_and_bias(low: f64, high: f64) -> (f64, f64) {
    let as_written = |scale: f64| format!("{scale:.6e}").parse::<f64>().expect("a number");
    let middle = f64::midpoint(low, high);
    if high - low < MIN_RANGE {
        // The constant is stored as 255 if it is positive, or as 0.
        return match as_written(middle.abs() / 255.0) {
            scale if middle.abs() < MIN_RANGE || scale == 0.0 => (1.0, 0.0),
            scale if middle > 0.0 => (scale, 0.0),
            scale => (scale, 255.0),
        };
    }
    // The bias is an integer, so reserve a step for rounding, and keep the bias small.
    let scale = as_written(((high - low) / 254.0).max(low.abs() / 1e4));
    (scale, (-low / scale).round())
}

/// Approximates three polynomials as the product of a luminance polynomial and a color. The color is chosen to be optimal under
/// `lights`.
fn factor_color(channels: &[[f64; 6]; 3], lights: &[[f64; 2]]) -> ([f64; 6], [u8; 3]) {
    let value = |channel: usize, [u, v]: [f64; 2]| polynomial(&channels[channel], u, v);
    let product = |i: usize, j: usize| -> f64 {
        let lights = lights.iter().copied();
        lights.map(|light| value(i, light) * value(j, light)).sum()
    };
    let (values, vectors) = eigensystem([0, 1, 2].map(|i| [0, 1, 2].map(|j| product(i, j))));
    let best = (0..3).max_by(|&i, &j| values[i].total_cmp(&values[j]));
    let best = best.expect("there are three eigenvalues");
    let sign = (0..3).map(|i| vectors[i][best]).sum::<f64>().signum();
    let color = [0, 1, 2].map(|i| (vectors[i][best] * sign).max(0.0));
    let largest = color.into_iter().fold(0.0, f64::max);
    // The color of a black texel is arbitrary.
    if values[best] <= 0.0 || largest == 0.0 {
        return ([0.0; 6], [255; 3]);
    }
    let color = color.map(|c| (c / largest * 255.0).round());
    let square: f64 = color.iter().map(|c| c * c).sum();
    let luminance = std::array::from_fn(|k| {
        let projection: f64 = (0..3).map(|i| channels[i][k] * color[i]).sum();
        projection / square * 255.0
    });
    (luminance, color.map(|c| c as u8))
}
