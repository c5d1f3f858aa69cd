//! Final coefficients that are computed otherwise than (raw − bias) · scale, everywhere or under a condition.

use super::grid::{self, Places};
use super::variants::signed_byte;
use crate::ptm::{Planes, ScaleBias};

/// A stored value, its scale and its bias, and which of a0 … a5 it is.
#[derive(Clone, Copy)]
struct Numbers {
    raw: f64,
    scale: f64,
    bias: f64,
    place: usize,
}

impl Numbers {
    fn right(self) -> f64 {
        (self.raw - self.bias) * self.scale
    }
}

/// What is computed instead, in words and as a function.
type Rule = (&'static str, fn(Numbers) -> f64);

/// Of which coefficients, in words and as a predicate.
type Condition = (&'static str, fn(Numbers) -> bool);

/// Whether it is coefficient `K`.
const fn is<const K: usize>(n: Numbers) -> bool {
    n.place == K
}

/// Whether it is coefficient `K`, and its final value is negative.
fn is_negative<const K: usize>(n: Numbers) -> bool {
    n.place == K && n.right() < 0.0
}

const RULES: &[Rule] = &[
    ("raw · scale − bias", |n| n.raw * n.scale - n.bias),
    ("raw · scale + bias", |n| n.raw * n.scale + n.bias),
    ("(raw + bias) · scale", |n| (n.raw + n.bias) * n.scale),
    ("(bias − raw) · scale", |n| (n.bias - n.raw) * n.scale),
    ("raw · scale, without the bias", |n| n.raw * n.scale),
    ("raw − bias, without the scale", |n| n.raw - n.bias),
    ("the raw value, without scale and bias", |n| n.raw),
    ("(raw − bias) / scale", |n| (n.raw - n.bias) / n.scale),
    ("0", |_| 0.0),
    ("the scale", |n| n.scale),
    ("the bias", |n| n.bias),
    ("|raw − bias| · scale", |n| {
        (n.raw - n.bias).abs() * n.scale
    }),
    ("|(raw − bias) · scale|", |n| n.right().abs()),
    ("(raw − bias) · scale with the opposite sign", |n| {
        -n.right()
    }),
    ("(raw − |bias|) · scale", |n| {
        (n.raw - n.bias.abs()) * n.scale
    }),
    ("(raw − bias) · |scale|", |n| {
        (n.raw - n.bias) * n.scale.abs()
    }),
    ("(raw − bias + 256) · scale", |n| {
        (n.raw - n.bias + 256.0) * n.scale
    }),
    ("(raw − bias mod 256) · scale", |n| {
        (n.raw - n.bias.rem_euclid(256.0)) * n.scale
    }),
    ("(raw − bias) mod 256 · scale", |n| {
        (n.raw - n.bias).rem_euclid(256.0) * n.scale
    }),
    ("(raw − bias as a signed byte) · scale", |n| {
        f64::from((n.raw - n.bias) as i64 as i8) * n.scale
    }),
    ("(raw as a signed byte − bias) · scale", |n| {
        (signed_byte(n.raw) - n.bias) * n.scale
    }),
    ("(raw − bias, but 0 at the least,) · scale", |n| {
        (n.raw - n.bias).max(0.0) * n.scale
    }),
    ("(raw − bias, but 255 at the most,) · scale", |n| {
        (n.raw - n.bias).min(255.0) * n.scale
    }),
    ("(raw − bias, limited to 0…255,) · scale", |n| {
        (n.raw - n.bias).clamp(0.0, 255.0) * n.scale
    }),
    ("(raw − 255) · scale", |n| (n.raw - 255.0) * n.scale),
    ("(raw − 128) · scale", |n| (n.raw - 128.0) * n.scale),
    ("(raw − bias − 1) · scale", |n| {
        (n.raw - n.bias - 1.0) * n.scale
    }),
    ("(raw − bias + 0.5) · scale", |n| {
        (n.raw - n.bias + 0.5) * n.scale
    }),
    ("(raw − bias − 0.5) · scale", |n| {
        (n.raw - n.bias - 0.5) * n.scale
    }),
    ("(raw − bias) · scale rounded to eighths", |n| {
        (n.right() * 8.0).round() / 8.0
    }),
    (
        "(raw − bias) · scale rounded to multiples of 1/16",
        |n| (n.right() * 16.0).round() / 16.0,
    ),
    (
        "(raw − bias) · scale rounded to multiples of 1/256",
        |n| (n.right() * 256.0).round() / 256.0,
    ),
    ("(raw − bias) · scale cut to multiples of 1/256", |n| {
        (n.right() * 256.0).trunc() / 256.0
    }),
    ("(raw − bias) · scale cut to multiples of 1/16", |n| {
        (n.right() * 16.0).trunc() / 16.0
    }),
    ("(raw − bias) · scale cut to eighths", |n| {
        (n.right() * 8.0).trunc() / 8.0
    }),
    ("(raw − bias) · scale rounded to three decimals", |n| {
        (n.right() * 1000.0).round() / 1000.0
    }),
    ("(raw − bias) · scale rounded to two decimals", |n| {
        (n.right() * 100.0).round() / 100.0
    }),
    ("(raw − bias) · scale rounded to one decimal", |n| {
        (n.right() * 10.0).round() / 10.0
    }),
    ("(raw − bias) · scale, limited to ±3.4e38", |n| {
        n.right().clamp(f64::from(f32::MIN), f64::from(f32::MAX))
    }),
    ("(raw − bias + 1) · scale", |n| {
        (n.raw - n.bias + 1.0) * n.scale
    }),
    ("(raw − bias) · scale cut to a whole number", |n| {
        n.right().trunc()
    }),
    ("(raw − bias) · scale rounded to a whole number", |n| {
        n.right().round()
    }),
    (
        "(raw − bias) · scale rounded to a whole number, halves up",
        |n| (n.right() + 0.5).floor(),
    ),
    (
        "(raw − bias) · scale rounded to a whole number, halves to the even one",
        |n| n.right().round_ties_even(),
    ),
    (
        "(raw − bias) · scale plus 0.5, cut to a whole number",
        |n| (n.right() + 0.5).trunc(),
    ),
    ("(raw − bias) · scale rounded down", |n| {
        n.right().floor()
    }),
    ("(raw − bias) · scale, but 0 at the least", |n| {
        n.right().max(0.0)
    }),
    ("(raw − bias) · scale, but 255 at the most", |n| {
        n.right().min(255.0)
    }),
    ("(raw − bias) · scale, but 1 less", |n| n.right() - 1.0),
    ("(raw − bias) with the scale cut to a whole number", |n| {
        (n.raw - n.bias) * n.scale.trunc()
    }),
    ("(raw − bias) with the scale rounded up", |n| {
        (n.raw - n.bias) * n.scale.ceil()
    }),
    ("half of (raw − bias) · scale", |n| n.right() / 2.0),
    ("twice (raw − bias) · scale", |n| n.right() * 2.0),
    ("(raw − bias) · scale²", |n| n.right() * n.scale),
    ("(raw / 2 − bias) · scale", |n| {
        (n.raw / 2.0 - n.bias) * n.scale
    }),
];

const CONDITIONS: &[Condition] = &[
    ("", |_| true),
    ("whose bias is negative", |n| n.bias < 0.0),
    ("whose bias is over 127", |n| n.bias > 127.0),
    ("whose bias is over 255", |n| n.bias > 255.0),
    ("whose bias is 0", |n| n.bias == 0.0),
    ("whose bias is not 0", |n| n.bias != 0.0),
    ("whose bias is from 0 to 255", |n| {
        (0.0..=255.0).contains(&n.bias)
    }),
    ("whose bias is less than −128 or over 127", |n| {
        !(-128.0..=127.0).contains(&n.bias)
    }),
    ("whose raw value is less than the bias", |n| n.raw < n.bias),
    ("whose raw value is more than the bias", |n| n.raw > n.bias),
    ("whose raw value is 0", |n| n.raw == 0.0),
    ("whose raw value is 255", |n| n.raw == 255.0),
    ("whose raw value is over 127", |n| n.raw > 127.0),
    ("whose scale is negative", |n| n.scale < 0.0),
    ("whose scale is less than 1", |n| n.scale < 1.0),
    ("whose scale is between −1 and 1", |n| n.scale.abs() < 1.0),
    ("whose scale is over 1", |n| n.scale > 1.0),
    ("whose scale is 1", |n| n.scale == 1.0),
    ("whose final value is negative", |n| n.right() < 0.0),
    ("whose final value is over 255", |n| n.right() > 255.0),
    ("whose final value is between −1 and 0", |n| {
        n.right() > -1.0 && n.right() < 0.0
    }),
    ("whose final value is between −1 and 1", |n| {
        n.right().abs() < 1.0
    }),
    ("whose final value is between −0.001 and 0.001", |n| {
        n.right().abs() < 0.001
    }),
    ("that are a0", is::<0>),
    ("that are a1", is::<1>),
    ("that are a2", is::<2>),
    ("that are a3", is::<3>),
    ("that are a4", is::<4>),
    ("that are a5", is::<5>),
    ("that are a0 and negative", is_negative::<0>),
    ("that are a1 and negative", is_negative::<1>),
    ("that are a2 and negative", is_negative::<2>),
    ("that are a3 and negative", is_negative::<3>),
    ("that are a4 and negative", is_negative::<4>),
    ("that are a5 and negative", is_negative::<5>),
];

/// What raw value and bias are made to.
const SUMS: &[(&str, fn(f64, f64) -> f64)] = &[
    ("raw − bias", |raw, bias| raw - bias),
    ("raw + bias", |raw, bias| raw + bias),
    ("bias − raw", |raw, bias| bias - raw),
];

/// What becomes of that.
const LIMITS: &[(&str, fn(f64) -> f64)] = &[
    ("", |sum| sum),
    (", but 0 at the least,", |sum| sum.max(0.0)),
    (", but 255 at the most,", |sum| sum.min(255.0)),
    (", limited to 0…255,", |sum| sum.clamp(0.0, 255.0)),
    (" without its sign", f64::abs),
];

/// The coefficient whose scale or bias is taken.
const SOURCES: &[(&str, fn(usize) -> usize)] = &[
    ("", |k| k),
    (" of the next coefficient", |k| (k + 1) % 6),
    (" of the coefficient before", |k| (k + 5) % 6),
    (" of a0", |_| 0),
    (" of a5", |_| 5),
    (" of coefficient 5 − i", |k| 5 - k),
];

/// What is done with the scale.
const FACTORS: &[(&str, fn(f64, f64) -> f64)] = &[
    (" · the scale", |sum, scale| sum * scale),
    (" / the scale", |sum, scale| sum / scale),
    (" · the absolute scale", |sum, scale| sum * scale.abs()),
    (" + the scale", |sum, scale| sum + scale),
];

/// Another way to a final value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum FinalRule {
    /// One rule under one condition.
    Under { rule: usize, condition: usize },
    /// Several slips in one expression: places in [`SUMS`], [`LIMITS`], [`SOURCES`] of the bias, [`FACTORS`], and
    /// [`SOURCES`] of the scale.
    Combined(Places<5>),
    /// The same, scaled before the bias is taken: places in [`SUMS`], and in [`SOURCES`] of the bias and of the scale.
    ScaledFirst(Places<3>),
}

impl FinalRule {
    /// All of them.
    pub fn all() -> impl Iterator<Item = FinalRule> {
        let under = (0..CONDITIONS.len()).flat_map(|condition| {
            (0..RULES.len()).map(move |rule| FinalRule::Under { rule, condition })
        });
        let lengths = [
            SUMS.len(),
            LIMITS.len(),
            SOURCES.len(),
            FACTORS.len(),
            SOURCES.len(),
        ];
        let combined = grid::all(lengths).map(FinalRule::Combined);
        let scaled_first = [SUMS.len(), SOURCES.len(), SOURCES.len()];
        let scaled_first = grid::all(scaled_first).map(FinalRule::ScaledFirst);
        under.chain(combined).chain(scaled_first)
    }

    /// The final value of a coefficient of a polynomial; nothing where it is the right one.
    fn of(self, raw: f64, k: usize, set: &ScaleBias) -> Option<f64> {
        match self {
            FinalRule::Under { rule, condition } => {
                let numbers = Numbers {
                    raw,
                    scale: set.scale[k],
                    bias: set.bias[k],
                    place: k,
                };
                CONDITIONS[condition].1(numbers).then(|| RULES[rule].1(numbers))
            }
            FinalRule::Combined([sum, limit, bias, factor, scale]) => {
                let sum = SUMS[sum].1(raw, set.bias[SOURCES[bias].1(k)]);
                let scale = set.scale[SOURCES[scale].1(k)];
                Some(FACTORS[factor].1(LIMITS[limit].1(sum), scale))
            }
            FinalRule::ScaledFirst([sum, bias, scale]) => {
                let scaled = raw * set.scale[SOURCES[scale].1(k)];
                Some(SUMS[sum].1(scaled, set.bias[SOURCES[bias].1(k)]))
            }
        }
    }

    /// The final values with this rule, where it applies.
    pub fn apply(self, values: &mut [f64], planes: &Planes, set: &ScaleBias) {
        let (channels, coefficients) = (planes.shape.channels(), planes.shape.coefficients());
        for (i, (value, &raw)) in values.iter_mut().zip(&planes.samples).enumerate() {
            let channel = i % channels;
            if channel < coefficients
                && let Some(other) = self.of(f64::from(raw), channel % 6, set)
            {
                *value = other;
            }
        }
    }

    /// As a sentence without its subject.
    pub fn says(self) -> String {
        match self {
            FinalRule::Under { rule, condition } => {
                let of = match CONDITIONS[condition].0 {
                    "" => String::new(),
                    condition => format!(", for coefficients {condition}"),
                };
                format!("computes as final value {}{of}", RULES[rule].0)
            }
            FinalRule::Combined([sum, limit, bias, factor, scale]) => format!(
                "computes as final value i ({}{}{}){}{}",
                SUMS[sum].0, SOURCES[bias].0, LIMITS[limit].0, FACTORS[factor].0, SOURCES[scale].0
            ),
            FinalRule::ScaledFirst([sum, bias, scale]) => {
                let scaled = format!("raw · scale{}", SOURCES[scale].0);
                let bias = format!("bias{}", SOURCES[bias].0);
                let sum = SUMS[sum].0.replace("bias", &bias).replace("raw", &scaled);
                format!("computes as final value i {sum}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::diagnose::tests::first_cause;
    use crate::evaluate::final_coefficient;
    use crate::ptm::ScaleBias;
    use crate::reading::Reading;

    type Final = fn(u8, usize, &ScaleBias) -> f64;

    #[test]
    fn a_rule_is_told_with_its_condition_and_several_slips_as_one_expression() {
        let wrong: [(Final, &str); 3] = [
            (
                |raw, channel, set: &ScaleBias| match (
                    set.scale[channel % 6],
                    set.bias[channel % 6],
                ) {
                    (scale, bias) if bias < 0.0 => f64::from(raw) * scale - bias,
                    _ => final_coefficient(raw, channel, set),
                },
                "raw · scale − bias, for coefficients whose bias is negative",
            ),
            (
                |raw, channel, set: &ScaleBias| {
                    let sum = f64::from(raw) + set.bias[channel % 6];
                    sum.max(0.0) * set.scale[(channel + 1) % 6]
                },
                "(raw + bias, but 0 at the least,) · the scale of the next coefficient",
            ),
            (
                |raw, channel, set: &ScaleBias| {
                    let scaled = f64::from(raw) * set.scale[channel % 6];
                    scaled - set.bias[(channel + 1) % 6]
                },
                "final value i raw · scale − bias of the next coefficient",
            ),
        ];
        for (final_coefficient, says) in wrong {
            let reading = Reading {
                final_coefficient,
                ..Reading::SPEC
            };
            let told = first_cause(reading, |case| !case.format().is_compressed());
            assert!(told.contains(says), "{says}: {told}");
        }
    }
}
