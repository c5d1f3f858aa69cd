//! Fast displacement of a plane
//!
//! The interior of a plane contains most texels and has no edges to handle, so whole rows are computed from four slices
//! of the plane. The border, which is as wide as the displacement, is computed texel by texel as in [`super::predict`].
//! A test compares the two versions.

use std::ops::Range;

use crate::types::Size;

/// Displaces a plane. In the interior, combines the four nearest samples with `mean`. At the border, calls `sample`.
pub(super) fn displace_rows(
    plane: &[u8],
    size: Size,
    (mx, my): (i64, i64),
    mean: fn([u8; 4]) -> u8,
    sample: impl Fn(i64, i64) -> u8,
) -> Vec<u8> {
    let width = size.width as usize;
    let (x_axis, y_axis) = (
        DisplacedAxis::new(mx, size.width),
        DisplacedAxis::new(my, size.height),
    );
    let row = |y: i64| &plane[y as usize * width..][..width];
    let mut texels = Vec::with_capacity(plane.len());
    for y in 0..i64::from(size.height) {
        let run = if y_axis.interior.contains(&y) {
            x_axis.interior.clone()
        } else {
            0..0
        };
        // The left border, or the whole row if one of the two rows is outside.
        texels.extend((0..run.start).map(|x| sample(x, y)));
        if !run.is_empty() {
            // a and b are in the first row, and c and d in the second, in the order that `mean` expects.
            let [first, second] = y_axis.tap_positions(y).map(row);
            let [left, right] = x_axis.tap_positions(run.start).map(|x| x as usize);
            let length = (run.end - run.start) as usize;
            let [a, c] = [first, second].map(|row| &row[left..][..length]);
            let [b, d] = [first, second].map(|row| &row[right..][..length]);
            texels.extend((0..length).map(|i| mean([a[i], b[i], c[i], d[i]])));
        }
        texels.extend((run.end..i64::from(size.width)).map(|x| sample(x, y)));
    }
    texels
}

/// One axis of a plane, and the displacement along it.
struct DisplacedAxis {
    /// Offsets from a position to the two samples that are nearest to its displaced position.
    offsets: [i64; 2],
    /// Positions at which both samples are inside the plane.
    interior: Range<i64>,
}

impl DisplacedAxis {
    fn new(displacement: i64, length: u32) -> DisplacedAxis {
        // A half position is between a texel and the next one, so the second sample never precedes the first.
        let length = i64::from(length);
        let first = displacement.div_euclid(2);
        let second = first + displacement.rem_euclid(2);
        let start = first.saturating_neg().clamp(0, length);
        DisplacedAxis {
            offsets: [first, second],
            interior: start..length.saturating_sub(second).clamp(start, length),
        }
    }

    fn tap_positions(&self, at: i64) -> [i64; 2] {
        self.offsets.map(|offset| at + offset)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Returns the sample at (x, y), with edge replication.
    fn replicated_sample(plane: &[u8], size: Size, x: i64, y: i64) -> u8 {
        let x = x.clamp(0, i64::from(size.width) - 1);
        let y = y.clamp(0, i64::from(size.height) - 1);
        plane[y as usize * size.width as usize + x as usize]
    }

    proptest! {
        #[test]
        fn rows_equal_plain_texel_order(
            (width, height) in (1u32..12, 1u32..12),
            samples in proptest::collection::vec(any::<u8>(), 144),
            near in (-30i64..30, -30i64..30),
            far in (any::<i64>(), any::<i64>()),
            which in 0..4,
        ) {
            let size = Size { width, height };
            let plane = &samples[..size.texels()];
            let (mx, my) = [near, far, (near.0, far.1), (far.0, near.1)][which as usize];
            // The function is asymmetric, to detect swapped samples.
            let mean = |[a, b, c, d]: [u8; 4]| a ^ b.rotate_left(1) ^ c.rotate_left(2) ^ d.rotate_left(3);
            let sample = |x: i64, y: i64| {
                let (x, y) = (mx.saturating_add(2 * x), my.saturating_add(2 * y));
                let (left, first) = (x.div_euclid(2), y.div_euclid(2));
                let (right, second) = (left + x.rem_euclid(2), first + y.rem_euclid(2));
                mean([(left, first), (right, first), (left, second), (right, second)]
                    .map(|(x, y)| replicated_sample(plane, size, x, y)))
            };
            let plain: Vec<u8> = (0..i64::from(height))
                .flat_map(|y| (0..i64::from(width)).map(move |x| (x, y)))
                .map(|(x, y)| sample(x, y))
                .collect();
            prop_assert_eq!(displace_rows(plane, size, (mx, my), mean, sample), plain);
        }
    }
}
