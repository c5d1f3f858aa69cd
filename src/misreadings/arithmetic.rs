//! §2.4 Scale and Bias: the formula

use super::at::At;
use crate::ptm::{Planes, ScaleBias};
use crate::reading::Reading;

pub(super) const ACTS: &[(&str, At)] = &[
    (
        "scale-then-bias",
        At::FinalCoefficient(|raw, i, set| f64::from(raw) * scale(i, set) - bias(i, set)),
    ),
    (
        "bias-added",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) + bias(i, set)) * scale(i, set)),
    ),
    (
        "bias-ignored",
        At::FinalCoefficient(|raw, i, set| f64::from(raw) * scale(i, set)),
    ),
    (
        "scale-ignored",
        At::FinalCoefficient(|raw, i, set| f64::from(raw) - bias(i, set)),
    ),
    (
        "scale-divides",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - bias(i, set)) / scale(i, set)),
    ),
    (
        "bias-minus-raw",
        At::FinalCoefficient(|raw, i, set| (bias(i, set) - f64::from(raw)) * scale(i, set)),
    ),
    (
        "bias-over-255",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - bias(i, set) / 255.0) * scale(i, set)),
    ),
    (
        "bias-over-256",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - bias(i, set) * 255.0 / 256.0) * scale(i, set)
        }),
    ),
    (
        "raw-over-255",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) / 255.0 - bias(i, set)) * scale(i, set)),
    ),
    (
        "raw-signed",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw.cast_signed()) - bias(i, set)) * scale(i, set)
        }),
    ),
    (
        "coefficient-truncated",
        At::FinalCoefficient(|raw, i, set| right(raw, i, set).trunc()),
    ),
    (
        "coefficient-rounded",
        At::FinalCoefficient(|raw, i, set| right(raw, i, set).round()),
    ),
    (
        "coefficient-floored",
        At::FinalCoefficient(|raw, i, set| right(raw, i, set).floor()),
    ),
    (
        "coefficient-not-negative",
        At::FinalCoefficient(|raw, i, set| right(raw, i, set).max(0.0)),
    ),
    (
        "coefficient-at-most-255",
        At::FinalCoefficient(|raw, i, set| right(raw, i, set).min(255.0)),
    ),
    (
        "coefficient-within-a-signed-byte",
        At::FinalCoefficient(|raw, i, set| right(raw, i, set).clamp(-128.0, 127.0)),
    ),
    (
        "coefficient-in-16-bits",
        At::FinalCoefficient(|raw, i, set| f64::from(right(raw, i, set) as i64 as i16)),
    ),
    (
        "difference-not-negative",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - bias(i, set)).max(0.0) * scale(i, set)
        }),
    ),
    (
        "difference-in-a-byte",
        At::FinalCoefficient(|raw, i, set| {
            f64::from(i64::from(raw).wrapping_sub(bias(i, set) as i64) as u8) * scale(i, set)
        }),
    ),
    (
        "bias-clamped",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - bias(i, set).clamp(0.0, 255.0)) * scale(i, set)
        }),
    ),
    (
        "bias-not-negative",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - bias(i, set).max(0.0)) * scale(i, set)
        }),
    ),
    (
        "bias-at-most-255",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - bias(i, set).min(255.0)) * scale(i, set)
        }),
    ),
    (
        "bias-sign-lost",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - bias(i, set).abs()) * scale(i, set)),
    ),
    (
        "bias-in-a-byte",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - f64::from(bias(i, set) as i64 as u8)) * scale(i, set)
        }),
    ),
    (
        "bias-in-a-signed-byte",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - f64::from(bias(i, set) as i64 as i8)) * scale(i, set)
        }),
    ),
    (
        "scale-sign-lost",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - bias(i, set)) * scale(i, set).abs()),
    ),
    (
        "zero-scale-is-one",
        At::FinalCoefficient(|raw, i, set| {
            let scale = if scale(i, set) == 0.0 {
                1.0
            } else {
                scale(i, set)
            };
            (f64::from(raw) - bias(i, set)) * scale
        }),
    ),
    (
        "scale-with-three-decimals",
        At::FinalCoefficient(|raw, i, set| {
            (f64::from(raw) - bias(i, set)) * (scale(i, set) * 1000.0).round() / 1000.0
        }),
    ),
    (
        "one-scale-for-all",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - bias(i, set)) * set.scale[0]),
    ),
    (
        "one-bias-for-all",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - set.bias[0]) * scale(i, set)),
    ),
    (
        "scale-and-bias-reversed",
        At::FinalCoefficient(|raw, i, set| right(raw, 5 - i % 6, set)),
    ),
    (
        "scales-reversed",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - bias(i, set)) * set.scale[5 - i % 6]),
    ),
    (
        "bias-before-scale",
        At::FinalCoefficient(|raw, i, set| (f64::from(raw) - scale(i, set)) * bias(i, set)),
    ),
    (
        "scale-and-bias-alternate",
        At::FinalCoefficient(|raw, i, set| {
            let twelve: Vec<f64> = set.scale.iter().chain(&set.bias).copied().collect();
            (f64::from(raw) - twelve[i % 6 * 2 + 1]) * twelve[i % 6 * 2]
        }),
    ),
    (
        "scale-per-channel",
        At::FinalCoefficient(|raw, i, set| right(raw, i / 6, set)),
    ),
    (
        "only-red-is-scaled",
        At::FinalCoefficient(|raw, i, set| {
            if i < 6 {
                right(raw, i, set)
            } else {
                f64::from(raw)
            }
        }),
    ),
    (
        "colors-scaled",
        At::Finals(|set, planes, reading| other_finals(set, planes, reading, right)),
    ),
    (
        "colors-from-0-to-1",
        At::Finals(|set, planes, reading| {
            other_finals(set, planes, reading, |raw, _, _| f64::from(raw) / 255.0)
        }),
    ),
];

/// Final values, of which colors, Cr and Cb are made by `other`.
fn other_finals(
    set: &ScaleBias,
    planes: &Planes,
    reading: &Reading,
    other: fn(u8, usize, &ScaleBias) -> f64,
) -> Vec<f64> {
    let channels = planes.shape.channels();
    let value = |(i, &raw): (usize, &u8)| match i % channels {
        i if i < planes.shape.coefficients() => (reading.final_coefficient)(raw, i, set),
        i => other(raw, i, set),
    };
    planes.samples.iter().enumerate().map(value).collect()
}

fn right(raw: u8, i: usize, set: &ScaleBias) -> f64 {
    (f64::from(raw) - bias(i, set)) * scale(i, set)
}

fn scale(i: usize, set: &ScaleBias) -> f64 {
    set.scale[i % 6]
}

fn bias(i: usize, set: &ScaleBias) -> f64 {
    set.bias[i % 6]
}
