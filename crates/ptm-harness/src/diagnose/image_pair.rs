//! A received image next to the expected one.

use super::search::{MistakeId, Search};
use super::witness::{Witness, is_same_value};
use ptm_suite::compare::{Expected, LOSSY_TOLERANCE, is_near};
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};

/// A received and an expected image of the same shape.
pub(super) struct ImagePair {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub expected: Vec<f64>,
    pub received: Vec<f64>,
    pub view: ViewKind,
    /// Tolerance of each sample in addition to that of the view; empty if there is none.
    slack: Vec<f64>,
    /// Tolerance of all samples in addition to that of the view.
    loss: f64,
}

impl ImagePair {
    /// Creates a pair from two images in a case. Returns `None` if the shapes of the images differ.
    pub fn new(witness: &Witness, expected: &Frame, received: &Frame) -> Option<ImagePair> {
        let shape = |frame: &Frame| (frame.shape(), frame.samples.sample_type());
        let values = Expected::new(&witness.built.values, &witness.observation.view);
        let slack = values.map_or_else(Vec::new, |values| values.slack);
        (shape(expected) == shape(received) && expected.channels > 0).then(|| ImagePair {
            width: expected.width as usize,
            height: expected.height as usize,
            channels: expected.channels as usize,
            expected: expected.samples.to_reals(),
            received: received.samples.to_reals(),
            view: expected.view,
            slack: if slack.len() == expected.samples.len() {
                slack
            } else {
                Vec::new()
            },
            loss: if received.lossy { LOSSY_TOLERANCE } else { 0.0 },
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
            slack: select(&self.slack),
            ..*self
        }
    }

    /// Returns true if all samples received for `channel` equal those expected for `source`.
    pub fn has_values_of(&self, channel: usize, source: usize) -> bool {
        let expected = self.expected.chunks_exact(self.channels);
        let mut texels = self.received.chunks_exact(self.channels).zip(expected);
        texels.all(|(received, expected)| received[channel] == expected[source])
    }

    /// Returns the indices of the samples that differ by more than their tolerance.
    pub fn wrong_samples(&self) -> Vec<usize> {
        let (expected, received) = (&self.expected, &self.received);
        let is_wrong = |&i: &usize| {
            let (expected, received) = (expected[i], received[i]);
            let slack = self.slack.get(i).copied().unwrap_or_default();
            !is_same_value(expected, received)
                && !is_near(self.view, expected, received, slack, self.loss)
        };
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

/// Returns the received image and the image of a decoder with these mistakes, or `None` if their shapes differ. Without mistakes,
/// colors are expected as before rounding, as in the verdict, unless the reference's dialect gives another image.
pub(super) fn image_pair(search: &Search, set: &[MistakeId], w: usize) -> Option<ImagePair> {
    let witness = &search.witnesses[w];
    let received = witness.wrong_image()?;
    let Answer::Decoded(expected) = &*search.best_answer(w, set) else {
        return None;
    };
    let mut pair = ImagePair::new(witness, expected, received)?;
    if set.is_empty()
        && pair.view == ViewKind::Rgb
        && let Some(exact) = Expected::new(&witness.built.values, &witness.observation.view)
        && exact.frame().samples == expected.samples
    {
        pair.expected = exact.values;
    }
    Some(pair)
}
