//! Detects mistakes of fitters by reproducing them.
//!
//! - A mistake in the use of photographs or lights leads to a different optimum. A map near that optimum reveals the mistake.
//! - A mistake in the file format results in a map that is right if its numbers are interpreted differently.
//! - If a map differs from the optimum only by quantization, its quantization steps are too wide or its range is too small.

use std::sync::LazyLock;

use serde::Deserialize;

use crate::fitting::optimum::{FittedMap, directions};
use crate::fitting::photographs::{ImageSet, Photograph};
use crate::fitting::polynomials::{Polynomials, root_mean_square};
use crate::fitting::{judge::max_error, optimum::is_determined};
use crate::judge::compare_map;
use ptm::decode::decode;
use ptm::{Format, Ptm, Shape};
use ptm_suite::kit::yaml::from_yaml;

/// Mistake of a fitter, as defined in `spec-cases/writers/fitting-mistakes.yaml`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FitMistake {
    slug: String,
    /// Clause that the mistake violates.
    pub clause: String,
    /// Effect of the mistake, as a sentence without a subject.
    pub effect: String,
    /// Suggested fix.
    pub fix: String,
}

/// All known mistakes. If several explain the same number of failures, the first is reported.
pub(super) static MISTAKES: LazyLock<Vec<FitMistake>> = LazyLock::new(|| {
    let yaml = ptm_spec_cases::writers::FITTING_MISTAKES;
    from_yaml(yaml).expect("a list of mistakes")
});

enum Criterion {
    /// The map is near the best fit to the photographs that result from this change.
    Photographs(fn(&mut ImageSet)),
    /// The map is near the best fit under lights with these directions.
    Lights(fn(&Photograph) -> [f64; 2]),
    /// The map is right if its coefficients are read in this order and computed with this function of the raw value, the scale
    /// and the bias.
    Numbers([usize; 6], fn(f64, f64, f64) -> f64),
    /// The map is right if each texel has all its values in one place.
    Texels,
    /// The map is near the best fit, darkened in each texel by the brightness of the stored color.
    DarkenedByColor,
    /// The map satisfies this predicate.
    Map(fn(&WrongMap) -> bool),
}

/// Wrong map and the best map for the same photographs.
pub(super) struct WrongMap {
    set: ImageSet,
    format: Format,
    ptm: Ptm,
    found: Polynomials,
    best: FittedMap,
}

impl WrongMap {
    /// Decodes a wrong file. Returns `None` if it is not a map of these photographs.
    pub fn new(set: ImageSet, format: Format, file: &[u8]) -> Option<WrongMap> {
        let ptm = decode(file).ok()?;
        compare_map(format, set.size, &ptm).ok()?;
        Some(WrongMap {
            format,
            found: Polynomials::new(&ptm)?,
            best: FittedMap::new(&set, &directions(&set), format),
            set,
            ptm,
        })
    }

    /// Returns `Some(true)` if a fitter with this mistake would produce this map, and `Some(false)` if it would produce another wrong
    /// map.
    pub fn verdict(&self, mistake: &FitMistake) -> Option<bool> {
        let matches = match mistake.criterion() {
            Criterion::Photographs(change) => {
                let mut changed = self.set.clone();
                change(&mut changed);
                let lights = directions(&changed);
                return self.compare(&FittedMap::new(&changed, &lights, self.format).polynomials());
            }
            Criterion::Lights(light) => {
                let lights: Vec<_> = self.set.photographs.iter().map(light).collect();
                return self
                    .compare(&FittedMap::new(&self.set, &lights, self.format).polynomials());
            }
            Criterion::Numbers(order, value) => self.is_right(&self.ptm, order, value),
            Criterion::Texels => {
                let mut ptm = self.ptm.clone();
                ptm.planes.samples = self.samples_without_blocks();
                self.is_right(&ptm, CLAUSE_ORDER, |raw, scale, bias| (raw - bias) * scale)
            }
            Criterion::DarkenedByColor => {
                if self.format != Format::Lrgb {
                    return None;
                }
                let verdicts =
                    LUMINANCE_WEIGHTS.map(|weights| self.compare(&self.darkened(weights)));
                return match verdicts.contains(&Some(true)) {
                    true => Some(true),
                    false => verdicts.iter().all(Option::is_some).then_some(false),
                };
            }
            Criterion::Map(predicate) => predicate(self),
        };
        matches.then_some(true)
    }

    /// Returns `Some(true)` if the map is near `other`, relative to the distance between the map and the optimum, and `Some(false)`
    /// if it is not, although `other` is far from the optimum.
    fn compare(&self, other: &Polynomials) -> Option<bool> {
        let best = self.best.polynomials();
        let from_best = self.found.distance(&best, &self.set);
        match self.found.distance(other, &self.set) < 1.0 + 0.1 * from_best {
            true => Some(true),
            false => (other.distance(&best, &self.set) > 2.0).then_some(false),
        }
    }

    /// Returns the best map, multiplied in each texel by the luminance of the stored color.
    fn darkened(&self, weights: [f64; 3]) -> Polynomials {
        let texels = self.ptm.planes.texels().zip(self.best.polynomials().0);
        let texels = texels.map(|(stored, best)| {
            let weighted = weights.iter().zip(&stored[6..9]);
            let luminance: f64 = weighted.map(|(w, &c)| w * f64::from(c)).sum();
            best.map(|polynomial| polynomial.map(|a| a * luminance / 255.0))
        });
        Polynomials(texels.collect())
    }

    /// Returns the samples, top row first, of a reader that takes the bytes of the blocks as texels with all their values.
    fn samples_without_blocks(&self) -> Vec<u8> {
        let channels = self.ptm.planes.shape.channels();
        let row = channels * self.set.size.width as usize;
        let flip =
            |samples: &[u8]| -> Vec<u8> { samples.rchunks_exact(row).flatten().copied().collect() };
        let stored = flip(&self.ptm.planes.samples);
        let mut bytes = Vec::with_capacity(stored.len());
        for first in (0..channels).step_by(6) {
            let block = first..(first + 6).min(channels);
            let texels = stored.chunks_exact(channels);
            bytes.extend(texels.flat_map(|texel| &texel[block.clone()]));
        }
        flip(&bytes)
    }

    /// Returns true if the map fits when it is read as `ptm` and its coefficients are read in the given order and computed with
    /// `value`, which changes the map.
    fn is_right(&self, ptm: &Ptm, order: [usize; 6], value: fn(f64, f64, f64) -> f64) -> bool {
        let best = self.best.polynomials().errors(&self.set);
        Polynomials::with_values(ptm, order, value).is_some_and(|found| {
            // The tolerance is larger because integer offsets cause larger rounding errors than biases.
            let mut pairs = found.errors(&self.set).into_iter().zip(best);
            pairs.all(|(found, best)| found <= max_error(best) + 2.0)
                && found.distance(&self.found, &self.set) > 1.0
        })
    }

    /// Returns the raw value and the expected raw value of coefficient `i` of each texel, given the scale and bias of the file.
    fn raw_and_expected_values(&self, i: usize) -> Vec<(f64, f64)> {
        let set = &self.ptm.header.scale_bias;
        let channels = self.ptm.planes.shape.channels();
        let best = self.best.polynomials();
        let mut pairs = Vec::new();
        for (raw, best) in self.ptm.planes.samples.chunks_exact(channels).zip(best.0) {
            if self.ptm.planes.shape == Shape::Rgb {
                pairs.extend((0..3).map(|c| (f64::from(raw[6 * c + i]), best[c][i])));
            } else {
                // Use the brightest color of the file, for which rounding errors of the luminance are smallest.
                let brightest = (0..3).max_by_key(|&c| raw[6 + c]).unwrap_or_default();
                let color = f64::from(raw[6 + brightest]).max(1.0);
                pairs.push((f64::from(raw[i]), best[brightest][i] * 255.0 / color));
            }
        }
        let to_raw = |(raw, best): (f64, f64)| (raw, best / set.scale[i] + set.bias[i]);
        pairs.into_iter().map(to_raw).collect()
    }
}

/// Weights of red, green and blue in a luminance: their mean, BT.601 and BT.709.
const LUMINANCE_WEIGHTS: [[f64; 3]; 3] = [
    [1.0 / 3.0; 3],
    [0.299, 0.587, 0.114],
    [0.2126, 0.7152, 0.0722],
];

/// Order of the coefficients in clause 1.0/1.
const CLAUSE_ORDER: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// Returns true if a quantization step is too wide, but the RMS error of each coefficient is less than 0.75 steps.
fn has_wide_steps(evidence: &WrongMap) -> bool {
    let best = evidence.best.scale_bias();
    let scale = evidence.ptm.header.scale_bias.scale;
    let is_wide = (0..6).any(|i| scale[i].abs() > 2.0 * best.scale[i]);
    let is_near = |i: usize| {
        let pairs = evidence.raw_and_expected_values(i);
        root_mean_square(pairs.into_iter().map(|(raw, wanted)| raw - wanted)) < 0.75
    };
    is_wide && (0..6).all(is_near)
}

/// Returns true if some values were clamped to 0 or 255, and all other values are approximately right.
fn has_clamped_values(evidence: &WrongMap) -> bool {
    let mut clamped_count = 0;
    let others_are_near = (0..6).all(|i| {
        let pairs = evidence.raw_and_expected_values(i);
        let is_clamped = |&(raw, wanted): &(f64, f64)| {
            (raw == 0.0 && wanted < -1.0) || (raw == 255.0 && wanted > 256.0)
        };
        clamped_count += pairs.iter().filter(|pair| is_clamped(pair)).count();
        let others = pairs.iter().filter(|pair| !is_clamped(pair));
        root_mean_square(others.map(|(raw, wanted)| raw - wanted)) < 1.5
    });
    clamped_count > 0 && others_are_near
}

/// Returns true if the lights do not determine all coefficients, and some coefficients are extremely large.
fn has_huge_coefficients(evidence: &WrongMap) -> bool {
    let largest = |map: &Polynomials| {
        let all = map.0.iter().flatten().flatten();
        all.fold(0.0_f64, |largest, a| largest.max(a.abs()))
    };
    !is_determined(&evidence.set)
        && largest(&evidence.found) > 3.0 * largest(&evidence.best.polynomials())
}

fn map_pixels(set: &mut ImageSet, change: fn(f64) -> f64) {
    for pixel in set.photographs.iter_mut().flat_map(|p| &mut p.pixels) {
        *pixel = (change(f64::from(*pixel) / 255.0) * 255.0).round() as u8;
    }
}

fn flip_rows(set: &mut ImageSet) {
    let row = 3 * set.size.width as usize;
    for photograph in &mut set.photographs {
        let rows: Vec<&[u8]> = photograph.pixels.chunks(row).rev().collect();
        photograph.pixels = rows.concat();
    }
}

fn mirror_rows(set: &mut ImageSet) {
    let row = 3 * set.size.width as usize;
    for photograph in &mut set.photographs {
        for row in photograph.pixels.chunks_exact_mut(row) {
            let pixels: Vec<[u8; 3]> = row.as_chunks().0.iter().rev().copied().collect();
            row.copy_from_slice(pixels.as_flattened());
        }
    }
}

/// Pairs each photograph with the light of the next one.
fn shift_lights(set: &mut ImageSet) {
    let mut lights: Vec<[f64; 3]> = set.photographs.iter().map(|p| p.light).collect();
    lights.rotate_left(1);
    for (photograph, light) in set.photographs.iter_mut().zip(lights) {
        photograph.light = light;
    }
}

fn swap_red_and_blue(set: &mut ImageSet) {
    for photograph in &mut set.photographs {
        for pixel in photograph.pixels.chunks_exact_mut(3) {
            pixel.swap(0, 2);
        }
    }
}

fn sort_by_name(set: &mut ImageSet) {
    let lights: Vec<[f64; 3]> = set.photographs.iter().map(|p| p.light).collect();
    set.photographs.sort_by(|a, b| a.name.cmp(&b.name));
    for (photograph, light) in set.photographs.iter_mut().zip(lights) {
        photograph.light = light;
    }
}

impl FitMistake {
    fn criterion(&self) -> Criterion {
        use Criterion::{Lights, Map, Numbers, Photographs};
        match self.slug.as_str() {
            "v-negated" => Lights(|p| [p.direction()[0], -p.direction()[1]]),
            "u-negated" => Lights(|p| [-p.direction()[0], p.direction()[1]]),
            "u-and-v-exchanged" => Lights(|p| [p.direction()[1], p.direction()[0]]),
            "u-and-v-negated" => Lights(|p| p.direction().map(|c| -c)),
            "light-not-normalized" => Lights(|p| [p.light[0], p.light[1]]),
            "light-normalized-in-the-plane" => Lights(|p| {
                let [x, y, _] = p.light;
                [x, y].map(|c| c / x.hypot(y).max(1e-12))
            }),
            "images-sorted-by-name" => Photographs(sort_by_name),
            "lights-of-the-next-image" => Photographs(shift_lights),
            "top-row-first" => Photographs(flip_rows),
            "columns-mirrored" => Photographs(mirror_rows),
            "texels-not-in-blocks" => Criterion::Texels,
            "red-and-blue-exchanged" => Photographs(swap_red_and_blue),
            "gamma-removed" => Photographs(|set| map_pixels(set, |x| x.powf(2.2))),
            "gamma-applied" => Photographs(|set| map_pixels(set, |x| x.powf(1.0 / 2.2))),
            "bias-added-after-scaling" => {
                Numbers(CLAUSE_ORDER, |raw, scale, bias| raw * scale + bias)
            }
            "bias-subtracted-after-scaling" => {
                Numbers(CLAUSE_ORDER, |raw, scale, bias| raw * scale - bias)
            }
            "bias-negated" => Numbers(CLAUSE_ORDER, |raw, scale, bias| (raw + bias) * scale),
            "linear-terms-first" => {
                Numbers([4, 5, 3, 1, 2, 0], |raw, scale, bias| (raw - bias) * scale)
            }
            "coefficients-reversed" => {
                Numbers([5, 4, 3, 2, 1, 0], |raw, scale, bias| (raw - bias) * scale)
            }
            "luminance-in-the-color" => Criterion::DarkenedByColor,
            "unconstrained" => Map(has_huge_coefficients),
            "coefficients-clamped" => Map(has_clamped_values),
            "scales-too-coarse" => Map(has_wide_steps),
            other => unreachable!("the mistake {other} has no criterion"),
        }
    }
}
