//! PTM-CP 1: what a decoder is asked and how it answers.
//!
//! `DECODER [ARG…] VIEW FILE`; on standard output one line and the samples,
//!
//! ```text
//! PTM1 <raw|coef|rgb> <width> <height> <channels> <u8|f32>\n
//! ```
//!
//! texel after texel, top row first, `f32` low byte first; and an exit status: 0, 65 (malformed) or 69 (unsupported).

use std::fmt;
use std::io::{self, Write};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::decode::{Ptm, Stored};
use crate::harness::shards::frame_text;
use crate::ptm::Size;

/// Exit status of a decoder that finds the file malformed (`EX_DATAERR`).
pub const EXIT_MALFORMED: i32 = 65;
/// Exit status of a decoder that does not read such files (`EX_UNAVAILABLE`).
pub const EXIT_UNSUPPORTED: i32 = 69;

/// What a decoder is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum View {
    /// The stored values; u8.
    Raw,
    /// The final values; f32.
    Coef,
    /// The picture under a light; u8.
    Rgb(Light),
}

/// A direction of light.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// To the right.
    pub lu: f64,
    /// Up.
    pub lv: f64,
    text: String,
}

impl View {
    /// A light that shows every coefficient.
    pub const ORDINARY_LIGHT: &'static str = "rgb:0.3125,-0.4375";

    /// `raw`, `coef` or `rgb`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            View::Raw => "raw",
            View::Coef => "coef",
            View::Rgb(_) => "rgb",
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            View::Rgb(light) => write!(f, "rgb:{}", light.text),
            other => f.write_str(other.name()),
        }
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<View, String> {
        let unknown = || {
            format!(
                "unknown view {text:?}; views are raw, coef and rgb:LU,LV, for example rgb:0.25,-0.5"
            )
        };
        match text {
            "raw" => Ok(View::Raw),
            "coef" => Ok(View::Coef),
            _ => {
                let light = text.strip_prefix("rgb:").ok_or_else(unknown)?;
                let (lu, lv) = light.split_once(',').ok_or_else(unknown)?;
                match (lu.parse::<f64>(), lv.parse::<f64>()) {
                    (Ok(lu), Ok(lv)) if lu.is_finite() && lv.is_finite() => Ok(View::Rgb(Light {
                        lu,
                        lv,
                        text: light.to_owned(),
                    })),
                    _ => Err(unknown()),
                }
            }
        }
    }
}

/// One answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// `raw`, `coef` or `rgb`.
    pub view: &'static str,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples of a texel.
    pub channels: u32,
    /// `height * width * channels` of them.
    pub samples: Samples,
}

/// The samples of a frame, texel after texel, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Bytes.
    U8(Vec<u8>),
    /// Reals.
    F32(Vec<f32>),
}

impl Samples {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Samples::U8(bytes) => bytes.len(),
            Samples::F32(values) => values.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// How many bytes they take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Samples::U8(bytes) => bytes.len(),
            Samples::F32(values) => 4 * values.len(),
        }
    }

    /// Whether they are bit for bit the same.
    #[must_use]
    pub fn are_like(&self, other: &Samples) -> bool {
        match (self, other) {
            (Samples::U8(a), Samples::U8(b)) => a == b,
            (Samples::F32(a), Samples::F32(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
            }
            _ => false,
        }
    }
}

impl Frame {
    /// Whether it is bit for bit the same; no number but itself is like one that is none.
    #[must_use]
    pub fn is_like(&self, other: &Frame) -> bool {
        let shape = |frame: &Frame| (frame.view, frame.width, frame.height, frame.channels);
        shape(self) == shape(other) && self.samples.are_like(&other.samples)
    }

    /// What `ptm` looks like in `view`, under the reading of the reference.
    #[must_use]
    pub fn of(ptm: &Ptm, view: &View) -> Frame {
        Frame::under(ptm, view, &crate::Reading::SPEC)
    }

    /// What `ptm` looks like in `view` under a reading.
    pub(crate) fn under(ptm: &Ptm, view: &View, reading: &crate::Reading) -> Frame {
        let coefficients = || crate::evaluate::apply(&ptm.header.scale_bias, &ptm.planes, reading);
        let channels = ptm.planes.shape.channels() as u32;
        let (channels, samples) = match view {
            View::Raw => (channels, Samples::U8(ptm.planes.samples.clone())),
            View::Coef => (
                channels,
                Samples::F32(
                    coefficients()
                        .values
                        .iter()
                        .map(|&value| value as f32)
                        .collect(),
                ),
            ),
            View::Rgb(light) => {
                let picture =
                    crate::evaluate::evaluate(&coefficients(), light.lu, light.lv, reading);
                (3, Samples::U8(picture.to_bytes()))
            }
        };
        Frame {
            view: view.name(),
            width: ptm.planes.size.width,
            height: ptm.planes.size.height,
            channels,
            samples,
        }
    }

    /// Writes the line and the samples.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let size = Size {
            width: self.width,
            height: self.height,
        };
        self.write_line(size, out)?;
        self.write_samples(out)
    }

    /// The line of a frame of that size.
    fn write_line(&self, size: Size, out: &mut impl Write) -> io::Result<()> {
        let Size { width, height } = size;
        let kind = if matches!(self.samples, Samples::U8(_)) {
            "u8"
        } else {
            "f32"
        };
        writeln!(
            out,
            "PTM1 {} {width} {height} {} {kind}",
            self.view, self.channels
        )
    }

    fn write_samples(&self, out: &mut impl Write) -> io::Result<()> {
        match &self.samples {
            Samples::U8(bytes) => out.write_all(bytes),
            Samples::F32(values) => values
                .iter()
                .try_for_each(|value| out.write_all(&value.to_le_bytes())),
        }
    }

    /// Reads exactly one frame.
    ///
    /// # Errors
    /// A sentence that says what keeps `bytes` from being one.
    pub fn read(bytes: &[u8]) -> Result<Frame, String> {
        if bytes.is_empty() {
            return Err("standard output is empty".to_owned());
        }
        let beginning = bytes[..bytes.len().min(24)].escape_ascii();
        if !bytes.starts_with(b"PTM1 ") {
            return Err(format!(
                "standard output begins with \"{beginning}\" instead of a PTM1 line"
            ));
        }
        let end = bytes
            .iter()
            .take(200)
            .position(|&byte| byte == b'\n')
            .ok_or("the PTM1 line has no end")?;
        let line = std::str::from_utf8(&bytes[..end]).map_err(|_| "the PTM1 line is not ASCII")?;
        if line.ends_with('\r') {
            return Err("the PTM1 line ends in CR LF: is standard output in text mode?".to_owned());
        }
        let words: Vec<&str> = line.split(' ').collect();
        let [_, view, width, height, channels, kind] = words[..] else {
            return Err(format!(
                "{line:?} is not \"PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE\""
            ));
        };
        let view = ["raw", "coef", "rgb"]
            .into_iter()
            .find(|&known| known == view)
            .ok_or_else(|| format!("unknown view in {line:?}"))?;
        let number = |word: &str| {
            let digits = word
                .bytes()
                .all(|byte| byte.is_ascii_digit())
                .then(|| word.parse::<u32>().ok())
                .flatten();
            digits.ok_or_else(|| format!("{word:?} in {line:?} is not a number"))
        };
        let (width, height, channels) = (number(width)?, number(height)?, number(channels)?);
        if [width, height, channels].contains(&0) {
            return Err(format!("{line:?} announces a picture without a texel"));
        }
        let size = match kind {
            "u8" => 1,
            "f32" => 4,
            _ => return Err(format!("unknown type in {line:?}; types are u8 and f32")),
        };
        let samples = &bytes[end + 1..];
        let needed = [width, height, channels]
            .into_iter()
            .try_fold(size, |product: usize, n| product.checked_mul(n as usize));
        if needed != Some(samples.len()) {
            let needed = needed.map_or("more bytes than can be counted".to_owned(), |needed| {
                format!("{needed} bytes")
            });
            let cut = if samples.len() + end + 1 >= 65_536
                && (samples.len() + end + 1).is_multiple_of(65_536)
            {
                "; the output is cut at a multiple of 65,536: does the program exit before its output is flushed?"
            } else {
                ""
            };
            return Err(format!(
                "{line:?} announces {needed} of samples, {} follow{cut}",
                samples.len()
            ));
        }
        let samples = match kind {
            "u8" => Samples::U8(samples.to_vec()),
            _ => Samples::F32(
                samples
                    .chunks_exact(4)
                    .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
                    .collect(),
            ),
        };
        Ok(Frame {
            view,
            width,
            height,
            channels,
            samples,
        })
    }
}

/// Writes the frame of a map in `view`, piece by piece: the samples of a frame are those of its pieces, one after another.
///
/// # Errors
/// Those of `out`.
pub fn write_view(map: &Stored<'_>, view: &View, out: &mut impl Write) -> io::Result<()> {
    for (i, piece) in map.pieces().enumerate() {
        let frame = Frame::of(&piece, view);
        if i == 0 {
            frame.write_line(map.header.size, out)?;
        }
        frame.write_samples(out)?;
    }
    Ok(())
}

/// What a decoder did with a request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// Exit status 0 and one frame.
    Decoded(#[serde(with = "frame_text")] Frame),
    /// Exit status 65.
    Rejected,
    /// Exit status 69.
    Unsupported,
    /// Exit status 0 and something else than one frame.
    ProtocolError(String),
    /// A signal, or any other exit status.
    Crashed(String),
    /// No end within the time limit.
    Hung(String),
    /// More output than any frame of that file could have.
    Flooded(String),
    /// More memory than it may hold.
    OutOfMemory(String),
    /// It changed or removed the file it was given.
    Tampered(String),
    /// The operating system could not start it.
    NotStarted(String),
}

impl Answer {
    /// One or two words for a report.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Answer::Decoded(_) => "decoded",
            Answer::Rejected => "rejected",
            Answer::Unsupported => "unsupported",
            Answer::ProtocolError(_) => "protocol error",
            Answer::Crashed(_) => "crash",
            Answer::Hung(_) => "hang",
            Answer::Flooded(_) => "flood",
            Answer::OutOfMemory(_) => "out of memory",
            Answer::Tampered(_) => "tampering",
            Answer::NotStarted(_) => "not started",
        }
    }

    /// Whether it is the same in all that a decoder is responsible for: pictures bit for bit, mishaps by their kind.
    #[must_use]
    pub fn is_like(&self, other: &Answer) -> bool {
        match (self, other) {
            (Answer::Decoded(a), Answer::Decoded(b)) => a.is_like(b),
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// What went wrong, where that is neither a picture nor a refusal.
    #[must_use]
    pub fn misconduct(&self) -> Option<&str> {
        match self {
            Answer::Decoded(_) | Answer::Rejected | Answer::Unsupported => None,
            Answer::ProtocolError(what)
            | Answer::Crashed(what)
            | Answer::Hung(what)
            | Answer::Flooded(what)
            | Answer::OutOfMemory(what)
            | Answer::Tampered(what)
            | Answer::NotStarted(what) => Some(what),
        }
    }
}
