//! T.81 A.3.3: the inverse DCT of the Independent JPEG Group
//!
//! The standard does not specify the inverse transform exactly; it allows all transforms that are accurate enough. However, PTM
//! planes contain differences modulo 256, where an error of one turns 255 into 0. This implementation is therefore exact: it
//! is the integer transform "islow", which HP's encoder and nearly every decoder use (ruling `jpeg-samples`).
//!
//! Worked example: a block whose only coefficient is DC = 24.
//!
//! ```text
//! columns  (24 · 2¹³) >> 11 = 96 in each row of column 0
//! rows     (96 · 2¹³) >> 18 = 3
//! samples  3 + 128 = 131
//! ```
//!
//! Format notes
//! - The last step keeps ten bits of the result as a signed number, and clamps it. For streams from real encoders, this equals
//!   plain clamping, but coefficients far out of range wrap.

use super::dct::{EXTRA_BITS, FRACTION_BITS, FixedPoint};

/// Transforms DCT coefficients into samples. Both are in row order.
pub(super) fn inverse_dct(coefficients: &[i32; 64]) -> [u8; 64] {
    inverse_dct_with::<i64>(coefficients)
}

/// Transforms all columns, then all rows, with arithmetic of type `T`.
pub(super) fn inverse_dct_with<T: FixedPoint>(coefficients: &[i32; 64]) -> [u8; 64] {
    let mut intermediate = [T::from_i32(0); 64];
    for x in 0..8 {
        let column = std::array::from_fn(|y| T::from_i32(coefficients[8 * y + x]));
        for (y, value) in inverse_dct_of_8(column).into_iter().enumerate() {
            intermediate[8 * y + x] = value.round_shift(FRACTION_BITS - EXTRA_BITS);
        }
    }
    let mut samples = [0; 64];
    let rows = intermediate.chunks_exact(8);
    for (row, out) in rows.zip(samples.chunks_exact_mut(8)) {
        let row = inverse_dct_of_8(std::array::from_fn(|x| row[x]));
        for (sample, value) in out.iter_mut().zip(row) {
            // Shift by three more bits, because each pass multiplies by √8.
            *sample = to_sample(value.round_shift(FRACTION_BITS + EXTRA_BITS + 3).to_i32());
        }
    }
    samples
}

/// Adds the 128 that A.3.1 subtracts from every sample before the transform, and clamps to 0 … 255. Only ten bits of
/// the value are used (see the format notes).
#[inline]
fn to_sample(value: i32) -> u8 {
    let ten_bits = (value << 22) >> 22;
    (ten_bits + 128).clamp(0, 255) as u8
}

/// Computes the one-dimensional inverse transform, scaled by √8 · 2¹³.
#[inline]
fn inverse_dct_of_8<T: FixedPoint>(c: [T; 8]) -> [T; 8] {
    // Even coefficients: 0 and 4 need no factor, and 2 and 6 are rotated by 6π/16 with three multiplications.
    let rotation = (c[2] + c[6]).multiply(0.541_196_100);
    let low = rotation + c[2].multiply(0.765_366_865);
    let high = rotation - c[6].multiply(1.847_759_065);
    let (sum, difference) = ((c[0] + c[4]).multiply(1.0), (c[0] - c[4]).multiply(1.0));
    let even = [sum + low, difference + high, difference - high, sum - low];

    // Odd coefficients: four pairs of them share a product each, and all share one more.
    let shared = (c[7] + c[3] + c[5] + c[1]).multiply(1.175_875_602);
    let pair_71 = -(c[7] + c[1]).multiply(0.899_976_223);
    let pair_53 = -(c[5] + c[3]).multiply(2.562_915_447);
    let pair_73 = shared - (c[7] + c[3]).multiply(1.961_570_560);
    let pair_51 = shared - (c[5] + c[1]).multiply(0.390_180_644);
    let odd = [
        c[1].multiply(1.501_321_110) + pair_71 + pair_51,
        c[3].multiply(3.072_711_026) + pair_53 + pair_73,
        c[5].multiply(2.053_119_869) + pair_53 + pair_51,
        c[7].multiply(0.298_631_336) + pair_71 + pair_73,
    ];

    // The even part is symmetric about the middle, and the odd part changes its sign there.
    std::array::from_fn(|i| match i {
        0..=3 => even[i] + odd[i],
        _ => even[7 - i] - odd[7 - i],
    })
}
