//! T.81 A.3.4, K.1: quantization of coefficients
//!
//! A coefficient is divided by its quantization step and rounded. This is the lossy step of JPEG. The steps of Annex K
//! correspond to quality 50. Other qualities scale them by a percentage. The scaling is a convention of the Independent JPEG
//! Group, not part of the standard.
//!
//! Worked example: the DC step is 16 at quality 50.
//!
//! ```text
//! quality   10    50   75   90   100
//! percent  500   100   50   20     0
//! DC step   80    16    8    3     1
//! ```
//!
//! Format notes
//! - Blocks that extend past the image are padded with its last column and row (A.2.4).
//! - Halves are rounded away from zero.

use super::{forward_dct::forward_dct, inverse_dct::inverse_dct, zigzag::ZIGZAG};

/// Quantization steps for luminance at quality 50, in row order (Table K.1).
#[rustfmt::skip]
const LUMINANCE_STEPS: [u32; 64] = [
    16, 11, 10, 16,  24,  40,  51,  61,
    12, 12, 14, 19,  26,  58,  60,  55,
    14, 13, 16, 24,  40,  57,  69,  56,
    14, 17, 22, 29,  51,  87,  80,  62,
    18, 22, 37, 56,  68, 109, 103,  77,
    24, 35, 55, 64,  81, 104, 113,  92,
    49, 64, 78, 87, 103, 121, 120, 101,
    72, 92, 95, 98, 112, 100, 103,  99,
];

/// Returns the quantization steps for a quality (1 … 100), in row order.
#[must_use]
pub fn scaled_steps(quality: u8, baseline: bool) -> [u16; 64] {
    let percent = match u32::from(quality) {
        quality @ ..50 => 5000 / quality,
        quality => 200 - 2 * quality,
    };
    let largest = if baseline { 255 } else { 32767 };
    LUMINANCE_STEPS.map(|step| ((step * percent + 50) / 100).clamp(1, largest) as u16)
}

/// Returns the blocks in raster order, with quantized coefficients in zigzag order. Also returns the samples that a decoder
/// reconstructs from the blocks.
pub(super) fn quantize_image(
    samples: &[u8],
    width: usize,
    height: usize,
    steps: &[u16; 64],
) -> (Vec<[i16; 64]>, Vec<u8>) {
    let mut blocks = Vec::new();
    let mut decoded = vec![0; samples.len()];
    for top in (0..height).step_by(8) {
        for left in (0..width).step_by(8) {
            let block = std::array::from_fn(|i| {
                let (x, y) = ((left + i % 8).min(width - 1), (top + i / 8).min(height - 1));
                i32::from(samples[y * width + x]) - 128 // A.3.1
            });
            let coefficients = forward_dct(&block);
            let quantized: [i32; 64] = std::array::from_fn(|i| quantize(coefficients[i], steps[i]));
            blocks.push(ZIGZAG.map(|i| quantized[usize::from(i)] as i16));

            let dequantized = std::array::from_fn(|i| quantized[i] * i32::from(steps[i]));
            let reconstructed = inverse_dct(&dequantized);
            let visible = (width - left).min(8);
            for y in top..(top + 8).min(height) {
                let row = &reconstructed[8 * (y - top)..][..visible];
                decoded[y * width + left..][..visible].copy_from_slice(row);
            }
        }
    }
    (blocks, decoded)
}

/// Quantizes a coefficient (A.3.4). Removes the factor of eight that the forward DCT leaves.
fn quantize(coefficient: i32, step: u16) -> i32 {
    let step = i32::from(step) * 8;
    (coefficient.abs() + step / 2) / step * coefficient.signum()
}
