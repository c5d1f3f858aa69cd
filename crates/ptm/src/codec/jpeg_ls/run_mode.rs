//! T.87 A.7: run mode, the part shared by the decoder and the encoder
//!
//! If all gradients are flat, samples equal to `a` are counted until a sample differs or the line ends. A run is written in
//! segments of 2^J samples, with a 1 bit for each, and J grows with `RUNindex` while runs continue. A 0 bit, followed by the rest
//! of the run in J bits, means that a sample interrupts the run. That sample is predicted and coded separately.
//!
//! Worked example: a run of 7 samples and an interruption, starting with `RUNindex` 0.
//!
//! ```text
//! 1 1 1 1   four segments of one sample (RUNindex 0 … 3), RUNindex is now 4
//! 1         a segment of two samples (J = 1), RUNindex 5
//! 0 1       interrupted, after one more sample in J = 1 bits
//! …         the Golomb code of the interrupting sample; then RUNindex is 4
//! ```
//!
//! Format notes
//! - The code of the interrupting sample uses `RUNindex` *before* it is decremented at the end of the run.
//! - A run that ends with its line is not interrupted. No sample follows, and `RUNindex` does not change.

use super::contexts::{golomb_parameter, initial_error_sum};
use super::parameters::Parameters;

/// J by `RUNindex`: a 1 bit in the stream means 2^J samples (A.2.1).
pub const J: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

/// State of run mode that is kept between runs.
pub(super) struct RunMode {
    /// `RUNindex`, a measure of recent run lengths.
    index: usize,
    /// Contexts by `RItype`: 1 if |a − b| ≤ NEAR, else 0. In the standard, their indices are 365 + `RItype`.
    contexts: [RunContext; 2],
}

/// Statistics of the prediction errors of interrupting samples (A.7.2).
#[derive(Clone, Copy)]
pub(super) struct RunContext {
    a: i32,
    n: i32,
    /// Nn, the number of negative errors.
    negative: i32,
}

/// Prediction of the sample that interrupts a run (A.7.2).
pub(super) struct Interruption {
    pub predicted: i32,
    /// Factor by which prediction errors are multiplied before they are coded: 1 or −1.
    pub sign: i32,
    /// `RItype`: 1 if |a − b| ≤ NEAR, else 0.
    pub kind: i32,
}

impl RunMode {
    pub fn new(parameters: &Parameters) -> RunMode {
        let (a, n, negative) = (initial_error_sum(parameters), 1, 0);
        let (index, contexts) = (0, [RunContext { a, n, negative }; 2]);
        RunMode { index, contexts }
    }

    /// Returns J, the number of bits for the rest of a run. A segment has 2^J samples.
    #[inline]
    pub fn segment_bits(&self) -> u32 {
        J[self.index]
    }

    /// Increments `RUNindex` after a complete segment.
    pub fn increment_index(&mut self) {
        self.index = (self.index + 1).min(31);
    }

    /// Decrements `RUNindex` after an interruption.
    pub fn decrement_index(&mut self) {
        self.index = self.index.saturating_sub(1);
    }

    pub fn context(&mut self, interruption: &Interruption) -> &mut RunContext {
        &mut self.contexts[interruption.kind as usize]
    }

    /// Returns the length in bits of the longest code for an interrupting sample.
    pub fn limit(&self, parameters: &Parameters) -> u32 {
        parameters.limit - self.segment_bits() - 1
    }
}

impl Interruption {
    /// Predicts the interrupting sample after a run of `a`, with the sample `b` above it (A.7.2).
    pub fn new(parameters: &Parameters, a: i32, b: i32) -> Interruption {
        let is_near = (a - b).abs() <= parameters.near;
        Interruption {
            predicted: if is_near { a } else { b },
            sign: if !is_near && a > b { -1 } else { 1 },
            kind: i32::from(is_near),
        }
    }
}

impl RunContext {
    /// Returns k (A.7.2). If |a − b| ≤ NEAR, errors are never 0, and A is the sum of the magnitudes, each minus one. Half of N is
    /// therefore added to A.
    pub fn golomb_parameter(&self, kind: i32) -> u32 {
        golomb_parameter(self.a + kind * (self.n >> 1), self.n)
    }

    /// Returns the sign for which errors of a given magnitude have the smaller code number (A.7.2). `map` in the
    /// standard is 1 if and only if the error is nonzero and has this sign.
    pub fn favored_sign(&self, k: u32) -> i32 {
        let is_positive = k == 0 && 2 * self.negative < self.n;
        if is_positive { 1 } else { -1 }
    }

    /// Updates the statistics after an error (A.7.2). `mapped` is the nonnegative number that represents the error in the stream.
    pub fn update(&mut self, error: i32, mapped: i32, kind: i32, reset: i32) {
        self.negative += i32::from(error < 0);
        self.a += (mapped + 1 - kind) >> 1;
        if self.n == reset {
            self.a >>= 1;
            self.n >>= 1;
            self.negative >>= 1;
        }
        self.n += 1;
    }
}
