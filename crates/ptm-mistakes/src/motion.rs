//! §2.9.3: mistakes in applying motion vectors

#![allow(
    clippy::cast_possible_wrap,
    reason = "there are at most 18 planes, and the number of texels is limited"
)]

use std::borrow::Cow;

use super::change::{Change, Changes};
use ptm::Size;
use ptm::decode::predict as rule;
use ptm::parts::Step;
use ptm::reading::Reading;

pub const CHANGES: Changes = |slug| {
    let change: fn(&mut Reading) = match slug {
        "motion-halves-toward-zero" => |r| {
            r.predictor = |reference, step, size, reading| {
                displace_with_taps(reference, step, size, reading, |at, [d, _], _| {
                    let first = at + d / 2;
                    [first, first + (d & 1)]
                })
            };
        },
        "motion-half-of-the-other-axis" => |r| {
            r.predictor = |reference, step, size, reading| {
                displace_with_taps(reference, step, size, reading, |at, [d, other], axis| {
                    let first = at + (d >> 1);
                    let half = if axis.is_x { d } else { other };
                    [first, first + (half & 1)]
                })
            };
        },
        "motion-half-of-the-edge" => |r| {
            r.predictor = |reference, step, size, reading| {
                displace_with_taps(reference, step, size, reading, |at, [d, _], axis| {
                    let first = (at + (d >> 1)).clamp(0, axis.length - 1);
                    [first, first + (d & 1)]
                })
            };
        },
        "motion-half-begins-again" => |r| {
            r.predictor = |reference, step, size, reading| {
                displace_with_taps(reference, step, size, reading, |at, [d, _], axis| {
                    let first = (at + (d >> 1)).clamp(0, axis.length - 1);
                    let second = at + (d >> 1) + (d & 1);
                    let is_inside = (0..axis.length).contains(&second);
                    [first, if is_inside || second < 0 { second } else { 0 }]
                })
            };
        },
        "motion-x-within-the-height" => |r| {
            r.predictor = |reference, step, size, reading| {
                displace_with_taps(reference, step, size, reading, |at, [d, _], axis| {
                    let first = at + (d >> 1);
                    let limit = if axis.is_x {
                        axis.other_length.min(axis.length)
                    } else {
                        axis.length
                    };
                    [first, first + (d & 1)].map(|at| at.clamp(0, limit - 1))
                })
            };
        },
        "motion-border-black" => |r| r.motion_border = rule::black_border,
        _ => return None,
    };
    Some(Change::Reading(change))
};

fn limit_displacement(displacement: i64) -> i64 {
    displacement.clamp(-(1 << 40), 1 << 40)
}

struct PlaneAxis {
    is_x: bool,
    /// Number of samples along this axis.
    length: i64,
    /// Number of samples along the other axis.
    other_length: i64,
}

/// Function that returns the positions of the two samples to average along an axis. `at` is the position of the texel.
/// `displacements` contains the displacements along this axis and along the other axis, in half texels.
type Taps = fn(at: i64, displacements: [i64; 2], &PlaneAxis) -> [i64; 2];

/// Displaces a reference according to the correct rule, except that `taps` determines the positions of the four averaged samples.
fn displace_with_taps<'a>(
    reference: &'a [u8],
    step: &Step,
    size: Size,
    reading: &Reading,
    taps: Taps,
) -> Cow<'a, [u8]> {
    let without_motion = Step {
        displaced: false,
        ..*step
    };
    let plane = rule::invert_then_displace(reference, &without_motion, size, reading);
    if !step.displaced || step.motion == (0, 0) {
        return plane;
    }
    let (width, height) = (i64::from(size.width), i64::from(size.height));
    let mx = limit_displacement((reading.motion_sign)(step.motion.0));
    let my = (reading.motion_vertical)(step.motion.1);
    let my = limit_displacement((reading.motion_sign)(my));
    let x_axis = PlaneAxis {
        is_x: true,
        length: width,
        other_length: height,
    };
    let y_axis = PlaneAxis {
        is_x: false,
        length: height,
        other_length: width,
    };
    let texel = |i: i64| {
        let [left, right] = taps(i % width, [mx, my], &x_axis);
        let [upper, lower] = taps(i / width, [my, mx], &y_axis);
        let corners = [(left, upper), (right, upper), (left, lower), (right, lower)];
        (reading.motion_half)(corners.map(|(x, y)| (reading.motion_border)(&plane, size, x, y)))
    };
    Cow::Owned((0..height * width).map(texel).collect())
}
