//! Generated photographs: a map with known coefficients, rendered with typical defects of photographs.

use std::sync::LazyLock;

use serde::Deserialize;

use crate::fitting::photographs::{ImageSet, Photograph};
use crate::{fitting::polynomials::Polynomials, request::new_map};
use ptm::{Format, Ptm, ScaleBias, Size};
use ptm_generate::{Model, Recipe};
use ptm_suite::kit::yaml::from_yaml;

/// Parameters of a generated set of photographs, as defined in `spec-cases/writers/fitting-sets.yaml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is an independent property"
)]
pub struct SetPlan {
    /// Name of the set.
    pub name: String,
    /// Purpose of the set, in a sentence.
    pub because: String,
    /// Clause that the set tests.
    pub clause: String,
    size: (u32, u32),
    /// Number of lights.
    lights: usize,
    /// True if all lights are to the right of the object.
    is_one_sided: bool,
    /// Scale of `a5`, which determines the brightness.
    brightness: f64,
    /// Maximum noise added to a pixel value.
    noise: u8,
    /// True if the vectors in the `.lp` file are longer than unit vectors.
    has_long_vectors: bool,
    /// True if the `.lp` file does not list the images in alphabetical order.
    is_shuffled: bool,
    /// Height of all lights over the horizon in degrees, if they form a ring.
    ring_elevation: Option<f64>,
    /// Number of decimals of the vectors in the `.lp` file.
    decimals: i32,
    /// True if all texels are equal.
    is_constant: bool,
}

impl Default for SetPlan {
    fn default() -> SetPlan {
        SetPlan {
            name: String::new(),
            because: String::new(),
            clause: "1.0/1".to_owned(),
            size: (5, 4),
            lights: 12,
            is_one_sided: false,
            brightness: 0.6,
            noise: 0,
            has_long_vectors: false,
            is_shuffled: false,
            ring_elevation: None,
            decimals: 6,
            is_constant: false,
        }
    }
}

/// All sets. The first one is used for first contact with a fitter.
pub static SETS: LazyLock<Vec<SetPlan>> = LazyLock::new(|| {
    let yaml = ptm_spec_cases::writers::FITTING_SETS;
    from_yaml(yaml).expect("a list of sets")
});

impl SetPlan {
    /// Generates the photographs. If `format` is LRGB, each texel is the product of a luminance and a color.
    #[must_use]
    pub fn make(&self, format: Format) -> ImageSet {
        let (width, height) = self.size;
        let size = Size { width, height };
        let map = Polynomials::new(&self.map(size, format)).expect("the format is not LUM");
        let photograph = |k: usize| {
            // No number of lights is a multiple of 7, so every name occurs once.
            let number = match self.is_shuffled {
                true => 7 * k % self.lights,
                false => k,
            };
            let mut photograph = Photograph {
                name: format!("light-{number:02}.png"),
                light: self.light(k),
                pixels: Vec::new(),
                lossy_file: None,
            };
            let noise = self.generate_noise(size, k);
            let values = map.evaluate(photograph.direction()).zip(noise);
            let pixels = values.map(|(value, noise)| (value + noise).round() as u8);
            photograph.pixels = pixels.collect();
            photograph
        };
        ImageSet {
            size,
            photographs: (0..self.lights).map(photograph).collect(),
        }
    }

    fn map(&self, size: Size, format: Format) -> Ptm {
        let scale_bias = ScaleBias {
            scale: [0.3, 0.2, 0.25, 0.25, 0.3, self.brightness],
            bias: [128.0, 100.0, 140.0, 120.0, 130.0, -60.0],
        };
        let mut samples = Model::paint(&Recipe::default_for(format, size)).samples;
        if self.is_constant {
            // The coefficient of u² is negative, so a fitter that clamps coefficients fails.
            let texels = samples.chunks_exact(format.channels());
            let texel = texels.min_by_key(|texel| texel[0]).expect("a texel");
            samples = texel.repeat(size.texels());
        }
        new_map(format, size, scale_bias, None, samples)
    }

    fn light(&self, k: usize) -> [f64; 3] {
        // Multiples of the golden angle never coincide, and the heights are distributed evenly.
        const GOLDEN_ANGLE: f64 = 2.399_963;
        let fraction = (k as f64 + 0.5) / self.lights as f64;
        let (angle, z) = match self.ring_elevation {
            Some(degrees) => (
                std::f64::consts::TAU * k as f64 / self.lights as f64,
                degrees.to_radians().sin(),
            ),
            None if self.is_one_sided => ((GOLDEN_ANGLE * k as f64).sin(), 0.2 + 0.75 * fraction),
            None => (GOLDEN_ANGLE * k as f64, 0.2 + 0.75 * fraction),
        };
        let radius = (1.0 - z * z).sqrt();
        let length = match self.has_long_vectors {
            true => 1.5 + 0.5 * (k % 4) as f64,
            false => 1.0,
        };
        // Adding 0 turns a negative zero into a positive one.
        let unit = 10.0_f64.powi(self.decimals);
        [radius * angle.cos(), radius * angle.sin(), z]
            .map(|x| (x * length * unit).round() / unit + 0.0)
    }

    fn generate_noise(&self, size: Size, k: usize) -> Vec<f64> {
        let mut recipe = Recipe::default_for(Format::Lrgb, size);
        recipe.seed = 1000 + k as u32;
        let samples = Model::paint(&recipe).samples;
        let max_noise = f64::from(self.noise);
        let values = samples.iter().step_by(3);
        let noise = values.map(|&value| (f64::from(value) / 127.5 - 1.0) * max_noise);
        noise.collect()
    }
}
