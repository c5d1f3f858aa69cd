//! T.87 C.2.4.1.1, A.2.1: preset coding parameters, and values derived from them
//!
//! The frame header has the precision P, which determines the default of MAXVAL, 2^P − 1. An LSE segment may set MAXVAL, the
//! thresholds of the gradients and RESET. NEAR is in the scan header. All other parameters of a scan are computed from these.
//!
//! Worked example: parameters for samples of 8, 8 and 7 bits.
//!
//! ```text
//! MAXVAL NEAR   T1 T2 T3  RESET   RANGE qbpp  bpp  LIMIT
//! 255    0       3  7 21  64        256    8    8     32
//! 255    3      12 22 42  64         38    6    8     32
//! 127    0       2  3 10  64        128    7    7     30
//! ```
//!
//! Format notes
//! - A zero in the segment means the default, which depends on MAXVAL and NEAR.
//! - LIMIT follows from MAXVAL, not from the precision in the frame header.
//! - T1 = T2 = T3 is legal.

use crate::codec::stream_error::{StreamResult, malformed};

/// Preset coding parameters of an LSE segment (C.2.4.1.1). 0 means the default.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct PresetParameters {
    /// MAXVAL, the largest sample: 1 … 2^P − 1 for samples of P bits.
    pub maxval: u16,
    /// T1, the first gradient threshold: NEAR + 1 … MAXVAL.
    pub t1: u16,
    /// T2, the second gradient threshold: T1 … MAXVAL.
    pub t2: u16,
    /// T3, the third gradient threshold: T2 … MAXVAL.
    pub t3: u16,
    /// RESET, the number of samples after which a context halves its statistics: 3 … 255.
    pub reset: u16,
}

/// Parameters of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Parameters {
    /// MAXVAL, the largest sample.
    pub maxval: i32,
    pub near: i32,
    /// Gradient thresholds T1, T2, T3.
    pub thresholds: [i32; 3],
    pub reset: i32,
    /// Distance between adjacent quantized errors, 2·NEAR + 1.
    pub step: i32,
    /// RANGE, the number of distinct errors.
    pub range: i32,
    /// Number of bits that represent an error in plain binary.
    pub qbpp: u32,
    /// LIMIT, the length in bits of the longest code.
    pub limit: u32,
}

impl Parameters {
    /// Fills in defaults and validates the parameters for samples of `precision` bits, 2 … 8.
    ///
    /// `presets_at` and `near_at` are offsets in the stream, for error messages.
    pub fn new(
        precision: u8,
        presets: &PresetParameters,
        presets_at: usize,
        near: u8,
        near_at: usize,
    ) -> StreamResult<Parameters> {
        let near = i32::from(near);
        let largest = (1 << precision) - 1;
        let maxval = value_or_default(presets.maxval, largest);
        if maxval > largest {
            let what = format!("MAXVAL {maxval} does not fit in {precision} bits");
            return Err(malformed(presets_at, what));
        }
        if near > maxval / 2 {
            let what = format!("NEAR {near} is more than half of MAXVAL {maxval}");
            return Err(malformed(near_at, what));
        }
        let mut thresholds = default_thresholds(maxval, near);
        // Each threshold must be between the previous one and MAXVAL.
        let (mut min, stored) = (near + 1, [presets.t1, presets.t2, presets.t3]);
        for (i, threshold) in thresholds.iter_mut().enumerate() {
            *threshold = value_or_default(stored[i], *threshold);
            if !(min..=maxval).contains(threshold) {
                let name = i + 1;
                let what = format!("T{name} must be from {min} to {maxval}, found {threshold}");
                return Err(malformed(presets_at + 2 * name, what));
            }
            min = *threshold;
        }
        let reset = value_or_default(presets.reset, 64);
        if !(3..=255).contains(&reset) {
            let what = format!("RESET must be from 3 to 255, found {reset}");
            return Err(malformed(presets_at + 8, what));
        }

        // A.2.1.
        let step = 2 * near + 1;
        let range = (maxval + 2 * near) / step + 1;
        let bpp = bit_width(maxval + 1).max(2);
        Ok(Parameters {
            maxval,
            near,
            thresholds,
            reset,
            step,
            range,
            qbpp: bit_width(range),
            limit: 2 * (bpp + bpp.max(8)),
        })
    }
}

fn value_or_default(value: u16, default: i32) -> i32 {
    match value {
        0 => default,
        value => i32::from(value),
    }
}

/// Returns the number of bits needed for `values` distinct values.
fn bit_width(values: i32) -> u32 {
    (values - 1).ilog2() + 1
}

/// Returns the default thresholds: 3, 7, 21 for lossless 8-bit coding, and scaled values for other MAXVAL and NEAR (C.2.4.1.1.1).
///
/// A threshold above MAXVAL or below the previous one (NEAR + 1 for the first) is replaced by the previous one.
fn default_thresholds(maxval: i32, near: i32) -> [i32; 3] {
    let thresholds = if maxval >= 128 {
        // MAXVAL is at most 255 here, so the factor of the standard is always 1.
        [3 + 3 * near, 7 + 5 * near, 21 + 7 * near]
    } else {
        let divisor = 256 / (maxval + 1);
        [
            (3 / divisor + 3 * near).max(2),
            (7 / divisor + 5 * near).max(3),
            (21 / divisor + 7 * near).max(4),
        ]
    };
    let mut min = near + 1;
    thresholds.map(|threshold| {
        if (min..=maxval).contains(&threshold) {
            min = threshold;
        }
        min
    })
}

#[cfg(test)]
mod tests {
    use super::{Parameters, PresetParameters};

    /// Checks the worked example of this module, and the smallest MAXVAL.
    #[test]
    fn defaults_follow_from_maxval_and_near() {
        let all = |precision, maxval, near| {
            let presets = PresetParameters {
                maxval,
                ..PresetParameters::default()
            };
            let p = Parameters::new(precision, &presets, 0, near, 0).expect("legal parameters");
            (p.thresholds, p.reset, p.range, p.qbpp, p.limit)
        };
        assert_eq!(all(8, 0, 0), ([3, 7, 21], 64, 256, 8, 32));
        assert_eq!(all(8, 255, 3), ([12, 22, 42], 64, 38, 6, 32));
        assert_eq!(all(8, 127, 0), ([2, 3, 10], 64, 128, 7, 30));
        assert_eq!(all(7, 0, 0), all(8, 127, 0));
        assert_eq!(all(8, 128, 0), ([3, 7, 21], 64, 129, 8, 32));
        assert_eq!(all(8, 1, 0), ([1, 1, 1], 64, 2, 1, 20));
    }
}
