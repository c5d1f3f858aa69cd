//! Tests that arithmetic of low precision and curves over samples are recognized, and that nothing else is taken for them.

use ptm::decode::planes;
use ptm::{Coding, Ptm, Reading, Shape};
use ptm_harness::diagnose::{Cause, Diagnosis, diagnose};
use ptm_mistakes::answer;
use ptm_suite::protocol::frame::{Answer, Samples, View};
use ptm_suite::protocol::request::Request;
use ptm_suite::verdicts::outcome::Outcome;

use crate::in_process::{jobs, reference_answer, run_all, suite_of_small_files};

/// Slugs of the mistakes of half precision.
const HALF_PRECISION: [&str; 3] = [
    "coefficients-of-half-floats",
    "coefficients-in-half-precision",
    "colors-in-half-precision",
];

/// A binary floating-point format.
#[derive(Clone, Copy)]
struct Precision {
    /// Number of significant bits of normal numbers.
    bits: i32,
    /// Exponent of the smallest normal number.
    smallest_exponent: i32,
    /// The largest finite number.
    largest: f64,
}

const HALF: Precision = Precision {
    bits: 11,
    smallest_exponent: -14,
    largest: 65504.0,
};
const BFLOAT16: Precision = Precision {
    bits: 8,
    smallest_exponent: -126,
    largest: f32::MAX as f64,
};
const SINGLE: Precision = Precision {
    bits: 24,
    smallest_exponent: -126,
    largest: f32::MAX as f64,
};

impl Precision {
    fn round(self, value: f64) -> f64 {
        if value == 0.0 || !value.is_finite() {
            return value;
        }
        let exponent = (value.abs().log2().floor() as i32).max(self.smallest_exponent);
        let spacing = 2.0_f64.powi(exponent + 1 - self.bits);
        let rounded = (value / spacing).round_ties_even() * spacing;
        if rounded.abs() > self.largest {
            f64::INFINITY.copysign(value)
        } else {
            rounded
        }
    }

    fn multiply(self, a: f64, b: f64) -> f64 {
        self.round(self.round(a) * self.round(b))
    }

    fn sum(self, terms: &[f64]) -> f64 {
        let terms = terms.iter().map(|&term| self.round(term));
        terms.fold(0.0, |sum, term| self.round(sum + term))
    }

    /// Computes the final values of a map.
    fn final_values(self, ptm: &Ptm) -> Vec<f64> {
        let shape = &ptm.planes.shape;
        let set = &ptm.header.scale_bias;
        let value = |(i, &raw): (usize, &u8)| {
            let (raw, channel) = (f64::from(raw), i % shape.channels());
            if channel >= shape.coefficients() {
                return raw;
            }
            let [scale, bias] = [set.scale[channel % 6], set.bias[channel % 6]];
            self.multiply(self.sum(&[raw, -bias]), scale)
        };
        ptm.planes.samples.iter().enumerate().map(value).collect()
    }

    /// Computes the colors of a map from its final values, without clamping.
    fn colors(self, shape: &Shape, values: &[f64], u: f64, v: f64) -> Vec<f64> {
        let times = |a, b| self.multiply(a, b);
        let polynomial = |a: &[f64]| {
            let squares = [times(times(a[0], u), u), times(times(a[1], v), v)];
            let [square_u, square_v] = squares;
            let both = times(times(a[2], u), v);
            self.sum(&[
                square_u,
                square_v,
                both,
                times(a[3], u),
                times(a[4], v),
                a[5],
            ])
        };
        let color = |texel: &[f64]| match shape {
            Shape::Rgb => [0, 6, 12].map(|first| polynomial(&texel[first..first + 6])),
            Shape::Lrgb => {
                let luminance = polynomial(texel);
                [6, 7, 8].map(|c| self.round(times(luminance, texel[c]) / 255.0))
            }
            Shape::Lum(m) => {
                let y = polynomial(texel);
                let row = |row: usize| {
                    let columns = [times(m.0[row], y), times(m.0[4 + row], texel[6])];
                    let [first, second] = columns;
                    let third = times(m.0[8 + row], texel[7]);
                    self.sum(&[first, second, third, m.0[12 + row]])
                };
                [0, 1, 2].map(row)
            }
        };
        values
            .chunks_exact(shape.channels())
            .flat_map(color)
            .collect()
    }
}

/// A decoder that computes with low precision.
struct Decoder {
    /// Precision of final coefficients, also in the view `coef`.
    coefficients: Precision,
    /// Precision of colors.
    colors: Precision,
    /// Conversion of a color within 0…255 to a byte.
    to_byte: fn(f64) -> u8,
    /// True if the decoder supports no other view than colors.
    only_colors: bool,
}

fn rounded(color: f64) -> u8 {
    color.round() as u8
}

fn truncated(color: f64) -> u8 {
    color as u8
}

impl Decoder {
    fn answer(&self, request: &Request) -> Answer {
        let mut answer = reference_answer(request);
        let Answer::Decoded(frame) = &mut answer else {
            return answer;
        };
        let ptm = ptm::decode(request.file).expect("the reference decodes the file");
        let values = self.coefficients.final_values(&ptm);
        match (request.view, &mut frame.samples) {
            (View::Rgb(light), Samples::U8(samples)) => {
                let shape = &ptm.planes.shape;
                let colors = self.colors.colors(shape, &values, light.lu, light.lv);
                let clamped = colors.iter().map(|color| color.clamp(0.0, 255.0));
                *samples = clamped.map(self.to_byte).collect();
            }
            _ if self.only_colors => return Answer::Unsupported,
            (View::Coef, Samples::F32(samples)) => {
                *samples = values.iter().map(|&value| value as f32).collect();
            }
            _ => {}
        }
        answer
    }
}

/// Runs a decoder, and returns the number of failures and the causes.
fn check(decoder: impl Fn(&Request) -> Answer + Sync) -> (usize, Vec<Diagnosis>) {
    let suite = suite_of_small_files();
    let run = run_all(&suite, decoder);
    let failures = run.judgment.with_outcome(Outcome::Fail).count();
    let causes = diagnose(&suite, &run, &[], jobs());
    for cause in &causes.diagnoses {
        println!("  {} of {failures}: {}", cause.explains.len(), name(cause));
    }
    (failures, causes.diagnoses)
}

/// Returns the slug of a cause, or its description.
fn name(diagnosis: &Diagnosis) -> &str {
    match &diagnosis.cause {
        Cause::Misreading { misreading, .. } => misreading.slug,
        Cause::Described { effect, .. } => effect,
    }
}

/// Asserts that the first cause is certain, and that no other mechanism is named.
fn assert_named(slug: &str, (failures, causes): (usize, Vec<Diagnosis>)) {
    let names: Vec<&str> = causes.iter().map(name).collect();
    assert!(failures > 1 && names[0] == slug, "{names:#?}");
    assert!(causes[0].is_mechanism);
    assert!(
        !names.iter().any(|name| name.contains("instead of")),
        "{names:#?}"
    );
    let misreadings = causes
        .iter()
        .filter(|one| matches!(one.cause, Cause::Misreading { .. }));
    let mut others = misreadings.map(name).filter(|&name| name != slug);
    assert!(
        others.all(|name| HALF_PRECISION.contains(&name)),
        "{names:#?}"
    );
}

#[test]
fn colors_in_half_precision_are_named() {
    for to_byte in [rounded, truncated] {
        for (coefficients, only_colors) in [(SINGLE, false), (HALF, true)] {
            let decoder = Decoder {
                coefficients,
                colors: HALF,
                to_byte,
                only_colors,
            };
            let found = check(|request| decoder.answer(request));
            assert_named("colors-in-half-precision", found);
        }
    }
}

#[test]
fn coefficients_in_half_precision_are_named() {
    for colors in [HALF, SINGLE] {
        let decoder = Decoder {
            coefficients: HALF,
            colors,
            to_byte: truncated,
            only_colors: false,
        };
        let found = check(|request| decoder.answer(request));
        assert_named("coefficients-in-half-precision", found);
    }
}

#[test]
fn coefficients_of_half_floats_are_named() {
    let reading = Reading {
        final_coefficient: |raw, channel, set| {
            HALF.round(ptm::evaluate::final_coefficient(raw, channel, set))
        },
        ..Reading::SPEC
    };
    let found = check(|request| answer(&[], reading, request.file, request.view));
    assert_named("coefficients-of-half-floats", found);
}

/// Java's `getRGB` converts gray images to sRGB.
#[test]
fn linear_gray_converted_to_srgb_is_named() {
    let reading = Reading {
        stream: |plane| {
            let samples = planes::decode_stream(plane)?.into_iter();
            let curve = |sample: u8| match f64::from(sample) / 255.0 {
                linear if plane.coding != Coding::Jpeg || linear == 0.0 => sample,
                linear => (269.025 * linear.powf(5.0 / 12.0) - 14.025).round() as u8,
            };
            Ok(samples.map(curve).collect())
        },
        ..Reading::SPEC
    };
    let found = check(|request| answer(&[], reading, request.file, request.view));
    assert_named("jpeg-linear-gray-to-srgb", found);
}

/// Decoders that are exact to 24 bits, or to fewer bits than half precision, or that are wrong in another way.
#[test]
fn nothing_else_is_taken_for_half_precision() {
    let decoder = |colors, to_byte| Decoder {
        coefficients: SINGLE,
        colors,
        to_byte,
        only_colors: false,
    };
    for to_byte in [rounded, truncated] {
        let single = decoder(SINGLE, to_byte);
        let (failures, _) = check(|request| single.answer(request));
        assert_eq!(failures, 0);
    }
    let others: [(&str, Decoder); 3] = [
        ("bfloat16", decoder(BFLOAT16, truncated)),
        ("darker", decoder(SINGLE, |color| (color - 0.5) as u8)),
        ("even", decoder(SINGLE, |color| color as u8 & 0xFE)),
    ];
    for (what, other) in others {
        println!("{what}");
        let (failures, causes) = check(|request| other.answer(request));
        let mut names = causes.iter().map(name);
        assert!(failures > 20, "{what}");
        assert!(names.all(|name| !HALF_PRECISION.contains(&name)), "{what}");
    }
}
