//! Pairs of a received and an expected image, and partial credit for a mistake that explains only some of the wrong channels.

use super::tuning::{MIN_SUPPORT, PARTIAL_IMAGE_SCORE};
use super::witness::Witness;
use ptm_suite::compare::is_near;
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};

/// A received and an expected image of the same shape.
pub(super) struct ImagePair {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub expected: Vec<f64>,
    pub received: Vec<f64>,
    pub view: ViewKind,
}

impl ImagePair {
    /// Creates a pair. Returns `None` if the shapes of the images differ.
    pub fn new(expected: &Frame, received: &Frame) -> Option<ImagePair> {
        let shape = |frame: &Frame| (frame.shape(), frame.samples.sample_type());
        (shape(expected) == shape(received) && expected.channels > 0).then(|| ImagePair {
            width: expected.width as usize,
            height: expected.height as usize,
            channels: expected.channels as usize,
            expected: expected.samples.to_reals(),
            received: received.samples.to_reals(),
            view: expected.view,
        })
    }

    /// Returns the samples of one channel.
    pub fn channel(&self, channel: usize) -> ImagePair {
        let select = |values: &[f64]| {
            let values = values.iter().skip(channel);
            values.step_by(self.channels).copied().collect()
        };
        ImagePair {
            channels: 1,
            expected: select(&self.expected),
            received: select(&self.received),
            ..*self
        }
    }

    /// Returns the indices of the samples that differ by more than the tolerance of the view.
    pub fn wrong_samples(&self) -> Vec<usize> {
        let (expected, received) = (&self.expected, &self.received);
        let is_wrong = |&i: &usize| !is_near(self.view, expected[i], received[i], 0.0, 0.0);
        (0..expected.len()).filter(is_wrong).collect()
    }

    /// Returns one flag per channel: true if any of its samples is wrong.
    pub fn wrong_channels(&self) -> Vec<bool> {
        let mut wrong = vec![false; self.channels];
        for i in self.wrong_samples() {
            wrong[i % self.channels] = true;
        }
        wrong
    }
}

/// Returns a fraction of [`PARTIAL_IMAGE_SCORE`] proportional to the share of wrong channels that `answer` reproduces. Returns 0
/// if the answer differs from the response in a correct channel.
pub(super) fn partial_credit(witness: &Witness, answer: &Answer) -> i64 {
    let received = witness
        .wrong_image()
        .filter(|_| !witness.is_blank_by_mistake());
    let (Some(received), Answer::Decoded(right), Answer::Decoded(made)) =
        (received, &witness.expected, answer)
    else {
        return 0;
    };
    let (Some(right), Some(made)) = (
        ImagePair::new(right, received),
        ImagePair::new(made, received),
    ) else {
        return 0;
    };
    if right.width * right.height < MIN_SUPPORT {
        return 0;
    }
    let (before, after) = (right.wrong_channels(), made.wrong_channels());
    let channels = || before.iter().zip(&after);
    let breaks_channel = channels().any(|(before, after)| !before && *after);
    let fixed = channels().filter(|&(before, after)| *before && !after);
    let wrong = before.iter().filter(|wrong| **wrong).count();
    match breaks_channel || wrong == 0 {
        true => 0,
        false => (fixed.count() * PARTIAL_IMAGE_SCORE / wrong) as i64,
    }
}
