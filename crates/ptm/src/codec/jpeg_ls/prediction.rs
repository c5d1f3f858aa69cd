//! T.87 A.4: prediction, its error and the reconstructed sample
//!
//! The prediction is the *median edge detector*: b or a at an edge, and a + b − c elsewhere. Errors are reduced modulo RANGE: of
//! the two errors that give the same sample, the one nearer to zero is coded.
//!
//! Worked example: a = 5, b = 12 and the sample 250, in lossless coding.
//!
//! ```text
//! c = 10   between a and b      prediction 5 + 12 − 10 = 7
//! c = 20   beyond both          prediction 5, the smaller: an edge
//! error    250 − 7 = 243        243 − 256 = −13
//! sample   7 − 13 = −6          −6 + 256 = 250
//! ```

use super::{parameters::Parameters, template::Neighbors};

/// Predicts a sample from its neighbors (A.4.1).
#[inline]
pub fn predict(neighbors: Neighbors) -> i32 {
    let Neighbors { a, b, c, .. } = neighbors;
    if c >= a.max(b) {
        a.min(b)
    } else if c <= a.min(b) {
        a.max(b)
    } else {
        a + b - c
    }
}

impl Parameters {
    /// Returns the error in units of the step: of all errors that give the same sample, the one nearest to zero (A.4.4, A.4.5).
    pub fn quantize_error(&self, error: i32) -> i32 {
        let quantized = (error + self.near * error.signum()) / self.step;
        let positive = quantized.rem_euclid(self.range);
        let is_large = positive >= (self.range + 1) / 2;
        positive - i32::from(is_large) * self.range
    }

    /// Returns true if `quantize_error` can return `error`.
    #[inline]
    pub fn is_reduced(&self, error: i32) -> bool {
        -(self.range / 2) <= error && error < (self.range + 1) / 2
    }

    /// Reconstructs the sample from a prediction and an error (A.4.4), as the decoder does.
    #[inline]
    pub fn reconstruct(&self, predicted: i32, error: i32) -> i32 {
        let modulus = self.range * self.step;
        let sample = predicted + error * self.step;
        // Avoid branches, which are unpredictable in noise.
        let below = i32::from(sample < -self.near);
        let above = i32::from(sample > self.maxval + self.near);
        (sample + (below - above) * modulus).clamp(0, self.maxval)
    }
}

#[cfg(test)]
mod tests {
    use super::super::parameters::{Parameters, PresetParameters};
    use super::{Neighbors, predict};

    /// Checks the worked example of this module.
    #[test]
    fn prediction_errors_are_reduced_modulo_range() {
        let (a, b, d) = (5, 12, 40);
        assert_eq!(predict(Neighbors { a, b, c: 10, d }), 7);
        assert_eq!(predict(Neighbors { a, b, c: 20, d }), 5);
        let parameters =
            Parameters::new(8, &PresetParameters::default(), 0, 0, 0).expect("defaults");
        assert!(parameters.is_reduced(-13) && !parameters.is_reduced(243));
        assert_eq!(parameters.reconstruct(7, -13), 250);
        assert_eq!(parameters.quantize_error(250 - 7), -13);
    }
}
