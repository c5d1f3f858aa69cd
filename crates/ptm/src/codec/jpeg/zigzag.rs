//! T.81 A.3.6: the zigzag order of coefficients
//!
//! Coefficients are stored along the antidiagonals of the block, from low to high frequencies. After quantization, most zeros are
//! therefore at the end. Quantization tables are stored in the same order.
//!
//! ```text
//!  0  1  5  6 …
//!  2  4  7 …
//!  3  8 …
//!  9 …
//! ```

/// Row-order positions of the coefficients, in the order of the stream.
pub const ZIGZAG: [u8; 64] = [
    0, 1, 8, 16, 9, 2, 3, 10, //
    17, 24, 32, 25, 18, 11, 4, 5, //
    12, 19, 26, 33, 40, 48, 41, 34, //
    27, 20, 13, 6, 7, 14, 21, 28, //
    35, 42, 49, 56, 57, 50, 43, 36, //
    29, 22, 15, 23, 30, 37, 44, 51, //
    58, 59, 52, 45, 38, 31, 39, 46, //
    53, 60, 61, 54, 47, 55, 62, 63,
];
