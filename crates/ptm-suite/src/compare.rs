//! Compares expected and received samples.
//!
//! - raw: equal. In lossy JPEG planes for which inverse DCTs may differ: within the slack of the model, modulo 256.
//! - coef: |a − b| ≤ 1e-5 · max(|a|, |b|) + 1e-6 (one rounding and one product in `f32`), plus the slack.
//! - rgb: within 1 + 1/64 of the exact color (any rounding, and arithmetic in `f32`), plus [`LOSSY_TOLERANCE`] for a JPEG image.

use std::fmt;

use crate::protocol::frame::{Frame, Light, View, ViewKind};
use crate::values::{HandValues, Values};
use ptm::decode::decode_as;
use ptm::reading::Reading;
use ptm::{Limits, Size, channel_name};

/// Expected samples of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// View of the samples.
    pub view: ViewKind,
    /// Width and height.
    pub size: Size,
    /// Number of samples per texel.
    pub channels: usize,
    /// `height * width * channels` values; colors are not rounded.
    pub values: Vec<f64>,
    /// For each value, the maximum difference between the results of correct inverse DCTs; empty if they all agree.
    pub slack: Vec<f64>,
}

/// The samples in flat blocks of intra-coded JPEG planes: blocks that have one value in the reference's image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FlatBlocks {
    /// Number of samples.
    pub samples: u32,
    /// Sum of the differences from the reference.
    pub sum: i32,
}

/// Tolerance for a byte relative to the exact color: one for rounding, and 1/64 for arithmetic in `f32`.
const COLOR_TOLERANCE: f64 = 1.0 + 1.0 / 64.0;

/// Additional tolerance for a byte of a JPEG image. At quality 95, no sample in the suite's images deviates by more than 29; the
/// remainder allows for other encoders and their tables.
pub const LOSSY_TOLERANCE: f64 = 48.0;

fn reals(bytes: &[u8]) -> Vec<f64> {
    bytes.iter().copied().map(f64::from).collect()
}

impl Expected {
    /// Returns the samples that are expected in `view` for a file with these values, or `None` if the values do not suffice.
    #[must_use]
    pub fn new(values: &Values, view: &View) -> Option<Expected> {
        match values {
            Values::None | Values::Any => None,
            Values::Painted(model) => {
                let (values, slack) = match *view {
                    View::Raw => (reals(&model.samples), reals(&model.slack)),
                    View::Coef => (model.coefficients(), model.coefficient_slack()),
                    View::Rgb(Light { lu, lv, .. }) => {
                        (model.colors(lu, lv), model.color_slack(lu, lv))
                    }
                };
                let expected = Expected::exact(view.kind(), model.size, values);
                Some(Expected { slack, ..expected })
            }
            Values::Hand(hand) => {
                let lines = match view {
                    View::Raw => &hand.raw,
                    View::Coef => hand.coef.as_ref()?,
                    View::Rgb(_) => {
                        let image = hand.rgb.as_ref()?;
                        let is_asked = format!("rgb:{}", image.light) == view.to_string();
                        is_asked.then_some(&image.texels)?
                    }
                };
                let size = hand.size.parse().ok()?;
                let values = HandValues::numbers(lines);
                Some(Expected::exact(view.kind(), size, values))
            }
        }
    }

    /// Returns the samples of `file` in `view` under another reading, or `None` if the file is refused under that reading.
    #[must_use]
    pub fn from_file(file: &[u8], view: &View, reading: &Reading) -> Option<Expected> {
        let ptm = decode_as(file, reading, &Limits::default()).ok()?;
        let values = view.values(&ptm, reading);
        Some(Expected::exact(view.kind(), ptm.header.size, values))
    }

    /// Returns the samples of a frame as expected samples, for comparison with another frame.
    #[must_use]
    pub fn from_frame(frame: &Frame) -> Expected {
        let (width, height) = (frame.width, frame.height);
        Expected::exact(frame.view, Size { width, height }, frame.samples.to_reals())
    }

    /// Returns expected values that do not depend on the inverse DCT.
    fn exact(view: ViewKind, size: Size, values: Vec<f64>) -> Expected {
        Expected {
            view,
            size,
            channels: values.len() / size.texels(),
            values,
            slack: Vec::new(),
        }
    }

    /// Returns the frame that a correct decoder outputs, with colors rounded to the nearest byte.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let shape = [self.size.width, self.size.height, self.channels as u32];
        Frame::exact(self.view, shape, self.view.samples(&self.values))
    }

    /// Returns the first difference between `frame` and the expected samples, or `None` if the frame is correct.
    #[must_use]
    pub fn compare(&self, frame: &Frame) -> Option<Difference> {
        let (width, height) = (frame.width, frame.height);
        let right = (self.view, self.size, self.channels as u32);
        let received = (frame.view, Size { width, height }, frame.channels);
        if right != received {
            let shape = |(view, size, channels)| format!("{view} {size} with {channels} channels");
            let (expected, received) = (shape(right), shape(received));
            return Some(Difference::Shape { expected, received });
        }
        let (expected, received) = (self.view.sample_type(), frame.samples.sample_type());
        if expected != received {
            let expected = format!("samples of type {expected}");
            let received = received.to_owned();
            return Some(Difference::Shape { expected, received });
        }
        let loss = if frame.lossy { LOSSY_TOLERANCE } else { 0.0 };
        self.difference(|i| frame.samples.real(i), loss)
    }

    /// Sums the differences in flat blocks of intra-coded JPEG planes. `frame` has the shape of the expected raw samples.
    pub(super) fn flat_blocks(&self, frame: &Frame) -> FlatBlocks {
        let (width, height) = (self.size.width as usize, self.size.height as usize);
        let mut flat = FlatBlocks::default();
        for block in 0..(width / 8) * (height / 8) * self.channels {
            let (channel, block) = (block % self.channels, block / self.channels);
            let (x, stored_y) = (block % (width / 8) * 8, block / (width / 8) * 8);
            // Blocks begin at the first stored row, which is the last row of the image.
            let texel = |k: usize| (height - 1 - stored_y - k / 8) * width + x + k % 8;
            let samples: Vec<usize> = (0..64)
                .map(|k| texel(k) * self.channels + channel)
                .collect();
            let value = self.values[samples[0]];
            // Only in an intra-coded plane do inverse DCTs differ by at most one.
            if samples
                .iter()
                .all(|&i| self.values[i] == value && self.slack[i] == 1.0)
            {
                flat.samples += 64;
                let differences = samples.iter().map(|&i| frame.samples.real(i) - value);
                flat.sum += differences.sum::<f64>() as i32;
            }
        }
        flat
    }

    /// Returns true if `received` is within the tolerance of sample `i`.
    #[must_use]
    pub fn is_near(&self, i: usize, received: f64) -> bool {
        self.is_within(i, received, 0.0)
    }

    /// Returns true if `received` is within the tolerance of sample `i` plus `loss`.
    fn is_within(&self, i: usize, received: f64, loss: f64) -> bool {
        let slack = self.slack.get(i).copied().unwrap_or_default();
        is_near(self.view, self.values[i], received, slack, loss)
    }

    fn difference(&self, received: impl Fn(usize) -> f64, loss: f64) -> Option<Difference> {
        let samples = self.values.len();
        let mut wrong = (0..samples).filter(|&i| !self.is_within(i, received(i), loss));
        let first = wrong.next()?;
        let texel = first / self.channels;
        let channels = texel * self.channels..(texel + 1) * self.channels;
        Some(Difference::Samples {
            x: texel % self.size.width as usize,
            y: texel / self.size.width as usize,
            channel: channel_name(self.channels, first % self.channels),
            expected: self.values[channels.clone()].to_vec(),
            received: channels.map(&received).collect(),
            wrong: 1 + wrong.count(),
            samples,
        })
    }
}

/// First difference between a frame and the expected one.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// A different view, size, number of channels or sample type.
    Shape {
        /// The expected shape.
        expected: String,
        /// The shape of the frame.
        received: String,
    },
    /// Different samples.
    Samples {
        /// Column of the first texel that differs, counted from the left.
        x: usize,
        /// Row of that texel, counted from the top.
        y: usize,
        /// First channel in which that texel differs.
        channel: String,
        /// Expected values of all channels of that texel.
        expected: Vec<f64>,
        /// Received values of all channels of that texel.
        received: Vec<f64>,
        /// Number of samples that differ.
        wrong: usize,
        /// Total number of samples.
        samples: usize,
    },
}

/// Returns true if `received` is close enough to a sample. `slack` allows for different inverse DCTs, `loss` for lossy images.
#[must_use]
pub fn is_near(view: ViewKind, expected: f64, received: f64, slack: f64, loss: f64) -> bool {
    let apart = (expected - received).abs();
    match view {
        ViewKind::Raw => apart.min(256.0 - apart) <= slack,
        // Infinity is correct if the number is too large for an `f32`.
        ViewKind::Coef => {
            is_close(expected, received, slack) || f64::from(expected as f32) == received
        }
        ViewKind::Rgb => apart <= COLOR_TOLERANCE + slack + loss,
    }
}

/// Describes the tolerance of the samples of a view.
#[must_use]
pub const fn tolerance_text(view: ViewKind) -> &'static str {
    match view {
        ViewKind::Raw => "none",
        ViewKind::Coef => "1e-5 times the larger value, plus 1e-6",
        ViewKind::Rgb => "each byte within 1 + 1/64 of the exact color",
    }
}

/// Returns true if `|a − b| <= 1e-5 · max(|a|, |b|) + 1e-6 + slack`. The constants allow for one rounding and one multiplication
/// in `f32`. Infinity is close only to itself.
#[must_use]
pub fn is_close(a: f64, b: f64, slack: f64) -> bool {
    let larger = a.abs().max(b.abs());
    a == b || larger.is_finite() && (a - b).abs() <= 1e-5 * larger + 1e-6 + slack
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Difference::Shape { expected, received } => {
                write!(f, "expected {expected}, received {received}")
            }
            Difference::Samples {
                x,
                y,
                channel,
                expected,
                received,
                wrong,
                samples,
            } => {
                let pairs = expected.iter().zip(received);
                let pairs = pairs.map(|(a, b)| <(_, _)>::from(format_distinct(*a, *b, 3)));
                let (expected, received): (Vec<_>, Vec<_>) = pairs.unzip();
                let (expected, received) = (expected.join(" "), received.join(" "));
                write!(
                    f,
                    "texel ({x}, {y}), first in {channel}: expected {expected}, received {received}; "
                )?;
                write!(f, "{wrong} of {samples} samples differ")
            }
        }
    }
}

/// Minimum magnitude at which a large number is printed with an exponent.
const MIN_WITH_EXPONENT: f64 = 1e16;

/// Formats a number with at most `decimals` decimal places, or with an exponent if it is very large or so small that rounding changes
/// it by more than a twentieth.
#[must_use]
pub fn format_short(value: f64, decimals: usize) -> String {
    let unit = 10_f64.powi(decimals as i32);
    let is_coarse = ((value * unit).round() / unit - value).abs() > value.abs() / 20.0;
    if is_coarse || value.is_finite() && value.abs() >= MIN_WITH_EXPONENT {
        return format!("{:e}", value as f32);
    }
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Formats two numbers with at most `decimals` decimal places, or more if different numbers would look equal.
#[must_use]
pub fn format_distinct(a: f64, b: f64, decimals: usize) -> [String; 2] {
    let short = [a, b].map(|value| format_short(value, decimals));
    match short[0] == short[1] && !is_close(a, b, 0.0) {
        true => [a, b].map(|value| (value as f32).to_string()),
        false => short,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(expected: f64, received: f64, near: bool) {
        let is = is_near(ViewKind::Coef, expected, received, 0.0, 0.0);
        assert_eq!(is, near, "{received} for {expected}");
    }

    #[test]
    fn different_numbers_print_differently() {
        assert_eq!(format_distinct(0.5, -0.0, 3), ["0.5", "0"]);
        assert_eq!(format_distinct(0.1, 0.100_000_001, 3), ["0.1", "0.1"]);
        assert_eq!(format_distinct(0.000_068, 24.0, 4), ["6.8e-5", "24"]);
        assert_eq!(
            format_distinct(0.038_086, 0.038_114, 3),
            ["0.038086", "0.038114"]
        );
    }

    #[test]
    fn nan_is_close_to_no_number() {
        check(0.0, 0.0, true);
        check(-53.0, -53.0004, true);
        check(-53.0, -53.001, false);
        for received in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            check(-53.0, received, false);
            check(0.0, received, false);
        }
        check(1e39, f64::INFINITY, true);
        check(1e39, f64::NEG_INFINITY, false);
        check(1e39, f64::from(f32::MAX), false);
    }
}
