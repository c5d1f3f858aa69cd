//! T.87 A.2.1, A.4.2, A.5.1, A.5.2, A.6: the statistics of a context
//!
//! A context keeps four numbers: N errors so far, the sum A of their magnitudes, the sum B of the
//! errors themselves and the correction C of the prediction. A / N is the mean magnitude, which
//! gives the parameter k of the Golomb code; B / N is the mean error, which C takes over one by one.
//!
//! Worked example, a fresh context with MAXVAL 255 that meets the errors −3, −2 and 0:
//!
//! ```text
//!         A   B   C  N   k
//! fresh   4   0   0  1   2   1 · 2² ≥ 4
//! −3      7  −1  −1  2   2   B was −3 and is not over −2: C takes one, B gets N back
//! −2      9   0  −2  3   2   the same again
//!  0      9   0  −2  4   2   predictions are now lowered by two
//! ```
//!
//! Format notes
//! - When N reaches RESET, all sums are halved before N is incremented. B is rounded down then, also
//!   below zero.

use super::parameters::Parameters;

/// The statistics of the errors in one kind of neighborhood.
#[derive(Clone, Copy)]
pub(super) struct Context {
    /// Sum of the magnitudes of errors.
    a: i32,
    /// Sum of the errors, less the part that C has absorbed.
    b: i32,
    /// The correction of the prediction, −128 … 127.
    c: i32,
    /// The number of errors.
    n: i32,
}

/// Returns the contexts at the start of a scan, by number (A.2.1). Number 0 is the flat neighborhood, which belongs to run mode
/// and is not used.
pub(super) fn fresh_contexts(parameters: &Parameters) -> [Context; 365] {
    let a = initial_a(parameters);
    [Context {
        a,
        b: 0,
        c: 0,
        n: 1,
    }; 365]
}

/// Returns A after one error of a typical magnitude (A.2.1).
pub(super) fn initial_a(parameters: &Parameters) -> i32 {
    ((parameters.range + 32) / 64).max(2)
}

/// Returns the smallest k with n · 2^k ≥ a (A.5.1), so that 2^k is about the mean magnitude and a typical error has one zero or
/// none before its one.
#[inline]
pub(super) fn golomb_parameter(a: i32, n: i32) -> u32 {
    let mut k = 0;
    while n << k < a {
        k += 1;
    }
    k
}

impl Context {
    /// Returns the prediction, corrected by C (A.4.2). `sign` is −1 in the mirrored neighborhood.
    #[inline]
    pub fn correct(&self, predicted: i32, sign: i32, maxval: i32) -> i32 {
        (predicted + sign * self.c).clamp(0, maxval)
    }

    #[inline]
    pub fn golomb_parameter(&self) -> u32 {
        golomb_parameter(self.a, self.n)
    }

    /// Returns true if negative errors are mapped first. Errors are mapped to 0, 1, 2 … in the order 0, −1, 1, −2, 2 …; where
    /// negative ones are more frequent, in the order −1, 0, −2, 1 …, but only if k and NEAR are 0 (A.5.2).
    #[inline]
    pub fn maps_negative_first(&self, k: u32, near: i32) -> bool {
        k == 0 && near == 0 && 2 * self.b <= -self.n
    }

    /// Updates the statistics (A.6).
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

    /// Checks the worked example above.
    #[test]
    fn context_learns_the_prediction_bias() {
        let parameters = Parameters::new(&PresetParameters::default(), 0, 0, 0).expect("defaults");
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
