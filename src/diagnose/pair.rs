//! A picture as it was received, beside the one that was expected.

use crate::protocol::frame::{Frame, Samples};
use crate::ptm::channel_name;
use crate::suite::compare::{COLOR, is_close};

/// A picture and what it should be, of the same shape.
pub(super) struct Pair {
    pub width: usize,
    pub height: usize,
    pub channels: usize,
    pub want: Vec<f64>,
    pub got: Vec<f64>,
    pub view: &'static str,
}

impl Pair {
    pub fn of(wanted: &Frame, shown: &Frame) -> Option<Pair> {
        let numbers = |samples: &Samples| -> Vec<f64> {
            match samples {
                Samples::U8(bytes) => bytes.iter().map(|&byte| f64::from(byte)).collect(),
                Samples::F32(values) => values.iter().map(|&value| f64::from(value)).collect(),
            }
        };
        let shape = |frame: &Frame| {
            (
                frame.view,
                frame.width,
                frame.height,
                frame.channels,
                matches!(frame.samples, Samples::U8(_)),
            )
        };
        (shape(wanted) == shape(shown) && wanted.channels > 0).then(|| Pair {
            width: wanted.width as usize,
            height: wanted.height as usize,
            channels: wanted.channels as usize,
            want: numbers(&wanted.samples),
            got: numbers(&shown.samples),
            view: wanted.view,
        })
    }

    pub fn near(&self, a: f64, b: f64) -> bool {
        match self.view {
            "raw" => a == b,
            "rgb" => (a - b).abs() <= COLOR,
            _ => is_close(a, b, 0.0),
        }
    }

    /// Samples that are not as they should be.
    pub fn wrong(&self) -> Vec<usize> {
        (0..self.want.len())
            .filter(|&i| !self.near(self.want[i], self.got[i]))
            .collect()
    }

    pub fn name(&self, channel: usize) -> String {
        channel_name(self.channels, channel)
    }

    /// For each channel, whether any of its samples is not as it should be.
    pub fn wrong_channels(&self) -> Vec<bool> {
        let mut wrong = vec![false; self.channels];
        for i in self.wrong() {
            wrong[i % self.channels] = true;
        }
        wrong
    }
}
