//! §2.4 Scale and Bias: the formula

use super::{At, Decision, Misreading};
use crate::ptm::ScaleBias;
use crate::reading::Reading;

/// A mistake in the formula.
const fn formula(
    slug: &'static str,
    clause: &'static str,
    effect: &'static str,
    mend: &'static str,
    change: fn(Reading) -> Reading,
) -> Misreading {
    Misreading {
        slug,
        clause,
        effect,
        mend,
        at: At::Reading(Decision::FinalCoefficient, change),
    }
}

const MEND: &str = "final = (raw − bias) · scale, in real numbers";

pub(super) const ALL: &[Misreading] = &[
    formula(
        "scale-then-bias",
        "2.4/8",
        "computes raw · scale − bias",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| f64::from(raw) * scale(i, set) - bias(i, set),
            ..r
        },
    ),
    formula("bias-added", "2.4/8", "adds the bias", MEND, |r| Reading {
        final_coefficient: |raw, i, set| (f64::from(raw) + bias(i, set)) * scale(i, set),
        ..r
    }),
    formula(
        "bias-ignored",
        "2.4/8",
        "does not use the biases",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| f64::from(raw) * scale(i, set),
            ..r
        },
    ),
    formula(
        "scale-ignored",
        "2.4/8",
        "does not use the scales",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| f64::from(raw) - bias(i, set),
            ..r
        },
    ),
    formula(
        "scale-divides",
        "2.4/8",
        "divides by the scale",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - bias(i, set)) / scale(i, set),
            ..r
        },
    ),
    formula(
        "bias-minus-raw",
        "2.4/8",
        "subtracts the raw value from the bias",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| (bias(i, set) - f64::from(raw)) * scale(i, set),
            ..r
        },
    ),
    formula(
        "bias-over-255",
        "2.4/8",
        "divides the bias by 255",
        "raw values and biases count alike, 0 to 255",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set) / 255.0) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "bias-over-256",
        "2.4/8",
        "divides raw values by 255 and the bias by 256",
        "divide both by the same number, or neither",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set) * 255.0 / 256.0) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "raw-over-255",
        "2.4/8",
        "takes raw values as 0 to 1 and biases as they are",
        "raw values and biases count alike",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) / 255.0 - bias(i, set)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "raw-signed",
        "2.4/1",
        "reads coefficients as signed bytes",
        "they are unsigned",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw.cast_signed()) - bias(i, set)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "coefficient-truncated",
        "2.4/8",
        "cuts final coefficients to whole numbers",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i, set).trunc(),
            ..r
        },
    ),
    formula(
        "coefficient-rounded",
        "2.4/8",
        "rounds final coefficients to whole numbers",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i, set).round(),
            ..r
        },
    ),
    formula(
        "coefficient-floored",
        "2.4/8",
        "rounds final coefficients down to whole numbers",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i, set).floor(),
            ..r
        },
    ),
    formula(
        "coefficient-not-negative",
        "2.4/8",
        "sets negative final coefficients to 0",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i, set).max(0.0),
            ..r
        },
    ),
    formula(
        "coefficient-at-most-255",
        "2.4/8",
        "cuts final coefficients off at 255",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i, set).min(255.0),
            ..r
        },
    ),
    formula(
        "coefficient-within-a-signed-byte",
        "2.4/8",
        "cuts final coefficients off at −128 and 127",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i, set).clamp(-128.0, 127.0),
            ..r
        },
    ),
    formula(
        "coefficient-in-16-bits",
        "2.4/8",
        "keeps final coefficients in 16 bit integers",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| f64::from(right(raw, i, set) as i64 as i16),
            ..r
        },
    ),
    formula(
        "difference-not-negative",
        "2.4/8",
        "sets raw − bias to 0 where it is negative",
        MEND,
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set)).max(0.0) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "difference-in-a-byte",
        "2.4/8",
        "computes raw − bias in a byte",
        "use integers with a sign",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                f64::from((i64::from(raw) - bias(i, set) as i64) as u8) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "bias-clamped",
        "2.4/4",
        "clamps biases to 0…255",
        "a bias is an integer of any sign",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set).clamp(0.0, 255.0)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "bias-not-negative",
        "2.4/4",
        "takes negative biases for 0",
        "a bias is an integer of any sign",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set).max(0.0)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "bias-at-most-255",
        "2.4/4",
        "takes biases above 255 for 255",
        "a bias is an integer of any size",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set).min(255.0)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "bias-sign-lost",
        "2.4/4",
        "ignores the sign of a bias",
        "a bias is an integer of any sign",
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - bias(i, set).abs()) * scale(i, set),
            ..r
        },
    ),
    formula(
        "bias-in-a-byte",
        "2.4/4",
        "keeps biases in unsigned bytes",
        "a bias is an integer of any sign",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - f64::from(bias(i, set) as i64 as u8)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "bias-in-a-signed-byte",
        "2.4/4",
        "keeps biases in signed bytes",
        "biases above 127 are common",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - f64::from(bias(i, set) as i64 as i8)) * scale(i, set)
            },
            ..r
        },
    ),
    formula(
        "scale-sign-lost",
        "2.4/3",
        "ignores the sign of a scale",
        "negative scales are legal",
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - bias(i, set)) * scale(i, set).abs(),
            ..r
        },
    ),
    formula(
        "zero-scale-is-one",
        "2.4/3",
        "takes a scale of 0 for 1",
        "a scale of zero is legal and makes the coefficient 0",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                let scale = if scale(i, set) == 0.0 {
                    1.0
                } else {
                    scale(i, set)
                };
                (f64::from(raw) - bias(i, set)) * scale
            },
            ..r
        },
    ),
    formula(
        "scale-with-three-decimals",
        "2.4/3",
        "keeps three decimals of a scale",
        "use the whole number",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                (f64::from(raw) - bias(i, set)) * (scale(i, set) * 1000.0).round() / 1000.0
            },
            ..r
        },
    ),
    formula(
        "one-scale-for-all",
        "2.4/2",
        "uses the first scale for all coefficients",
        "scale i belongs to coefficient i",
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - bias(i, set)) * set.scale[0],
            ..r
        },
    ),
    formula(
        "one-bias-for-all",
        "2.4/2",
        "uses the first bias for all coefficients",
        "bias i belongs to coefficient i",
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - set.bias[0]) * scale(i, set),
            ..r
        },
    ),
    formula(
        "scale-and-bias-reversed",
        "2.4/2",
        "takes scales and biases from the last coefficient to the first",
        "scale i belongs to coefficient i",
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, 5 - i % 6, set),
            ..r
        },
    ),
    formula(
        "scales-reversed",
        "2.4/2",
        "takes the scales from the last coefficient to the first",
        "scale i belongs to coefficient i",
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - bias(i, set)) * set.scale[5 - i % 6],
            ..r
        },
    ),
    formula(
        "bias-before-scale",
        "2.4/2",
        "takes the first six numbers for biases",
        "scales come first",
        |r| Reading {
            final_coefficient: |raw, i, set| (f64::from(raw) - scale(i, set)) * bias(i, set),
            ..r
        },
    ),
    formula(
        "scale-and-bias-alternate",
        "2.4/2",
        "takes the twelve numbers as pairs of scale and bias",
        "six scales, then six biases",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                let twelve: Vec<f64> = set.scale.iter().chain(&set.bias).copied().collect();
                (f64::from(raw) - twelve[i % 6 * 2 + 1]) * twelve[i % 6 * 2]
            },
            ..r
        },
    ),
    formula(
        "scale-per-channel",
        "2.4/9",
        "gives red, green and blue the first, second and third scale and bias",
        "one set of six serves all polynomials",
        |r| Reading {
            final_coefficient: |raw, i, set| right(raw, i / 6, set),
            ..r
        },
    ),
    formula(
        "only-red-is-scaled",
        "2.4/9",
        "uses scales and biases for the first polynomial only",
        "one set of six serves all polynomials",
        |r| Reading {
            final_coefficient: |raw, i, set| {
                if i < 6 {
                    right(raw, i, set)
                } else {
                    f64::from(raw)
                }
            },
            ..r
        },
    ),
    Misreading {
        slug: "colors-scaled",
        clause: "2.4/9",
        effect: "uses scales and biases for colors, Cr and Cb too",
        mend: "only coefficients have scale and bias",
        at: At::Reading(Decision::FinalOther, |r| Reading {
            final_other: right,
            ..r
        }),
    },
    Misreading {
        slug: "colors-from-0-to-1",
        clause: "2.4/9",
        effect: "gives colors, Cr and Cb from 0 to 1",
        mend: "they count from 0 to 255",
        at: At::Reading(Decision::FinalOther, |r| Reading {
            final_other: |raw, _, _| f64::from(raw) / 255.0,
            ..r
        }),
    },
];

fn right(raw: u8, i: usize, set: &ScaleBias) -> f64 {
    (f64::from(raw) - bias(i, set)) * scale(i, set)
}

fn scale(i: usize, set: &ScaleBias) -> f64 {
    set.scale[i % 6]
}

fn bias(i: usize, set: &ScaleBias) -> f64 {
    set.bias[i % 6]
}
