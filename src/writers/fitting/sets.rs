//! Generated photographs: renderings of a map with known coefficients, with typical defects of photographs.

use crate::generate::{Model, Recipe};
use crate::ptm::{Format, Ptm, ScaleBias, Size};
use crate::writers::fitting::pictures::{ImageSet, Photograph};
use crate::writers::fitting::polynomials::Polynomials;
use crate::writers::request::new_map;

/// Parameters from which a set of photographs is generated.
#[derive(Clone, Copy, Debug)]
pub struct SetPlan {
    /// Name of the set.
    pub name: &'static str,
    /// Purpose of the set, in a sentence.
    pub because: &'static str,
    /// Clause that the set is about.
    pub clause: &'static str,
    size: (u32, u32),
    /// Number of lights.
    lights: usize,
    /// True if all lights are on the right side.
    is_one_sided: bool,
    /// Scale of a5, which determines the brightness.
    brightness: f64,
    /// Maximum noise of a pixel value.
    noise: u8,
    /// True if the vectors in the `.lp` file do not have length 1.
    has_long_vectors: bool,
    /// True if the `.lp` file lists the images in alphabetical order.
    in_order: bool,
}

const ORDINARY_SET: SetPlan = SetPlan {
    name: "ordinary",
    because: "There are twelve lights from all directions, and a map can reproduce the images exactly.",
    clause: "1.0/1",
    size: (5, 4),
    lights: 12,
    is_one_sided: false,
    brightness: 0.6,
    noise: 0,
    has_long_vectors: false,
    in_order: true,
};

/// All sets. The first one is used for first contact.
pub const SETS: [SetPlan; 9] = [
    ORDINARY_SET,
    SetPlan {
        name: "noise",
        because: "Every pixel has noise of up to 8, so the best fit is not exact.",
        noise: 8,
        size: (7, 6),
        ..ORDINARY_SET
    },
    SetPlan {
        name: "few-lights",
        because: "Five lights do not determine six coefficients, so many maps fit; the map with small coefficients is expected.",
        lights: 5,
        ..ORDINARY_SET
    },
    SetPlan {
        name: "one-side",
        because: "All lights are on one side, where several coefficients have nearly the same effect.",
        lights: 14,
        is_one_sided: true,
        noise: 3,
        ..ORDINARY_SET
    },
    SetPlan {
        name: "saturated",
        because: "Many pixels are white under every light.",
        brightness: 1.3,
        ..ORDINARY_SET
    },
    SetPlan {
        name: "dark",
        because: "Many pixels are black, so their color is undetermined.",
        brightness: 0.12,
        ..ORDINARY_SET
    },
    SetPlan {
        name: "long-vectors",
        because: "The light vectors have lengths of 1.5 to 3, as in files that state positions.",
        clause: "1.0/2",
        has_long_vectors: true,
        ..ORDINARY_SET
    },
    SetPlan {
        name: "not-in-order-of-names",
        because: "The .lp file does not list the images in the order of their names.",
        clause: "1.0/2",
        in_order: false,
        ..ORDINARY_SET
    },
    SetPlan {
        name: "many-lights",
        because: "There are sixty lights, and the images have 17 × 3 pixels.",
        lights: 60,
        size: (17, 3),
        noise: 5,
        ..ORDINARY_SET
    },
];

impl SetPlan {
    /// Generates the photographs. If `format` is LRGB, each texel is the product of a luminance and a color.
    #[must_use]
    pub fn make(&self, format: Format) -> ImageSet {
        let (width, height) = self.size;
        let size = Size { width, height };
        let map = Polynomials::new(&self.map(size, format)).expect("a map of RGB or LRGB");
        let photograph = |k: usize| {
            // No number of lights is a multiple of 7, so every name occurs once.
            let number = if self.in_order {
                k
            } else {
                7 * k % self.lights
            };
            let mut photograph = Photograph {
                name: format!("light-{number:02}.png"),
                light: self.light(k),
                pixels: Vec::new(),
            };
            let noise = self.generate_noise(size, k);
            let shown = map.evaluate(photograph.direction()).zip(noise);
            let pixels = shown.map(|(value, noise)| (value + noise).round() as u8);
            photograph.pixels = pixels.collect();
            photograph
        };
        ImageSet {
            size,
            photographs: (0..self.lights).map(photograph).collect(),
        }
    }

    /// Generates the map that is photographed.
    fn map(&self, size: Size, format: Format) -> Ptm {
        let scale_bias = ScaleBias {
            scale: [0.3, 0.2, 0.25, 0.25, 0.3, self.brightness],
            bias: [128.0, 100.0, 140.0, 120.0, 130.0, -60.0],
        };
        let samples = Model::paint(&Recipe::ordinary(format, size)).samples;
        new_map(format, size, scale_bias, None, samples)
    }

    /// Returns the vector to light `k`.
    fn light(&self, k: usize) -> [f64; 3] {
        // Multiples of the golden angle never coincide, and the heights are distributed evenly.
        const GOLDEN_ANGLE: f64 = 2.399_963;
        let around = GOLDEN_ANGLE * k as f64;
        let angle = if self.is_one_sided {
            around.sin()
        } else {
            around
        };
        let z = 0.2 + 0.75 * (k as f64 + 0.5) / self.lights as f64;
        let away = (1.0 - z * z).sqrt();
        let length = match self.has_long_vectors {
            true => 1.5 + 0.5 * (k % 4) as f64,
            false => 1.0,
        };
        [away * angle.cos(), away * angle.sin(), z].map(|x| (x * length * 1e6).round() / 1e6)
    }

    /// Generates noise for each value of photograph `k`.
    fn generate_noise(&self, size: Size, k: usize) -> Vec<f64> {
        let mut recipe = Recipe::ordinary(Format::Lrgb, size);
        recipe.seed = 1000 + k as u32;
        let painted = Model::paint(&recipe).samples;
        let most = f64::from(self.noise);
        let values = painted.iter().step_by(3);
        let noise = values.map(|&value| (f64::from(value) / 127.5 - 1.0) * most);
        noise.collect()
    }
}
