//! §2.9.2 – 2.9.5 Prediction of a plane from its reference
//!
//! The stream of a predicted plane contains *residuals*. The plane is residual + predictor − 128, modulo 256 (clause
//! 2.9.5/4, ruling `prediction`). The predictor is the reference, inverted (clause 2.9.2/3) and displaced (clause
//! 2.9.2/4) according to the transform of the plane.
//!
//! ```text
//! reference   10 21 30     inverted   245 234 225     displaced by (1, 0)   240 230 225
//! residual    128 0 100    plane = residual + predictor − 128               240 102 197
//! ```
//!
//! Format notes
//! - The text says only "modular arithmetic". The 128 and the inversion 255 − v were determined from HP's own file. All known
//!   decoders use the same values.
//! - No public file displaces a reference. Displacement involves five choices (rulings `motion-…`). Here, the
//!   predictor at (x, y) is the reference at (x + mx/2, y + my/2) in the *stored* raster, where row 0 is the bottom
//!   row of the image. Halves are rounded up, and samples outside the plane replicate its edge.
//! - Every plane has a vector, but the vector applies only if the transform has the bit of value 2.
//! - Both transforms apply to a copy of the reference, not to the residual or the result. The reference, which is
//!   also a plane in the file, does not change.

use std::borrow::Cow;

use super::displace;
use crate::parts::Step;
use crate::reading::Reading;
use crate::types::{Coding, Size};

/// Turns the residuals of a plane into its samples, in place.
pub fn predict_plane(
    coding: Coding,
    residuals: &mut [u8],
    reference: &[u8],
    step: &Step,
    size: Size,
    reading: &Reading,
) {
    let predictor = (reading.predictor)(reference, step, size, reading);
    match coding {
        Coding::Jpeg => (reading.predict)(residuals, &predictor),
        Coding::JpegLs => (reading.predict_jpeg_ls)(residuals, &predictor),
    }
}

/// Returns the reference, first inverted and then displaced (clauses 2.9.2/1, 2.9.2/6, ruling `motion-inversion`).
#[must_use]
pub fn invert_then_displace<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
) -> Cow<'a, [u8]> {
    let mut predictor = Cow::Borrowed(reference);
    if step.inverted {
        (reading.invert)(predictor.to_mut());
    }
    if step.displaced {
        predictor = Cow::Owned(displace_plane(&predictor, size, step.motion, reading));
    }
    predictor
}

/// Returns the reference, first displaced and then inverted (alternative to ruling `motion-inversion`).
#[must_use]
pub fn displace_then_invert<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
) -> Cow<'a, [u8]> {
    let mut predictor = Cow::Borrowed(reference);
    if step.displaced {
        predictor = Cow::Owned(displace_plane(&predictor, size, step.motion, reading));
    }
    if step.inverted {
        (reading.invert)(predictor.to_mut());
    }
    predictor
}

/// Replaces each value v with 255 − v (clause 2.9.2/3).
pub fn invert(plane: &mut [u8]) {
    for value in plane {
        *value = 255 - *value;
    }
}

/// Computes residual + predictor − 128, modulo 256, for JPEG planes (clause 2.9.5/4) and for JPEG-LS planes (clause
/// 2.9.5/5, ruling `jpeg-ls-offset`).
pub fn predict(residuals: &mut [u8], predictor: &[u8]) {
    for (value, &predicted) in residuals.iter_mut().zip(predictor) {
        *value = value.wrapping_add(predicted).wrapping_sub(128);
    }
}

/// Computes residual + predictor, modulo 256, for JPEG-LS planes (alternative to ruling `jpeg-ls-offset`).
pub fn predict_without_offset(residuals: &mut [u8], predictor: &[u8]) {
    for (value, &predicted) in residuals.iter_mut().zip(predictor) {
        *value = value.wrapping_add(predicted);
    }
}

/// Displaces a plane by half the vector: the value at (x, y) is the input at (x + mx/2, y + my/2) (clause 2.9.3/2).
#[must_use]
pub fn displace_plane(
    plane: &[u8],
    size: Size,
    (mx, my): (i64, i64),
    reading: &Reading,
) -> Vec<u8> {
    let mx = (reading.motion_sign)(mx);
    let my = (reading.motion_sign)((reading.motion_vertical)(my));
    // `displace_rows` is a faster version of a loop over all rows and columns.
    displace::displace_rows(plane, size, (mx, my), reading.motion_half, |x, y| {
        // Coordinates are doubled so that half texels are integers. A vector may point far outside the plane.
        let (x2, y2) = (mx.saturating_add(2 * x), my.saturating_add(2 * y));
        half_texel_sample(plane, size, x2, y2, reading)
    })
}

/// Returns the sample at a position in half texels: a single texel, or the mean of two or four (clause 2.9.3/5).
fn half_texel_sample(plane: &[u8], size: Size, x2: i64, y2: i64, reading: &Reading) -> u8 {
    // A half position is between a texel and the next one, even for negative coordinates: −1/2 is between −1 and 0.
    let (left, first) = (x2.div_euclid(2), y2.div_euclid(2));
    let (right, second) = (left + x2.rem_euclid(2), first + y2.rem_euclid(2));
    // If a coordinate is an integer, two or all of the four samples are the same texel.
    let corners = [
        (left, first),
        (right, first),
        (left, second),
        (right, second),
    ];
    (reading.motion_half)(corners.map(|(x, y)| (reading.motion_border)(plane, size, x, y)))
}

/// Returns the displacement of a predictor if vectors point from the texel to its predictor (clause 2.9.3/3, ruling `motion-sign`).
#[must_use]
pub fn texel_to_predictor(displacement: i64) -> i64 {
    displacement
}

/// Returns the displacement of a predictor if vectors point from the predictor to the texel (alternative to ruling `motion-sign`).
#[must_use]
pub fn predictor_to_texel(displacement: i64) -> i64 {
    displacement.saturating_neg()
}

/// Returns the displacement if y increases in the order of stored rows (clause 2.9.3/4, ruling `motion-vertical`).
#[must_use]
pub fn y_along_stored_rows(my: i64) -> i64 {
    my
}

/// Returns the displacement if y increases downward in the image (alternative to ruling `motion-vertical`).
#[must_use]
pub fn y_against_stored_rows(my: i64) -> i64 {
    my.saturating_neg()
}

/// Returns the mean of four samples, with halves rounded up (clause 2.9.3/5, ruling `motion-half`). For two equal
/// pairs this is (a + b + 1) >> 1, and for four equal samples the sample itself.
#[must_use]
pub fn mean_rounded_up(samples: [u8; 4]) -> u8 {
    ((sum(samples) + 2) >> 2) as u8
}

/// Returns the mean of four samples, with halves rounded down (alternative to ruling `motion-half`).
#[must_use]
pub fn mean_rounded_down(samples: [u8; 4]) -> u8 {
    (sum(samples) >> 2) as u8
}

/// Returns the mean of four samples, rounded to the nearest integer, and halves to the even one (alternative to ruling
/// `motion-half`).
#[must_use]
pub fn mean_rounded_to_even(samples: [u8; 4]) -> u8 {
    (f64::from(sum(samples)) / 4.0).round_ties_even() as u8
}

/// Returns the mean of the means of the first two and of the last two samples, each rounded up (alternative to ruling
/// `motion-half`).
#[must_use]
pub fn mean_rounded_up_twice([a, b, c, d]: [u8; 4]) -> u8 {
    let mean = |a: u8, b: u8| ((u16::from(a) + u16::from(b) + 1) >> 1) as u8;
    mean(mean(a, b), mean(c, d))
}

fn sum(samples: [u8; 4]) -> u16 {
    samples.into_iter().map(u16::from).sum()
}

/// Returns the sample at a position, or the nearest edge sample if it is outside the plane (clause 2.9.3/6, ruling
/// `motion-border`).
#[must_use]
pub fn replicate_border(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    plane[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
}

/// Returns the sample at a position, which wraps around at the edges of the plane (alternative to ruling `motion-border`).
#[must_use]
pub fn wrap_border(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    plane[(y.rem_euclid(height) * width + x.rem_euclid(width)) as usize]
}

/// Returns the sample at a position. Outside, the plane is mirrored, and its edge sample is repeated: b a | a b (alternative to
/// ruling `motion-border`).
#[must_use]
pub fn mirror_border(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let mirror = |position: i64, length: u32| {
        let period = 2 * i64::from(length);
        let position = position.rem_euclid(period);
        position.min(period - 1 - position)
    };
    let (x, y) = (mirror(x, size.width), mirror(y, size.height));
    plane[(y * i64::from(size.width) + x) as usize]
}

/// Returns the sample at a position, or 128 if it is outside the plane (alternative to ruling `motion-border`).
#[must_use]
pub fn gray_border(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    sample_inside(plane, size, x, y).unwrap_or(128)
}

/// Returns the sample at a position, or 0 if it is outside the plane (alternative to ruling `motion-border`).
#[must_use]
pub fn black_border(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    sample_inside(plane, size, x, y).unwrap_or(0)
}

fn sample_inside(plane: &[u8], size: Size, x: i64, y: i64) -> Option<u8> {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
    is_inside.then(|| plane[(y * width + x) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    type Change = fn(&mut Reading);
    const REFERENCE: Change = |_| {};
    const ROUNDED_DOWN: Change = |r| r.motion_half = mean_rounded_down;
    const ROUNDED_TO_EVEN: Change = |r| r.motion_half = mean_rounded_to_even;
    const ROUNDED_UP_TWICE: Change = |r| r.motion_half = mean_rounded_up_twice;
    const REVERSED: Change = |r| r.motion_sign = predictor_to_texel;
    const AGAINST_ROWS: Change = |r| r.motion_vertical = y_against_stored_rows;
    const WRAPPED: Change = |r| r.motion_border = wrap_border;
    const MIRRORED: Change = |r| r.motion_border = mirror_border;
    const GRAY: Change = |r| r.motion_border = gray_border;
    const BLACK: Change = |r| r.motion_border = black_border;

    /// Reading, width, vector, and the displaced plane for the input 10, 21, 30, 40. The corpus has more tests of the
    /// reference's reading.
    const DISPLACED: [(Change, u32, i64, i64, [u8; 4]); 15] = [
        (REFERENCE, 4, 1, 0, [16, 26, 35, 40]),
        (ROUNDED_DOWN, 4, 1, 0, [15, 25, 35, 40]),
        (REVERSED, 4, 2, 0, [10, 10, 21, 30]),
        (AGAINST_ROWS, 1, 0, 2, [10, 10, 21, 30]),
        (AGAINST_ROWS, 4, 2, 0, [21, 30, 40, 40]),
        (WRAPPED, 4, 2, 0, [21, 30, 40, 10]),
        (GRAY, 4, 2, 0, [21, 30, 40, 128]),
        (GRAY, 4, 1, 0, [16, 26, 35, 84]),
        (BLACK, 4, 1, 0, [16, 26, 35, 20]),
        (MIRRORED, 4, 6, 0, [40, 40, 30, 21]),
        (MIRRORED, 1, 0, -4, [21, 10, 10, 21]),
        (ROUNDED_TO_EVEN, 4, 1, 0, [16, 26, 35, 40]),
        // The only mean of four is that of 10, 21, 30 and 40: 25.25. The means along x are 16 and 35.
        (REFERENCE, 2, 1, 1, [25, 31, 35, 40]),
        (ROUNDED_UP_TWICE, 2, 1, 1, [26, 31, 35, 40]),
        (ROUNDED_TO_EVEN, 2, 1, 1, [25, 30, 35, 40]),
    ];

    #[test]
    fn motion_readings_give_different_planes() {
        for (i, (change, width, mx, my, expected)) in DISPLACED.into_iter().enumerate() {
            let mut reading = Reading::SPEC;
            change(&mut reading);
            let height = 4 / width;
            let (size, plane) = (Size { width, height }, [10, 21, 30, 40]);
            assert_eq!(
                displace_plane(&plane, size, (mx, my), &reading),
                expected,
                "{i}"
            );
            for far in [i64::MIN, -1_000_001, 1_000_001, i64::MAX] {
                assert_eq!(displace_plane(&plane, size, (far, far), &reading).len(), 4);
            }
        }
    }

    #[test]
    fn prediction_readings_give_different_planes() {
        let predicted = |reading: Reading, coding| {
            let step = Step {
                reference: Some(0),
                inverted: true,
                displaced: true,
                motion: (1, 0),
            };
            let mut plane = [140, 140];
            let size = "2x1".parse().expect("a size");
            predict_plane(coding, &mut plane, &[10, 21], &step, size, &reading);
            plane
        };
        // 245 and 234: (245 + 234 + 1) >> 1 = 240. After motion: 255 − 16 = 239.
        assert_eq!(predicted(Reading::SPEC, Coding::JpegLs), [252, 246]);
        let after = Reading {
            predictor: displace_then_invert,
            ..Reading::SPEC
        };
        assert_eq!(predicted(after, Coding::JpegLs), [251, 246]);
        let without = Reading {
            predict_jpeg_ls: predict_without_offset,
            ..Reading::SPEC
        };
        assert_eq!(predicted(without, Coding::JpegLs), [124, 118]);
        assert_eq!(predicted(without, Coding::Jpeg), [252, 246]);
    }
}
