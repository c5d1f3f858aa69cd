//! §2.9.3: mistakes with motion vectors

#![allow(
    clippy::cast_possible_wrap,
    reason = "planes are 18 at most, and texels fewer than a limit allows"
)]

use std::borrow::Cow;

use super::at::At;
use crate::decode::predict as rule;
use crate::parts::Step;
use crate::ptm::Size;
use crate::reading::Reading;

pub(super) const CHANGES: &[(&str, At)] = &[
    (
        "motion-halves-toward-zero",
        At::Predictor(|reference, step, size, reading| {
            displace_with_taps(reference, step, size, reading, |at, [d, _], _| {
                let first = at + d / 2;
                [first, first + (d & 1)]
            })
        }),
    ),
    (
        "motion-half-of-the-other-axis",
        At::Predictor(|reference, step, size, reading| {
            displace_with_taps(reference, step, size, reading, |at, [d, other], axis| {
                let first = at + (d >> 1);
                let half = if axis.is_x { d } else { other };
                [first, first + (half & 1)]
            })
        }),
    ),
    (
        "motion-half-of-the-edge",
        At::Predictor(|reference, step, size, reading| {
            displace_with_taps(reference, step, size, reading, |at, [d, _], axis| {
                let first = (at + (d >> 1)).clamp(0, axis.length - 1);
                [first, first + (d & 1)]
            })
        }),
    ),
    (
        "motion-half-begins-again",
        At::Predictor(|reference, step, size, reading| {
            displace_with_taps(reference, step, size, reading, |at, [d, _], axis| {
                let first = (at + (d >> 1)).clamp(0, axis.length - 1);
                let second = at + (d >> 1) + (d & 1);
                let inside = (0..axis.length).contains(&second);
                [first, if inside || second < 0 { second } else { 0 }]
            })
        }),
    ),
    (
        "motion-x-within-the-height",
        At::Predictor(|reference, step, size, reading| {
            displace_with_taps(reference, step, size, reading, |at, [d, _], axis| {
                let first = at + (d >> 1);
                let most = if axis.is_x {
                    axis.other.min(axis.length)
                } else {
                    axis.length
                };
                [first, first + (d & 1)].map(|at| at.clamp(0, most - 1))
            })
        }),
    ),
    (
        "motion-border-black",
        At::Predictor(|reference, step, size, reading| {
            displace_with_samples(
                reference,
                step,
                size,
                reading,
                |plane, x, y, width, height| {
                    let inside = (0..width).contains(&x) && (0..height).contains(&y);
                    if inside {
                        plane[(y * width + x) as usize]
                    } else {
                        0
                    }
                },
            )
        }),
    ),
];

fn limit_displacement(displacement: i64) -> i64 {
    displacement.clamp(-(1 << 40), 1 << 40)
}

/// Displaces a reference by the correct rule, but with a custom function for the sample at (x, y), inside or outside the plane.
fn displace_with_samples<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    sample: fn(&[u8], x: i64, y: i64, width: i64, height: i64) -> u8,
) -> Cow<'a, [u8]> {
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let taps: Taps = |at, [d, _], _| [at + (d >> 1), at + (d >> 1) + (d & 1)];
    displace_with(reference, step, size, reading, taps, |still, x, y| {
        sample(still, x, y, width, height)
    })
}

/// One axis of a plane.
struct PlaneAxis {
    is_x: bool,
    /// Number of samples along this axis.
    length: i64,
    /// Number of samples along the other axis.
    other: i64,
}

/// Returns the positions of the two samples that are averaged along an axis, given the position and the displacements
/// along this and the other axis, in half texels.
type Taps = fn(at: i64, displacements: [i64; 2], &PlaneAxis) -> [i64; 2];

/// Displaces a reference by the correct rule, but with custom positions of the averaged samples.
fn displace_with_taps<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    taps: Taps,
) -> Cow<'a, [u8]> {
    displace_with(reference, step, size, reading, taps, |still, x, y| {
        (reading.motion_border)(still, size, x, y)
    })
}

/// Displaces a reference. Each sample is the mean of four samples at the positions that `taps` returns.
fn displace_with<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    taps: Taps,
    sample: impl Fn(&[u8], i64, i64) -> u8,
) -> Cow<'a, [u8]> {
    let still = Step {
        moved: false,
        ..*step
    };
    let still = rule::invert_then_displace(reference, &still, size, reading);
    if !step.moved || step.motion == (0, 0) {
        return still;
    }
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let (mx, my) = (
        limit_displacement((reading.motion_sign)(step.motion.0)),
        limit_displacement((reading.motion_sign)((reading.motion_vertical)(
            step.motion.1,
        ))),
    );
    let [along, across] =
        [(true, width, height), (false, height, width)].map(|(is_x, length, other)| PlaneAxis {
            is_x,
            length,
            other,
        });
    let texel = |(x, y): (i64, i64)| {
        let [left, right] = taps(x, [mx, my], &along);
        let [upper, lower] = taps(y, [my, mx], &across);
        let at = |x, y| sample(&still, x, y);
        (reading.motion_half)([
            at(left, upper),
            at(right, upper),
            at(left, lower),
            at(right, lower),
        ])
    };
    Cow::Owned(
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(texel)
            .collect(),
    )
}
