//! T.81 A.3.3: the forward DCT of the Independent JPEG Group
//!
//! This is the mirror image of `inverse_dct`: it transforms all rows, then all columns, each by the transpose of the
//! one-dimensional inverse. The results are too large by a factor of eight, which the quantization removes.
//!
//! Worked example: 64 samples with the value 131, which is 3 above gray.
//!
//! ```text
//! rows     (8 · 3 · 2¹³) >> 11 = 96 in column 0 of each row
//! columns  (8 · 96 · 2¹³) >> 15 = 192 in row 0, which is 8 times DC = 24
//! ```
//!
//! Format notes
//! - No decoder depends on how the results are rounded, but only this rounding gives the same bytes as libjpeg.

use super::dct::{EXTRA_BITS, FRACTION_BITS, FixedPoint};

/// Transforms level-shifted samples into DCT coefficients that are multiplied by eight. Both are in row order.
pub(super) fn forward_dct(block: &[i32; 64]) -> [i32; 64] {
    let mut intermediate = [0; 64];
    for (row, out) in block.chunks_exact(8).zip(intermediate.chunks_exact_mut(8)) {
        let row = forward_dct_of_8(std::array::from_fn(|x| i64::from(row[x])));
        for (out, value) in out.iter_mut().zip(row) {
            *out = value.round_shift(FRACTION_BITS - EXTRA_BITS);
        }
    }
    let mut coefficients = [0; 64];
    for x in 0..8 {
        let column = std::array::from_fn(|y| intermediate[8 * y + x]);
        for (y, value) in forward_dct_of_8(column).into_iter().enumerate() {
            coefficients[8 * y + x] = value.round_shift(FRACTION_BITS + EXTRA_BITS).to_i32();
        }
    }
    coefficients
}

/// Computes the one-dimensional forward transform, scaled by √8 · 2¹³.
fn forward_dct_of_8(s: [i64; 8]) -> [i64; 8] {
    // The part that is symmetric about the middle determines the even coefficients, and the rest the odd ones. With four
    // sums and four differences, each half of the transform uses half of the values.
    let even = [s[0] + s[7], s[1] + s[6], s[2] + s[5], s[3] + s[4]];
    let odd = [s[0] - s[7], s[1] - s[6], s[2] - s[5], s[3] - s[4]];

    // Coefficients 0 and 4 need no factor. 2 and 6 are the inverse rotation of the inverse transform.
    let (outer, inner) = (even[0] + even[3], even[1] + even[2]);
    let (low, high) = (even[0] - even[3], even[1] - even[2]);
    let rotation = (low + high).multiply(0.541_196_100);

    // These are the products of the inverse transform, with sample indices instead of coefficient indices.
    let shared = (odd[0] + odd[1] + odd[2] + odd[3]).multiply(1.175_875_602);
    let pair_30 = -(odd[3] + odd[0]).multiply(0.899_976_223);
    let pair_21 = -(odd[2] + odd[1]).multiply(2.562_915_447);
    let pair_31 = shared - (odd[3] + odd[1]).multiply(1.961_570_560);
    let pair_20 = shared - (odd[2] + odd[0]).multiply(0.390_180_644);

    [
        (outer + inner).multiply(1.0),
        odd[0].multiply(1.501_321_110) + pair_30 + pair_20,
        rotation + low.multiply(0.765_366_865),
        odd[1].multiply(3.072_711_026) + pair_21 + pair_31,
        (outer - inner).multiply(1.0),
        odd[2].multiply(2.053_119_869) + pair_21 + pair_20,
        rotation - high.multiply(1.847_759_065),
        odd[3].multiply(0.298_631_336) + pair_30 + pair_31,
    ]
}
