//! §2.9.2 – 2.9.5 applied: a plane from its reference
//!
//! The stream of a predicted plane holds *residuals*. The plane is residual + predictor − 128,
//! modulo 256 (clause 2.9.5/4, ruling `prediction`); the predictor is the reference, inverted
//! (clause 2.9.2/3) and displaced (clause 2.9.2/4) as the plane's transform says.
//!
//! ```text
//! reference   10 21 30     inverted   245 234 225     and moved by (1, 0)   240 230 225
//! residual    128 0 100    plane = residual + predictor − 128               240 102 197
//! ```
//!
//! Format notes
//! - The text says "modular arithmetic" and no more. The 128 and the inversion 255 − v were measured on HP's own file, and
//!   every reader agrees.
//! - No public file displaces a reference. The reading here is the first of five choices (rulings `motion-…`): the
//!   predictor at (x, y) is the reference at (x + mx/2, y + my/2) in the *stored* raster, where row 0 is the bottom row of
//!   the image; halves are rounded up, and outside the plane its edge is replicated.
//! - The list has a vector for every plane. It counts only if the transform has bit 2.
//! - Both transforms act on the reference, not on the residual and not on the result. The reference itself, which is also
//!   a plane of the file, is not changed.

use std::borrow::Cow;

use super::inside;
use crate::parts::Step;
use crate::ptm::{Format, Size};
use crate::reading::Reading;

/// Turns residuals into the plane, in place.
pub(crate) fn apply(
    format: Format,
    residuals: &mut [u8],
    reference: &[u8],
    step: &Step,
    size: Size,
    reading: &Reading,
) {
    let predictor = (reading.predictor)(reference, step, size, reading);
    if format.is_jpeg_ls() {
        (reading.predict_jpeg_ls)(residuals, &predictor);
    } else {
        (reading.predict)(residuals, &predictor);
    }
}

/// Returns the reference, inverted and then displaced (clauses 2.9.2/1, 2.9.2/6, ruling `motion-inversion`).
pub(crate) fn inverted_then_moved<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
) -> Cow<'a, [u8]> {
    let mut predictor = Cow::Borrowed(reference);
    if step.inverted {
        (reading.invert)(predictor.to_mut());
    }
    if step.moved {
        predictor = Cow::Owned(shift(&predictor, size, step.motion, reading));
    }
    predictor
}

/// Returns the reference, displaced and then inverted: the other reading of `motion-inversion`.
pub(crate) fn moved_then_inverted<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
) -> Cow<'a, [u8]> {
    let mut predictor = Cow::Borrowed(reference);
    if step.moved {
        predictor = Cow::Owned(shift(&predictor, size, step.motion, reading));
    }
    if step.inverted {
        (reading.invert)(predictor.to_mut());
    }
    predictor
}

/// Computes 255 − v (clause 2.9.2/3).
pub(crate) fn invert(plane: &mut [u8]) {
    for value in plane {
        *value = 255 - *value;
    }
}

/// Computes residual + predictor − 128, modulo 256: in JPEG planes (clause 2.9.5/4), and in JPEG-LS planes as well (clause
/// 2.9.5/5, ruling `jpeg-ls-offset`).
pub(crate) fn predict(residuals: &mut [u8], predictor: &[u8]) {
    for (value, &predicted) in residuals.iter_mut().zip(predictor) {
        *value = value.wrapping_add(predicted).wrapping_sub(128);
    }
}

/// Computes residual + predictor, modulo 256: the other reading of `jpeg-ls-offset`, for JPEG-LS planes.
pub(crate) fn predict_without_offset(residuals: &mut [u8], predictor: &[u8]) {
    for (value, &predicted) in residuals.iter_mut().zip(predictor) {
        *value = value.wrapping_add(predicted);
    }
}

/// Returns the plane displaced by half a vector: its value at (x, y) is that at (x + mx/2, y + my/2) (clause 2.9.3/2).
pub(crate) fn shift(plane: &[u8], size: Size, (mx, my): (i64, i64), reading: &Reading) -> Vec<u8> {
    let mx = (reading.motion_sign)(mx);
    let my = (reading.motion_sign)((reading.motion_vertical)(my));
    // Every x of every y, row by row; `inside` is a faster version.
    inside::displace_rows(plane, size, (mx, my), reading.motion_half, |x, y| {
        // Coordinates are doubled, so that halves are whole numbers. A vector may be so long that it leaves every plane.
        let (x2, y2) = (mx.saturating_add(2 * x), my.saturating_add(2 * y));
        sample_between(plane, size, x2, y2, reading)
    })
}

/// Returns the sample at a position in half texels: that of a texel, or the mean of two or four (clause 2.9.3/5).
fn sample_between(plane: &[u8], size: Size, x2: i64, y2: i64, reading: &Reading) -> u8 {
    // A half lies between a texel and the next one, also left of zero: −1/2 is between −1 and 0.
    let (left, first) = (x2.div_euclid(2), y2.div_euclid(2));
    let (right, second) = (left + x2.rem_euclid(2), first + y2.rem_euclid(2));
    // If a coordinate is whole, two or all of the four are the same texel.
    let corners = [
        (left, first),
        (right, first),
        (left, second),
        (right, second),
    ];
    (reading.motion_half)(corners.map(|(x, y)| (reading.motion_border)(plane, size, x, y)))
}

/// Points a vector from the texel to its predictor (clause 2.9.3/3, ruling `motion-sign`).
pub(crate) fn sign_plus(displacement: i64) -> i64 {
    displacement
}

/// Points a vector from the predictor to the texel: the other reading of `motion-sign`.
pub(crate) fn sign_minus(displacement: i64) -> i64 {
    displacement.saturating_neg()
}

/// Lets y grow along the rows as they are stored (clause 2.9.3/4, ruling `motion-vertical`).
pub(crate) fn along_stored_rows(my: i64) -> i64 {
    my
}

/// Lets y grow against the rows as they are stored, downward in the image: the other reading of `motion-vertical`.
pub(crate) fn against_stored_rows(my: i64) -> i64 {
    my.saturating_neg()
}

/// Computes (a + b + c + d + 2) >> 2. For two equal pairs that is (a + b + 1) >> 1, for four equal samples the sample (clause
/// 2.9.3/5, ruling `motion-half`).
pub(crate) fn half_up(samples: [u8; 4]) -> u8 {
    ((sum(samples) + 2) >> 2) as u8
}

/// Rounds halves down: the other reading of `motion-half`.
pub(crate) fn half_down(samples: [u8; 4]) -> u8 {
    (sum(samples) >> 2) as u8
}

fn sum(samples: [u8; 4]) -> u16 {
    samples.into_iter().map(u16::from).sum()
}

/// Returns the nearest sample of the edge outside the plane (clause 2.9.3/6, ruling `motion-border`).
pub(crate) fn border_edge(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    plane[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize]
}

/// Wraps around to the other side outside the plane: the second reading of `motion-border`.
pub(crate) fn border_wrapped(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    plane[(y.rem_euclid(height) * width + x.rem_euclid(width)) as usize]
}

/// Returns 128 outside the plane: the third reading of `motion-border`.
pub(crate) fn border_gray(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    if (0..width).contains(&x) && (0..height).contains(&y) {
        plane[(y * width + x) as usize]
    } else {
        128
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn predicted(residual: u8, reference: u8, inverted: bool) -> u8 {
        let step = Step {
            reference: Some(0),
            inverted,
            ..Step::default()
        };
        let mut plane = [residual];
        apply(
            Format::JpegLrgb,
            &mut plane,
            &[reference],
            &step,
            Size {
                width: 1,
                height: 1,
            },
            &Reading::SPEC,
        );
        plane[0]
    }

    /// Displaces a plane of `width` columns by a vector.
    fn shift(plane: &[u8], width: u32, motion: (i64, i64), reading: &Reading) -> Vec<u8> {
        let height = plane.len() as u32 / width;
        super::shift(plane, Size { width, height }, motion, reading)
    }

    #[test]
    fn a_residual_of_128_changes_nothing() {
        assert_eq!(predicted(128, 0, false), 0);
        assert_eq!(predicted(128, 255, false), 255);
    }

    #[test]
    fn sums_wrap_below_zero_and_above_255() {
        assert_eq!(predicted(100, 20, false), 248); // −8
        assert_eq!(predicted(0, 0, false), 128); // −128
        assert_eq!(predicted(200, 200, false), 16); // 272
        assert_eq!(predicted(255, 255, false), 126); // 382
        assert_eq!(predicted(183, 200, false), 255);
        assert_eq!(predicted(184, 200, false), 0); // 256
    }

    #[test]
    fn an_inverted_reference_is_255_less_it() {
        assert_eq!(predicted(128, 0, true), 255);
        assert_eq!(predicted(130, 60, true), 197);
        assert_eq!(predicted(100, 250, true), 233); // −23
    }

    #[test]
    fn jpeg_ls_keeps_the_offset_but_under_the_other_reading() {
        let with = |reading: &Reading, format| {
            let (mut plane, dot) = (
                [140],
                Size {
                    width: 1,
                    height: 1,
                },
            );
            apply(format, &mut plane, &[10], &Step::default(), dot, reading);
            plane[0]
        };
        assert_eq!(with(&Reading::SPEC, Format::JpeglsRgb), 22);
        assert_eq!(
            with(&Reading::SPEC.without_jpeg_ls_offset(), Format::JpeglsRgb),
            150
        );
        assert_eq!(
            with(&Reading::SPEC.without_jpeg_ls_offset(), Format::JpegRgb),
            22
        );
    }

    #[test]
    fn whole_displacements_look_to_the_right_and_along_the_rows() {
        let plane = [10, 20, 30, 40, 50, 60];
        assert_eq!(
            shift(&plane, 3, (2, 0), &Reading::SPEC),
            [20, 30, 30, 50, 60, 60]
        );
        assert_eq!(
            shift(&plane, 3, (-2, 0), &Reading::SPEC),
            [10, 10, 20, 40, 40, 50]
        );
        assert_eq!(
            shift(&plane, 3, (0, 2), &Reading::SPEC),
            [40, 50, 60, 40, 50, 60]
        );
        assert_eq!(
            shift(&plane, 3, (0, -2), &Reading::SPEC),
            [10, 20, 30, 10, 20, 30]
        );
    }

    #[test]
    fn half_displacements_are_means_rounded_up() {
        let plane = [10, 21, 30];
        assert_eq!(shift(&plane, 3, (1, 0), &Reading::SPEC), [16, 26, 30]);
        assert_eq!(shift(&plane, 3, (-1, 0), &Reading::SPEC), [10, 16, 26]);
        assert_eq!(shift(&plane, 3, (3, 0), &Reading::SPEC), [26, 30, 30]);
        assert_eq!(shift(&plane, 1, (0, 1), &Reading::SPEC), [16, 26, 30]);
        // Four samples are added before they are rounded, once: (1 + 2 + 2 + 2 + 2) >> 2 = 2.
        assert_eq!(
            shift(&[1, 2, 2, 2], 2, (1, 1), &Reading::SPEC),
            [2, 2, 2, 2]
        );
        assert_eq!(
            shift(&[0, 1, 0, 0], 2, (1, 1), &Reading::SPEC),
            [0, 1, 0, 0]
        );
        assert_eq!(
            shift(&plane, 3, (1, 0), &Reading::SPEC.with_halves_rounded_down()),
            [15, 25, 30]
        );
    }

    #[test]
    fn each_motion_choice_has_its_other_reading() {
        let plane = [10, 20, 30, 40];
        assert_eq!(
            shift(&plane, 4, (2, 0), &Reading::SPEC.with_motion_minus()),
            [10, 10, 20, 30]
        );
        assert_eq!(
            shift(&plane, 1, (0, 2), &Reading::SPEC.with_motion_against_rows()),
            [10, 10, 20, 30]
        );
        assert_eq!(
            shift(&plane, 4, (2, 0), &Reading::SPEC.with_motion_against_rows()),
            [20, 30, 40, 40]
        );
        assert_eq!(
            shift(&plane, 4, (2, 0), &Reading::SPEC.with_border_wrapped()),
            [20, 30, 40, 10]
        );
        assert_eq!(
            shift(&plane, 4, (2, 0), &Reading::SPEC.with_border_gray()),
            [20, 30, 40, 128]
        );
        assert_eq!(
            shift(&plane, 4, (1, 0), &Reading::SPEC.with_border_gray()),
            [15, 25, 35, 84]
        );
    }

    #[test]
    fn inversion_comes_before_motion_and_shows_in_the_rounding() {
        let step = Step {
            reference: Some(0),
            inverted: true,
            moved: true,
            motion: (1, 0),
        };
        let seen = |reading: &Reading| {
            (reading.predictor)(
                &[10, 21],
                &step,
                Size {
                    width: 2,
                    height: 1,
                },
                reading,
            )
            .into_owned()
        };
        // 245 and 234: (245 + 234 + 1) >> 1 = 240. After motion: 255 − 16 = 239.
        assert_eq!(seen(&Reading::SPEC), [240, 234]);
        assert_eq!(
            seen(&Reading::SPEC.with_inversion_after_motion()),
            [239, 234]
        );
    }

    #[test]
    fn vectors_of_any_length_stay_within_the_plane() {
        for far in [i64::MIN, -1_000_001, 1_000_001, i64::MAX] {
            for reading in [
                Reading::SPEC,
                Reading::SPEC.with_motion_minus(),
                Reading::SPEC.with_border_wrapped(),
                Reading::SPEC.with_border_gray(),
            ] {
                assert_eq!(shift(&[1, 2, 3, 4, 5, 6], 3, (far, far), &reading).len(), 6);
            }
        }
    }
}
