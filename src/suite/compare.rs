//! Expected against received.
//!
//! - raw: equal; of lossy JPEG planes on which inverse DCTs may differ, within the model's slack, around the circle of 256
//!   values.
//! - coef: |a − b| ≤ 1e-5 · max(|a|, |b|) + 1e-6, room for one rounding to `f32` and a product in `f32`; and that slack.
//! - rgb: the byte within 1 + 1/64 of the exact color, room for any rounding and for arithmetic in `f32`; in a JPEG picture
//!   within [`LOSSY`] more.

use std::fmt;

use crate::decode::decode_as;
use crate::evaluate;
use crate::protocol::frame::{Frame, Samples, View};
use crate::ptm::{Ptm, Size, channel_name};
use crate::reading::Reading;
use crate::suite::values::{HandValues, Values};

/// What a frame should hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Expected {
    /// Width and height.
    pub size: Size,
    /// Samples of a texel.
    pub channels: usize,
    /// `height * width * channels` of them; colors are not rounded.
    pub values: ExpectedValues,
    /// How far each may be off because inverse DCTs differ; empty where none may.
    pub slack: Vec<f64>,
}

/// The samples that a frame should hold.
#[derive(Clone, Debug, PartialEq)]
pub enum ExpectedValues {
    /// Stored values.
    Raw(Vec<u8>),
    /// Final values.
    Coef(Vec<f64>),
    /// Colors from 0 to 255.
    Rgb(Vec<f64>),
}

/// How far a byte may be from the exact color: one for any rounding, and a little for arithmetic in `f32`.
pub(crate) const COLOR: f64 = 1.0 + 1.0 / 64.0;

/// How much farther a byte of a JPEG picture may be. At quality 95 no sample of the suite's pictures is farther than 29; the rest is
/// for other encoders and their tables.
pub const LOSSY: f64 = 48.0;

impl Expected {
    /// What `values` look like in `view`; nothing where they do not say.
    #[must_use]
    pub fn of(values: &Values, view: &View) -> Option<Expected> {
        match values {
            Values::None | Values::Any => None,
            Values::Painted(model) => {
                let channels = model.format.channels();
                let (channels, values, slack) = match view {
                    View::Raw => (
                        channels,
                        ExpectedValues::Raw(model.samples.clone()),
                        model.slack.iter().map(|&slack| f64::from(slack)).collect(),
                    ),
                    View::Coef => (
                        channels,
                        ExpectedValues::Coef(model.coefficients()),
                        model.coefficient_slack(),
                    ),
                    View::Rgb(light) => (
                        3,
                        ExpectedValues::Rgb(model.picture(light.lu, light.lv)),
                        model.picture_slack(light.lu, light.lv),
                    ),
                };
                Some(Expected {
                    size: model.size,
                    channels,
                    values,
                    slack,
                })
            }
            Values::Hand(hand) => {
                let size: Size = hand.size.parse().ok()?;
                let values = match view {
                    View::Raw => ExpectedValues::Raw(
                        HandValues::numbers(&hand.raw)
                            .iter()
                            .map(|&value| value as u8)
                            .collect(),
                    ),
                    View::Coef => ExpectedValues::Coef(HandValues::numbers(hand.coef.as_ref()?)),
                    View::Rgb(_) => {
                        let picture = hand.rgb.as_ref().filter(|picture| {
                            format!("rgb:{}", picture.light) == view.to_string()
                        })?;
                        ExpectedValues::Rgb(HandValues::numbers(&picture.texels))
                    }
                };
                let count = match &values {
                    ExpectedValues::Raw(values) => values.len(),
                    ExpectedValues::Coef(values) | ExpectedValues::Rgb(values) => values.len(),
                };
                Some(Expected {
                    size,
                    channels: count / size.texels(),
                    values,
                    slack: Vec::new(),
                })
            }
        }
    }

    /// What `file` looks like in `view` under another reading; nothing where that reading refuses it.
    #[must_use]
    pub fn under(file: &[u8], view: &View, reading: &Reading) -> Option<Expected> {
        let Ptm { header, planes } =
            decode_as(file, reading, &crate::ptm::Limits::default()).ok()?;
        let coefficients = evaluate::apply(&header.scale_bias, &planes, reading);
        let (channels, values) = match view {
            View::Raw => (
                planes.shape.channels(),
                ExpectedValues::Raw(planes.samples.clone()),
            ),
            View::Coef => (
                planes.shape.channels(),
                ExpectedValues::Coef(coefficients.values),
            ),
            View::Rgb(light) => (
                3,
                ExpectedValues::Rgb(
                    evaluate::evaluate(&coefficients, light.lu, light.lv, reading).values,
                ),
            ),
        };
        Some(Expected {
            size: header.size,
            channels,
            values,
            slack: Vec::new(),
        })
    }

    /// What a frame holds, expected of another one.
    #[must_use]
    pub fn of_frame(frame: &Frame) -> Expected {
        let reals = |bytes: &[u8]| bytes.iter().map(|&byte| f64::from(byte)).collect();
        let values = match &frame.samples {
            Samples::U8(bytes) if frame.view == "rgb" => ExpectedValues::Rgb(reals(bytes)),
            Samples::U8(bytes) => ExpectedValues::Raw(bytes.clone()),
            Samples::F32(values) => {
                ExpectedValues::Coef(values.iter().map(|&value| f64::from(value)).collect())
            }
        };
        Expected {
            size: Size {
                width: frame.width,
                height: frame.height,
            },
            channels: frame.channels as usize,
            values,
            slack: Vec::new(),
        }
    }

    /// Nothing where `frame` is right, and else where it first is not.
    #[must_use]
    pub fn compare(&self, frame: &Frame) -> Option<Difference> {
        let expected = (
            self.view(),
            self.size.width,
            self.size.height,
            self.channels as u32,
        );
        let received = (frame.view, frame.width, frame.height, frame.channels);
        if expected != received {
            return Some(Difference::Shape {
                expected: self.describe_shape(),
                received: format!(
                    "{} {}x{} with {} channels",
                    frame.view, frame.width, frame.height, frame.channels
                ),
            });
        }
        let loss = if frame.lossy { LOSSY } else { 0.0 };
        match (&self.values, &frame.samples) {
            (ExpectedValues::Raw(expected), Samples::U8(received)) if expected == received => None,
            (ExpectedValues::Raw(_) | ExpectedValues::Rgb(_), Samples::U8(received)) => {
                self.difference(|i| f64::from(received[i]), loss)
            }
            (ExpectedValues::Coef(_), Samples::F32(received)) => {
                self.difference(|i| f64::from(received[i]), loss)
            }
            (_, Samples::U8(_)) => Some(Difference::Shape {
                expected: "samples of type f32".to_owned(),
                received: "u8".to_owned(),
            }),
            (_, Samples::F32(_)) => Some(Difference::Shape {
                expected: "samples of type u8".to_owned(),
                received: "f32".to_owned(),
            }),
        }
    }

    /// Whether `frame` has the stored values of lossy JPEG planes, but as another inverse DCT finds them.
    #[must_use]
    pub fn is_another_transform(&self, frame: &Frame) -> bool {
        match (&self.values, &frame.samples) {
            (ExpectedValues::Raw(expected), Samples::U8(received)) => {
                expected != received && self.compare(frame).is_none()
            }
            _ => false,
        }
    }

    /// What sample `i` should be.
    #[must_use]
    pub fn value(&self, i: usize) -> f64 {
        match &self.values {
            ExpectedValues::Raw(values) => f64::from(values[i]),
            ExpectedValues::Coef(values) | ExpectedValues::Rgb(values) => values[i],
        }
    }

    /// Whether `received` will do for sample `i`.
    #[must_use]
    pub fn is_near(&self, i: usize, received: f64) -> bool {
        self.is_within(i, received, 0.0)
    }

    /// The same of a picture that may have lost so much.
    fn is_within(&self, i: usize, received: f64, loss: f64) -> bool {
        let expected = self.value(i);
        let slack = self.slack.get(i).copied().unwrap_or_default();
        let apart = (expected - received).abs();
        match self.values {
            ExpectedValues::Raw(_) => apart.min(256.0 - apart) <= slack,
            // Infinity is right where no f32 holds the number.
            ExpectedValues::Coef(_) => {
                is_close(expected, received, slack) || f64::from(expected as f32) == received
            }
            ExpectedValues::Rgb(_) => apart <= COLOR + slack + loss,
        }
    }

    /// How many samples there are.
    fn count(&self) -> usize {
        match &self.values {
            ExpectedValues::Raw(values) => values.len(),
            ExpectedValues::Coef(values) | ExpectedValues::Rgb(values) => values.len(),
        }
    }

    pub(crate) fn view(&self) -> &'static str {
        match self.values {
            ExpectedValues::Raw(_) => "raw",
            ExpectedValues::Coef(_) => "coef",
            ExpectedValues::Rgb(_) => "rgb",
        }
    }

    fn describe_shape(&self) -> String {
        format!(
            "{} {} with {} channels",
            self.view(),
            self.size,
            self.channels
        )
    }

    fn difference(&self, received: impl Fn(usize) -> f64, loss: f64) -> Option<Difference> {
        let samples = self.count();
        let mut wrong = (0..samples).filter(|&i| !self.is_within(i, received(i), loss));
        let first = wrong.next()?;
        let texel = first / self.channels;
        let channels = texel * self.channels..(texel + 1) * self.channels;
        Some(Difference::Samples {
            x: texel % self.size.width as usize,
            y: texel / self.size.width as usize,
            channel: channel_name(self.channels, first % self.channels),
            expected: channels.clone().map(|i| self.value(i)).collect(),
            received: channels.map(&received).collect(),
            wrong: 1 + wrong.count(),
            samples,
        })
    }
}

/// Where a frame first differs from what it should be.
#[derive(Clone, Debug, PartialEq)]
pub enum Difference {
    /// Another view, size, number of channels or type.
    Shape {
        /// What it should be.
        expected: String,
        /// What it is.
        received: String,
    },
    /// Other samples.
    Samples {
        /// Column of the first texel that differs, from the left.
        x: usize,
        /// Its row, from the top.
        y: usize,
        /// Its first channel that differs.
        channel: String,
        /// All channels of that texel.
        expected: Vec<f64>,
        /// The same, as received.
        received: Vec<f64>,
        /// How many samples differ.
        wrong: usize,
        /// Of how many.
        samples: usize,
    },
}

/// Whether final values are the same but for one rounding to `f32`, a product in `f32`, and `slack`. Nothing finite is
/// close to infinity.
pub(crate) fn is_close(a: f64, b: f64, slack: f64) -> bool {
    let larger = a.abs().max(b.abs());
    a == b || larger.is_finite() && (a - b).abs() <= 1e-5 * larger + 1e-6 + slack
}

impl Difference {
    /// Which part of the samples is right, from 0 to 1; of another shape none is.
    #[must_use]
    pub fn likeness(&self) -> f64 {
        match self {
            Difference::Shape { .. } => 0.0,
            Difference::Samples { wrong, samples, .. } => 1.0 - *wrong as f64 / *samples as f64,
        }
    }
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
                let pairs = pairs.map(|(expected, received)| apart(*expected, *received, 3));
                let (expected, received): (Vec<_>, Vec<_>) = pairs
                    .map(|[expected, received]| (expected, received))
                    .unzip();
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

/// From here on numbers have an exponent.
const HUGE: f64 = 1e16;

/// A number with at most so many decimals; one that they would lose, or that has too many digits, with an exponent.
pub(crate) fn short(value: f64, decimals: usize) -> String {
    let is_tiny = value != 0.0 && value.abs() * 10_f64.powi(decimals as i32) < 0.5;
    if is_tiny || value.is_finite() && value.abs() >= HUGE {
        return format!("{:e}", value as f32);
    }
    let text = format!("{value:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Two numbers with at most so many decimals; with more where they would look the same and are not.
pub(crate) fn apart(a: f64, b: f64, decimals: usize) -> [String; 2] {
    let short = [a, b].map(|value| short(value, decimals));
    match short[0] == short[1] && !is_close(a, b, 0.0) {
        true => [a, b].map(|value| (value as f32).to_string()),
        false => short,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn is_near(expected: f64, received: f64, near: bool) {
        let one = Expected {
            size: Size {
                width: 1,
                height: 1,
            },
            channels: 1,
            values: ExpectedValues::Coef(vec![expected]),
            slack: Vec::new(),
        };
        assert_eq!(one.is_near(0, received), near, "{received} for {expected}");
    }

    #[test]
    fn numbers_that_differ_look_different() {
        assert_eq!(apart(0.5, -0.0, 3), ["0.5", "0"]);
        assert_eq!(apart(0.1, 0.100_000_001, 3), ["0.1", "0.1"]);
        assert_eq!(apart(0.038_086, 0.038_114, 3), ["0.038086", "0.038114"]);
    }

    #[test]
    fn what_is_no_number_is_near_to_nothing() {
        is_near(0.0, 0.0, true);
        is_near(-53.0, -53.0004, true);
        is_near(-53.0, -53.001, false);
        for received in [f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
            is_near(-53.0, received, false);
            is_near(0.0, received, false);
        }
        is_near(1e39, f64::INFINITY, true);
        is_near(1e39, f64::NEG_INFINITY, false);
        is_near(1e39, f64::from(f32::MAX), false);
    }
}
