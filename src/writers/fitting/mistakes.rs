//! Mistakes of fitters, found by making them.
//!
//! A mistake with photographs or lights has its own optimum: a map that is near it was fitted with that mistake. A mistake with
//! the file leaves a map that is right if its numbers are interpreted differently. A map that is near the optimum within its
//! own steps has steps that are too wide, or a range that is too small.

use crate::decode::decode;
use crate::ptm::{Format, Ptm, Shape};
use crate::writers::fitting::algebra::LeastSquares;
use crate::writers::fitting::judge::max_error;
use crate::writers::fitting::optimum::{Fitted, directions};
use crate::writers::fitting::pictures::{Photograph, PictureSet};
use crate::writers::fitting::polynomials::{Polynomials, root_mean_square};

/// A mistake of fitters.
pub(super) struct FitMistake {
    /// The clause that it breaks.
    pub clause: &'static str,
    /// The effect of the mistake, as a sentence without its subject.
    pub effect: &'static str,
    /// The suggested fix.
    pub fix: &'static str,
    sign: Sign,
}

/// A sign of a mistake.
enum Sign {
    /// The map is near the best fit of these photographs.
    Photographs(fn(&mut PictureSet)),
    /// The map is near the best fit under these lights.
    Lights(fn(&Photograph) -> [f64; 2]),
    /// The map is right if its coefficients are in this order and are these functions of raw value, scale and bias.
    Numbers([usize; 6], fn(f64, f64, f64) -> f64),
    /// The numbers of the map show it.
    Map(fn(&WrongMap) -> bool),
}

/// A wrong map, with the right one.
pub(super) struct WrongMap {
    set: PictureSet,
    format: Format,
    ptm: Ptm,
    found: Polynomials,
    best: Fitted,
}

impl WrongMap {
    /// Returns `None` if the file is not a map of these photographs.
    pub fn new(set: PictureSet, format: Format, file: &[u8]) -> Option<WrongMap> {
        let ptm = decode(file).ok()?;
        let is_of_set = ptm.header.format == format && ptm.header.size == set.size;
        is_of_set.then_some(())?;
        Some(WrongMap {
            format,
            found: Polynomials::new(&ptm)?,
            best: Fitted::new(&set, &directions(&set), format),
            set,
            ptm,
        })
    }

    /// Returns true if a fitter with this mistake makes such a map.
    pub fn shows(&self, mistake: &FitMistake) -> bool {
        match &mistake.sign {
            Sign::Photographs(change) => {
                let mut changed = self.set.clone();
                change(&mut changed);
                let lights = directions(&changed);
                self.is_equivalent(&Fitted::new(&changed, &lights, self.format))
            }
            Sign::Lights(light) => {
                let lights: Vec<_> = self.set.photographs.iter().map(light).collect();
                self.is_equivalent(&Fitted::new(&self.set, &lights, self.format))
            }
            Sign::Numbers(order, value) => self.is_right(*order, *value),
            Sign::Map(shows) => shows(self),
        }
    }

    /// Returns true if the map looks like `other`, and is far from the optimum.
    fn is_equivalent(&self, other: &Fitted) -> bool {
        let other = other.polynomials();
        let from_best = self.found.distance(&self.best.polynomials(), &self.set);
        self.found.distance(&other, &self.set) < 1.0 + 0.1 * from_best
    }

    /// Returns true if the map fits when its coefficients are read in this order and in this way.
    fn is_right(&self, order: [usize; 6], value: fn(f64, f64, f64) -> f64) -> bool {
        let best = self.best.polynomials().errors(&self.set);
        let found =
            Polynomials::with_values(&self.ptm, order, value).map(|found| found.errors(&self.set));
        found.is_some_and(|found| {
            // An integer offset rounds more than a bias does.
            let mut pairs = found.iter().zip(best);
            pairs.all(|(&found, best)| found <= max_error(best) + 2.0)
        })
    }

    /// Returns for coefficient `i` of each texel the raw value, and the right one under the file's scale and bias.
    fn raw_and_wanted(&self, i: usize) -> Vec<(f64, f64)> {
        let set = &self.ptm.header.scale_bias;
        let channels = self.ptm.planes.shape.channels();
        let best = self.best.polynomials();
        let mut pairs = Vec::new();
        for (raw, best) in self.ptm.planes.samples.chunks_exact(channels).zip(best.0) {
            if self.ptm.planes.shape == Shape::Rgb {
                let channels = (0..3).map(|c| (f64::from(raw[6 * c + i]), best[c][i]));
                pairs.extend(channels);
            } else {
                // For the brightest color of the file, in which the luminance rounds least.
                let brightest = (0..3).max_by_key(|&c| raw[6 + c]).unwrap_or_default();
                let color = f64::from(raw[6 + brightest]).max(1.0);
                pairs.push((f64::from(raw[i]), best[brightest][i] * 255.0 / color));
            }
        }
        let in_raw = |(raw, best): (f64, f64)| (raw, best / set.scale[i] + set.bias[i]);
        pairs.into_iter().map(in_raw).collect()
    }
}

/// The order of the coefficients in clause 1.0/1.
const CLAUSE_ORDER: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// Each step is wide, and each value within a step of the right one.
fn has_wide_steps(evidence: &WrongMap) -> bool {
    let best = evidence.best.scale_bias();
    let scale = evidence.ptm.header.scale_bias.scale;
    let is_wide = (0..6).any(|i| scale[i].abs() > 2.0 * best.scale[i]);
    let is_near = |i: usize| {
        let pairs = evidence.raw_and_wanted(i);
        root_mean_square(pairs.into_iter().map(|(raw, wanted)| raw - wanted)) < 0.75
    };
    is_wide && (0..6).all(is_near)
}

/// Returns true if values at the ends of the byte range should be beyond it, and all others are about right.
fn has_cut_ends(evidence: &WrongMap) -> bool {
    let mut cut = 0;
    let others_are_near = (0..6).all(|i| {
        let pairs = evidence.raw_and_wanted(i);
        let is_cut = |&(raw, wanted): &(f64, f64)| {
            (raw == 0.0 && wanted < -1.0) || (raw == 255.0 && wanted > 256.0)
        };
        cut += pairs.iter().filter(|pair| is_cut(pair)).count();
        let others = pairs.iter().filter(|pair| !is_cut(pair));
        root_mean_square(others.map(|(raw, wanted)| raw - wanted)) < 1.5
    });
    cut > 0 && others_are_near
}

/// Returns true if the lights leave coefficients open, and some are extremely large.
fn has_huge_coefficients(evidence: &WrongMap) -> bool {
    let largest = |of: &Polynomials| {
        let all = of.0.iter().flatten().flatten();
        all.fold(0.0_f64, |most, a| most.max(a.abs()))
    };
    let least_squares = LeastSquares::new(&directions(&evidence.set));
    !least_squares.is_determined
        && largest(&evidence.found) > 3.0 * largest(&evidence.best.polynomials())
}

fn each_pixel(set: &mut PictureSet, change: fn(f64) -> f64) {
    for pixel in set.photographs.iter_mut().flat_map(|of| &mut of.pixels) {
        *pixel = (change(f64::from(*pixel) / 255.0) * 255.0).round() as u8;
    }
}

fn bottom_row_first(set: &mut PictureSet) {
    let row = 3 * set.size.width as usize;
    for photograph in &mut set.photographs {
        let rows: Vec<&[u8]> = photograph.pixels.chunks(row).rev().collect();
        photograph.pixels = rows.concat();
    }
}

fn blue_first(set: &mut PictureSet) {
    for photograph in &mut set.photographs {
        for pixel in photograph.pixels.chunks_exact_mut(3) {
            pixel.swap(0, 2);
        }
    }
}

fn in_order_of_names(set: &mut PictureSet) {
    let lights: Vec<[f64; 3]> = set.photographs.iter().map(|of| of.light).collect();
    set.photographs.sort_by(|a, b| a.name.cmp(&b.name));
    for (photograph, light) in set.photographs.iter_mut().zip(lights) {
        photograph.light = light;
    }
}

/// All known mistakes; if several explain as much, the first is named.
pub(super) const MISTAKES: [FitMistake; 18] = [
    FitMistake {
        clause: "1.0/2",
        effect: "negates v: a light from above looks like a light from below",
        fix: "use v of the .lp file unchanged: v points up",
        sign: Sign::Lights(|of| [of.direction()[0], -of.direction()[1]]),
    },
    FitMistake {
        clause: "1.0/2",
        effect: "negates u: a light from the right looks like a light from the left",
        fix: "use u of the .lp file unchanged: u points right",
        sign: Sign::Lights(|of| [-of.direction()[0], of.direction()[1]]),
    },
    FitMistake {
        clause: "1.0/2",
        effect: "exchanges u and v",
        fix: "u is the first number of a light, v the second",
        sign: Sign::Lights(|of| [of.direction()[1], of.direction()[0]]),
    },
    FitMistake {
        clause: "1.0/2",
        effect: "does not normalize the light vectors",
        fix: "divide each light vector by its length; u and v are its first two components",
        sign: Sign::Lights(|of| [of.light[0], of.light[1]]),
    },
    FitMistake {
        clause: "1.0/2",
        effect: "normalizes u and v without the third component, so all lights lie in the plane",
        fix: "divide u and v by the length of the whole vector",
        sign: Sign::Lights(|of| {
            let [x, y, _] = of.light;
            [x, y].map(|c| c / x.hypot(y).max(1e-12))
        }),
    },
    FitMistake {
        clause: "1.0/2",
        effect: "sorts the images by name, but keeps the order of the lights in the .lp file",
        fix: "pair each image with the light on its line of the .lp file",
        sign: Sign::Photographs(in_order_of_names),
    },
    FitMistake {
        clause: "2.7.1/3",
        effect: "stores the top row first",
        fix: "write the bottom row of the images first",
        sign: Sign::Photographs(bottom_row_first),
    },
    FitMistake {
        clause: "2.7.1/2",
        effect: "exchanges red and blue",
        fix: "the order is red, green, blue; some libraries read images as blue, green, red",
        sign: Sign::Photographs(blue_first),
    },
    FitMistake {
        clause: "1.0/1",
        effect: "removes the gamma of the images before the fit, so midtones are too dark",
        fix: "fit the pixel values unchanged: readers show the values of the polynomials",
        sign: Sign::Photographs(|set| each_pixel(set, |x| x.powf(2.2))),
    },
    FitMistake {
        clause: "1.0/1",
        effect: "applies a gamma to the images before the fit, so midtones are too bright",
        fix: "fit the pixel values unchanged: readers show the values of the polynomials",
        sign: Sign::Photographs(|set| each_pixel(set, |x| x.powf(1.0 / 2.2))),
    },
    FitMistake {
        clause: "2.4/8",
        effect: "writes a bias that must be added after scaling",
        fix: "a coefficient is (raw − bias) · scale, so the bias is −minimum / scale, in units of the raw value",
        sign: Sign::Numbers(CLAUSE_ORDER, |raw, scale, bias| raw * scale + bias),
    },
    FitMistake {
        clause: "2.4/8",
        effect: "writes a bias that must be subtracted after scaling",
        fix: "a coefficient is (raw − bias) · scale, so the bias is −minimum / scale, in units of the raw value",
        sign: Sign::Numbers(CLAUSE_ORDER, |raw, scale, bias| raw * scale - bias),
    },
    FitMistake {
        clause: "2.4/8",
        effect: "writes biases with the wrong sign",
        fix: "a coefficient is (raw − bias) · scale: the bias is subtracted",
        sign: Sign::Numbers(CLAUSE_ORDER, |raw, scale, bias| (raw + bias) * scale),
    },
    FitMistake {
        clause: "1.0/1",
        effect: "writes the coefficients in the order 1, u, v, u·v, u², v²",
        fix: "the order is u², v², u·v, u, v, 1",
        sign: Sign::Numbers([4, 5, 3, 1, 2, 0], |raw, scale, bias| (raw - bias) * scale),
    },
    FitMistake {
        clause: "1.0/1",
        effect: "writes the coefficients in the reverse order, 1 first and u² last",
        fix: "the order is u², v², u·v, u, v, 1",
        sign: Sign::Numbers([5, 4, 3, 2, 1, 0], |raw, scale, bias| (raw - bias) * scale),
    },
    FitMistake {
        clause: "2.4/8",
        effect: "fits without a constraint if the lights do not determine six coefficients: some become large, and so do their quantization steps",
        fix: "choose the solution with the smallest coefficients: use the singular value decomposition or ridge regression",
        sign: Sign::Map(has_huge_coefficients),
    },
    FitMistake {
        clause: "2.4/1",
        effect: "clamps coefficients to 0 or 255: scale and bias do not cover their range",
        fix: "choose scale and bias so that the range of each coefficient in the map fits in 0 to 255",
        sign: Sign::Map(has_cut_ends),
    },
    FitMistake {
        clause: "2.4/2",
        effect: "uses scales that are too coarse: quantization adds more error than the fit",
        fix: "divide the range of each coefficient in the map by 255",
        sign: Sign::Map(has_wide_steps),
    },
];
