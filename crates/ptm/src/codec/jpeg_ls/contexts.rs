//! T.87 A.2.1, A.4.2, A.5.1, A.5.2, A.6: the statistics of a context
//!
//! A context has four numbers: the count N of errors so far, the sum A of their magnitudes, the sum B of the errors
//! themselves, and the correction C of the prediction. A / N is the mean magnitude, which determines the parameter k
//! of the Golomb code. B / N is the mean error, which C absorbs in steps of one.
//!
//! Worked example: a fresh context with MAXVAL 255, and the errors −3, −2 and 0.
//!
//! ```text
//!         A   B   C  N   k
//! fresh   4   0   0  1   2   1 · 2² ≥ 4
//! −3      7  −1  −1  2   2   B = −3 is at most −N = −2, so C decreases and B increases by N
//! −2      9   0  −2  3   2   C decreases again
//!  0      9   0  −2  4   2   predictions are now corrected by −2
//! ```
//!
//! Format notes
//! - When N reaches RESET, A, B and N are halved before N is incremented. B is rounded down, for negative values as well.

use super::parameters::Parameters;

/// Statistics of the errors in one kind of neighborhood.
#[derive(Clone, Copy)]
pub(super) struct Context {
    /// Sum of the magnitudes of the errors.
    a: i32,
    /// Sum of the errors, minus the part that C has absorbed.
    b: i32,
    /// Correction of the prediction, −128 … 127.
    c: i32,
    /// Number of errors.
    n: i32,
}

/// Returns the contexts at the start of a scan (A.2.1). Index 0, the flat neighborhood, is unused, because run mode handles it.
pub(super) fn fresh_contexts(parameters: &Parameters) -> [Context; 365] {
    let (a, b, c, n) = (initial_error_sum(parameters), 0, 0, 1);
    [Context { a, b, c, n }; 365]
}

/// Returns the initial value of A, as if after one typical error (A.2.1).
pub(super) fn initial_error_sum(parameters: &Parameters) -> i32 {
    ((parameters.range + 32) / 64).max(2)
}

/// Returns the smallest k with n · 2^k ≥ a (A.5.1). 2^k is about the mean magnitude, so the code of a typical error
/// starts with at most one zero.
#[inline]
pub(super) fn golomb_parameter(a: i32, n: i32) -> u32 {
    let mut k = 0;
    while n << k < a {
        k += 1;
    }
    k
}

impl Context {
    /// Returns the prediction, corrected by C (A.4.2). `sign` is −1 if the neighborhood is mirrored.
    #[inline]
    pub fn correct_prediction(&self, predicted: i32, sign: i32, maxval: i32) -> i32 {
        (predicted + sign * self.c).clamp(0, maxval)
    }

    #[inline]
    pub fn golomb_parameter(&self) -> u32 {
        golomb_parameter(self.a, self.n)
    }

    /// Returns true if negative errors come first in the mapping to nonnegative numbers (A.5.2). The usual order is
    /// 0, −1, 1, −2, 2 … If negative errors are more frequent, and if k and NEAR are 0, the order is −1, 0, −2, 1 …
    #[inline]
    pub fn maps_negative_first(&self, k: u32, near: i32) -> bool {
        k == 0 && near == 0 && 2 * self.b <= -self.n
    }

    /// Updates the statistics after an error (A.6).
    #[inline]
    pub fn update(&mut self, error: i32, parameters: &Parameters) {
        self.b += error * parameters.step;
        self.a += error.abs();
        if self.n == parameters.reset {
            self.a >>= 1;
            self.b >>= 1;
            self.n >>= 1;
        }
        self.n += 1;

        // C absorbs whole units of the mean error, so that −N < B ≤ 0.
        if self.b <= -self.n {
            self.c = (self.c - 1).max(-128);
            self.b = (self.b + self.n).max(1 - self.n);
        } else if self.b > 0 {
            self.c = (self.c + 1).min(127);
            self.b = (self.b - self.n).min(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::{Parameters, PresetParameters};
    use super::{Context, fresh_contexts};

    /// Checks the worked example of this module.
    #[test]
    fn context_learns_the_prediction_bias() {
        let parameters =
            Parameters::new(8, &PresetParameters::default(), 0, 0, 0).expect("defaults");
        let mut context = fresh_contexts(&parameters)[1];
        let mut states = Vec::new();
        for error in [-3, -2, 0] {
            context.update(error, &parameters);
            let Context { a, b, c, n } = context;
            states.push([a, b, c, n]);
        }
        assert_eq!(states, [[7, -1, -1, 2], [9, 0, -2, 3], [9, 0, -2, 4]]);
        assert_eq!(context.golomb_parameter(), 2);
    }
}
