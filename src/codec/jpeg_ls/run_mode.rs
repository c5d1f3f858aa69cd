//! T.87 A.7: run mode, as far as decoder and encoder share it
//!
//! Where all gradients are flat, samples equal to a are counted until one differs or the line ends.
//! A run is written in pieces of 2^J samples, a bit 1 each, and J grows with `RUNindex` for as long as
//! runs last. A bit 0 and the rest of the run in J bits say that a sample interrupts it; that sample
//! is predicted and coded on its own.
//!
//! Worked example: a run of 7 samples and an interruption, `RUNindex` 0 before.
//!
//! ```text
//! 1 1 1 1   four pieces of one sample (RUNindex 0 … 3), RUNindex is now 4
//! 1         a piece of two samples (J = 1), RUNindex 5
//! 0 1       interrupted, after one more sample in J = 1 bits
//! …         the Golomb code of the interrupting sample; then RUNindex is 4
//! ```
//!
//! Format notes
//! - The code of the interruption uses `RUNindex` as it was *before* the end of the run lowers it.
//! - A run that ends with its line is not interrupted: no sample follows, and `RUNindex` stays.

use super::contexts::{golomb_parameter, initial_a};
use super::parameters::Parameters;

/// J of the standard, by `RUNindex`: a 1 in the stream means 2^J samples (A.2.1).
pub(crate) const J: [u32; 32] = [
    0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13,
    14, 15,
];

/// The state of run mode.
pub(super) struct RunMode {
    /// `RUNindex`: how long runs have been lately.
    index: usize,
    /// By `RItype`: 0 if a and b differ, 1 if they are alike. The standard's contexts 365 and 366.
    contexts: [RunContext; 2],
}

/// What is known of the errors of samples that interrupt a run (A.7.2).
#[derive(Clone, Copy)]
pub(super) struct RunContext {
    a: i32,
    n: i32,
    /// Nn: how many of the errors were negative.
    negative: i32,
}

/// How the sample that interrupts a run is predicted (A.7.2).
pub(super) struct Interruption {
    pub predicted: i32,
    /// −1 if errors count the other way.
    pub sign: i32,
    /// `RItype`: 1 if a and b are alike, else 0.
    pub kind: i32,
}

impl RunMode {
    pub fn new(parameters: &Parameters) -> RunMode {
        let fresh = RunContext {
            a: initial_a(parameters),
            n: 1,
            negative: 0,
        };
        RunMode {
            index: 0,
            contexts: [fresh; 2],
        }
    }

    /// J: the bits that the rest of a run takes; a piece is 2^J samples.
    #[inline]
    pub fn j(&self) -> u32 {
        J[self.index]
    }

    /// A piece of the run was complete.
    pub fn lengthen(&mut self) {
        self.index = (self.index + 1).min(31);
    }

    /// The run was interrupted.
    pub fn shorten(&mut self) {
        self.index = self.index.saturating_sub(1);
    }

    pub fn context(&mut self, interruption: &Interruption) -> &mut RunContext {
        &mut self.contexts[interruption.kind as usize]
    }

    /// The bits of the longest code of an interruption.
    pub fn limit(&self, parameters: &Parameters) -> u32 {
        parameters.limit - self.j() - 1
    }
}

impl Interruption {
    /// A.7.2, for a run of a and the sample b above the one that interrupts it.
    pub fn new(parameters: &Parameters, a: i32, b: i32) -> Interruption {
        let alike = (a - b).abs() <= parameters.near;
        Interruption {
            predicted: if alike { a } else { b },
            sign: if !alike && a > b { -1 } else { 1 },
            kind: i32::from(alike),
        }
    }
}

impl RunContext {
    /// A.7.2: where a and b are alike the error is never 0, so the mean is half an error less.
    pub fn golomb_parameter(&self, kind: i32) -> u32 {
        golomb_parameter(self.a + kind * (self.n >> 1), self.n)
    }

    /// A.7.2: which of the two errors of one magnitude has the smaller number, by its sign: the
    /// `map` of the standard is 1 exactly if the error is not 0 and its sign is this one.
    pub fn favored_sign(&self, k: u32) -> i32 {
        if k == 0 && 2 * self.negative < self.n {
            1
        } else {
            -1
        }
    }

    /// A.7.2. `mapped` is the error as it was coded.
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
