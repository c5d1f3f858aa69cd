//! Half precision: the 16-bit floating-point numbers of IEEE 754, which graphics processors and image formats use.

use std::ops::{Add, Div, Mul, Sub};

/// The largest finite half-precision number.
const LARGEST: f64 = 65504.0;

/// Exponent of the smallest normal number. Smaller numbers have the same spacing.
const SMALLEST_EXPONENT: i32 = -14;

/// Number of bits after the leading bit of a number.
const FRACTION_BITS: i32 = 10;

/// Rounds to the nearest half-precision number, and to the even one of two equally close ones. Numbers from 65,520 become
/// infinite.
pub fn round_to_half(value: f64) -> f64 {
    if !value.is_finite() {
        return value;
    }
    let exponent = exponent(value).max(SMALLEST_EXPONENT);
    let spacing = 2.0_f64.powi(exponent - FRACTION_BITS);
    let rounded = (value / spacing).round_ties_even() * spacing;
    if rounded.abs() > LARGEST {
        f64::INFINITY.copysign(value)
    } else {
        rounded
    }
}

/// A half-precision number. Each operation is rounded.
#[derive(Clone, Copy, Debug)]
pub struct Half(f64);

impl Half {
    pub fn new(value: f64) -> Half {
        Half(round_to_half(value))
    }

    pub fn value(self) -> f64 {
        self.0
    }
}

impl Add for Half {
    type Output = Half;

    fn add(self, other: Half) -> Half {
        Half::new(self.0 + other.0)
    }
}

impl Sub for Half {
    type Output = Half;

    fn sub(self, other: Half) -> Half {
        Half::new(self.0 - other.0)
    }
}

impl Mul for Half {
    type Output = Half;

    fn mul(self, other: Half) -> Half {
        Half::new(self.0 * other.0)
    }
}

impl Div for Half {
    type Output = Half;

    fn div(self, other: Half) -> Half {
        Half::new(self.0 / other.0)
    }
}

/// Returns the exponent of the leading bit of a normal number, and a small number for 0 and subnormal ones.
fn exponent(value: f64) -> i32 {
    let biased = value.to_bits() >> 52 & 0x7FF;
    biased as i32 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values with the bits of the half-precision number to which they are rounded.
    const KNOWN: [(f64, u16); 24] = [
        (0.0, 0x0000),
        (-0.0, 0x8000),
        (1.0, 0x3C00),
        (-2.0, 0xC000),
        (0.1, 0x2E66),
        (1.0 / 3.0, 0x3555),
        (255.0, 0x5BF8),
        // Integers are exact up to 2048; then a tie goes to the even neighbor.
        (2048.0, 0x6800),
        (2049.0, 0x6800),
        (2051.0, 0x6802),
        (2049.0001, 0x6801),
        (1.0 + 1.0 / 2048.0, 0x3C00),
        (1.0 + 3.0 / 2048.0, 0x3C02),
        // A number just below a power of two is rounded to it.
        (0.999_99, 0x3C00),
        // Subnormal numbers are multiples of 2^-24; the largest is 1023 of these units.
        (6.103_515_625e-5, 0x0400),
        (6.097_555_160_522_461e-5, 0x03FF),
        (5.960_464_477_539_063e-8, 0x0001),
        (2.980_232_238_769_531_3e-8, 0x0000),
        (2.980_232_3e-8, 0x0001),
        (5e-324, 0x0000),
        (65504.0, 0x7BFF),
        (65519.999, 0x7BFF),
        (65520.0, 0x7C00),
        (-1e300, 0xFC00),
    ];

    /// Returns the number with these bits.
    fn from_bits(bits: u16) -> f64 {
        let fraction = f64::from(bits & 0x3FF);
        let magnitude = match i32::from(bits >> 10 & 31) {
            0 => fraction * 2.0_f64.powi(-24),
            31 if fraction == 0.0 => f64::INFINITY,
            31 => f64::NAN,
            exponent => (1024.0 + fraction) * 2.0_f64.powi(exponent - 25),
        };
        magnitude.copysign(if bits >> 15 == 0 { 1.0 } else { -1.0 })
    }

    #[test]
    fn known_values_are_rounded() {
        for (value, bits) in KNOWN {
            let rounded = round_to_half(value);
            assert_eq!(rounded.to_bits(), from_bits(bits).to_bits(), "{value}");
        }
        assert!(round_to_half(f64::NAN).is_nan());
    }

    #[test]
    fn half_precision_numbers_are_unchanged_and_nearest() {
        // All finite positive numbers, in order, and the number at which infinity begins.
        let numbers: Vec<f64> = (0..0x7C00).map(from_bits).chain([65536.0]).collect();
        for pair in numbers.windows(2) {
            let (lower, upper) = (pair[0], pair[1]);
            let infinite = if upper > LARGEST {
                f64::INFINITY
            } else {
                upper
            };
            let middle = f64::midpoint(lower, upper);
            assert_eq!(round_to_half(lower), lower);
            assert_eq!(round_to_half(middle.next_down()), lower);
            assert_eq!(round_to_half(middle.next_up()), infinite);
        }
    }
}
