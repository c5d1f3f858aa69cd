//! Fast inverse DCT in 32 bits
//!
//! A SIMD register holds twice as many 32-bit integers as 64-bit integers. Only ten bits of the results of the second pass are
//! used, starting at bit 18, and these are not affected when sums and products wrap. The first pass must not wrap, because all
//! bits of its results are used. It does not wrap if coefficients have at most 14 bits, as in the output of all encoders. Other
//! blocks are delegated to the plain version.

use std::num::Wrapping;

use super::dct::{FRACTION_BITS, FixedPoint};
use super::inverse_dct::{inverse_dct, inverse_dct_with};

/// Computes the same result as [`inverse_dct`].
pub(super) fn fast_inverse_dct(coefficients: &[i32; 64]) -> [u8; 64] {
    let limit = 1 << 13;
    let narrow = coefficients.iter().all(|c| (-limit..limit).contains(c));
    match narrow {
        true => inverse_dct_with::<Wrapping<i32>>(coefficients),
        false => inverse_dct(coefficients),
    }
}

impl FixedPoint for Wrapping<i32> {
    fn from_i32(value: i32) -> Self {
        Wrapping(value)
    }

    fn to_i32(self) -> i32 {
        self.0
    }

    #[inline]
    fn multiply(self, factor: f64) -> Self {
        self * Wrapping((factor * f64::from(1 << FRACTION_BITS) + 0.5) as i32)
    }

    #[inline]
    fn round_shift(self, bits: u32) -> Self {
        Wrapping((self + Wrapping(1 << (bits - 1))).0 >> bits)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::inverse_dct::inverse_dct;
    use super::fast_inverse_dct;

    proptest! {
        #[test]
        fn narrow_dct_equals_plain_dct(
            bits in 1_u32..=27,
            values in prop::collection::vec(any::<i32>(), 64),
        ) {
            let coefficients = std::array::from_fn(|i| values[i] >> (32 - bits));
            prop_assert_eq!(fast_inverse_dct(&coefficients), inverse_dct(&coefficients));
        }
    }
}
