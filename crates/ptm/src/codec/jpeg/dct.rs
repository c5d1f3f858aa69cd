//! T.81 A.3.3: the part shared by the forward and the inverse DCT
//!
//! The standard defines the transform in terms of cosines and does not specify its arithmetic. The integer arithmetic here is
//! that of the Independent JPEG Group's accurate transform ("islow"). It is based on the factorization of Loeffler, Ligtenberg
//! and Moschytz (ICASSP 1989), which needs twelve multiplications for eight values. Columns and rows are transformed separately.
//!
//! Numbers are fixed-point integers. Factors have `FRACTION_BITS` fractional bits, and values keep `EXTRA_BITS`
//! fractional bits between the two passes.
//!
//! This file, `inverse_dct` and `forward_dct` are based in part on the work of the Independent JPEG Group.

use std::ops::{Add, Neg, Sub};

/// Number of fractional bits in the factors, which are multiplied by 2¹³ and rounded.
pub(super) const FRACTION_BITS: u32 = 13;

/// Number of fractional bits that values keep between the two passes.
pub(super) const EXTRA_BITS: u32 = 2;

/// Fixed-point numbers, stored in integers of 64 or 32 bits.
///
/// 64 bits suffice for every stream. In 32 bits, sums and products may wrap.
pub(super) trait FixedPoint:
    Copy + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self>
{
    fn from_i32(value: i32) -> Self;

    /// Returns the low 32 bits.
    fn to_i32(self) -> i32;

    /// Multiplies by a factor, which is converted to fixed point: 0.541196100 becomes 4433.
    fn multiply(self, factor: f64) -> Self;

    /// Divides by 2^`bits`, with halves rounded up.
    fn round_shift(self, bits: u32) -> Self;
}

impl FixedPoint for i64 {
    fn from_i32(value: i32) -> i64 {
        i64::from(value)
    }

    fn to_i32(self) -> i32 {
        self as i32
    }

    #[inline]
    fn multiply(self, factor: f64) -> i64 {
        self * (factor * f64::from(1 << FRACTION_BITS) + 0.5) as i64
    }

    #[inline]
    fn round_shift(self, bits: u32) -> i64 {
        (self + (1 << (bits - 1))) >> bits
    }
}
