//! Pairs of a received and an expected image.

use crate::protocol::frame::{Frame, ViewKind};
use crate::suite::compare::is_near;

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
    pub fn new(wanted: &Frame, shown: &Frame) -> Option<ImagePair> {
        let shape = |frame: &Frame| (frame.shape(), frame.samples.sample_type());
        (shape(wanted) == shape(shown) && wanted.channels > 0).then(|| ImagePair {
            width: wanted.width as usize,
            height: wanted.height as usize,
            channels: wanted.channels as usize,
            expected: wanted.samples.to_reals(),
            received: shown.samples.to_reals(),
            view: wanted.view,
        })
    }

    /// Returns true if two samples are equal within the tolerance of the view.
    pub fn is_near(&self, a: f64, b: f64) -> bool {
        is_near(self.view, a, b, 0.0, 0.0)
    }

    /// Returns the indices of the wrong samples.
    pub fn wrong_samples(&self) -> Vec<usize> {
        (0..self.expected.len())
            .filter(|&i| !self.is_near(self.expected[i], self.received[i]))
            .collect()
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
