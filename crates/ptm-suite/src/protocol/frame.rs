//! PTM-CP 1: requests to a decoder and its responses.
//!
//! `DECODER [ARG…] VIEW FILE` writes one line and the samples to standard output:
//!
//! ```text
//! PTM1 <raw|coef|rgb> <width> <height> <channels> <u8|f32>\n
//! ```
//!
//! The samples follow texel by texel, top row first; `f32` is little-endian. Exit status: 0, 65 (malformed), 69 (unsupported).

use std::borrow::Cow;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::io::{self, Write};
use std::str::FromStr;
use std::time::Duration;

use data_encoding::HEXLOWER;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{Error, Result};
use ptm::decode::StoredMap;
use ptm::error::byte_count;
use ptm::evaluate::{compute_coefficients, evaluate};
use ptm::reading::Reading;
use ptm::{Ptm, Size};

/// Exit status of a decoder for a malformed file (`EX_DATAERR`).
pub const EXIT_MALFORMED: i32 = 65;
/// Exit status of a decoder for a file that it does not support (`EX_UNAVAILABLE`).
pub const EXIT_UNSUPPORTED: i32 = 69;

/// A view: the representation of a map that is requested from a decoder.
#[derive(Clone, Debug, PartialEq)]
pub enum View {
    /// The stored values.
    Raw,
    /// The final values.
    Coef,
    /// The image under a light.
    Rgb(Light),
}

/// A view without its light, as named in the PTM1 line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ViewKind {
    /// Stored values, of type `u8`.
    Raw,
    /// Final values, of type `f32`.
    Coef,
    /// Colors, of type `u8`.
    Rgb,
}

impl ViewKind {
    /// All kinds of views.
    pub const ALL: [ViewKind; 3] = [ViewKind::Raw, ViewKind::Coef, ViewKind::Rgb];
    /// Names of all kinds of views.
    pub const NAMES: [&'static str; 3] = ["raw", "coef", "rgb"];

    /// Returns `raw`, `coef` or `rgb`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        ViewKind::NAMES[self as usize]
    }

    /// Returns the kind of view with the given name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<ViewKind> {
        ViewKind::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns the name of the sample type.
    #[must_use]
    pub const fn sample_type(self) -> &'static str {
        match self {
            ViewKind::Coef => "f32",
            ViewKind::Raw | ViewKind::Rgb => "u8",
        }
    }

    /// Returns the clause that defines the values of this view.
    #[must_use]
    pub const fn clause(self) -> &'static str {
        match self {
            ViewKind::Raw => "2.7/1",
            ViewKind::Coef => "2.4/8",
            ViewKind::Rgb => "1.0/1",
        }
    }

    /// Returns the number of samples per texel of a map with `channels` channels.
    #[must_use]
    pub const fn channels(self, channels: usize) -> usize {
        match self {
            ViewKind::Rgb => 3,
            ViewKind::Raw | ViewKind::Coef => channels,
        }
    }

    /// Converts values to the sample type of this view, rounding if necessary.
    #[must_use]
    pub fn samples(self, values: &[f64]) -> Samples {
        match self.sample_type() {
            "f32" => Samples::F32(values.iter().map(|&value| value as f32).collect()),
            _ => Samples::U8(values.iter().map(|value| value.round() as u8).collect()),
        }
    }
}

impl fmt::Display for ViewKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A light direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Horizontal component, positive to the right.
    pub lu: f64,
    /// Vertical component, positive upward.
    pub lv: f64,
    text: String,
}

impl Light {
    /// Returns `lu` and `lv` as spelled in the request.
    #[must_use]
    pub fn texts(&self) -> [&str; 2] {
        let (u, v) = self.text.split_once(',').unwrap_or((&self.text, ""));
        [u, v]
    }
}

impl View {
    /// A view with a light under which every coefficient affects the color.
    pub const DEFAULT_RGB: &'static str = "rgb:0.3125,-0.4375";

    /// Returns the view without its light.
    #[must_use]
    pub const fn kind(&self) -> ViewKind {
        match self {
            View::Raw => ViewKind::Raw,
            View::Coef => ViewKind::Coef,
            View::Rgb(_) => ViewKind::Rgb,
        }
    }

    /// Returns `raw`, `coef` or `rgb`.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.kind().name()
    }

    /// Returns the values of all samples of `ptm` in this view under a reading. Colors are not rounded.
    #[must_use]
    pub fn values(&self, ptm: &Ptm, reading: &Reading) -> Vec<f64> {
        let finals = || compute_coefficients(&ptm.header.scale_bias, &ptm.planes, reading);
        match self {
            View::Raw => ptm.planes.samples.iter().copied().map(f64::from).collect(),
            View::Coef => finals().values,
            View::Rgb(Light { lu, lv, .. }) => evaluate(&finals(), *lu, *lv, reading).values,
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
    type Err = Error;

    fn from_str(text: &str) -> Result<View> {
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
                    (Ok(lu), Ok(lv)) if lu.hypot(lv) > 1.0 => Error::invalid(format!(
                        "the light vector in {text:?} is longer than 1; it must be the projection of a unit vector"
                    )),
                    (Ok(lu), Ok(lv)) if lu.is_finite() && lv.is_finite() => Ok(View::Rgb(Light {
                        lu,
                        lv,
                        text: light.to_owned(),
                    })),
                    _ => Err(unknown().into()),
                }
            }
        }
    }
}

/// Maximum length, in bytes, of a PTM1 line.
const MAX_LINE_LENGTH: usize = 200;

/// The output of a decoder for one view of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Kind of view that the samples represent.
    pub view: ViewKind,
    /// Number of texels in a row.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
    /// Number of samples per texel.
    pub channels: u32,
    /// `height * width * channels` samples.
    pub samples: Samples,
    /// True if the samples were compressed lossily, as in a JPEG image.
    pub lossy: bool,
}

/// The samples of a frame, texel by texel, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Samples of type `u8`.
    U8(Vec<u8>),
    /// Samples of type `f32`.
    F32(Vec<f32>),
}

impl Samples {
    /// Parses bytes or little-endian floats. `shape` is the width, the height and the number of channels.
    ///
    /// # Errors
    /// Returns the number of bytes that the shape needs if `bytes` has another length.
    pub(crate) fn parse(is_float: bool, shape: [u32; 3], bytes: &[u8]) -> Result<Samples, u64> {
        let size = if is_float { 4 } else { 1 };
        let needed = (shape.into_iter()).fold(size, |bytes: u64, n| bytes.saturating_mul(n.into()));
        if needed != bytes.len() as u64 {
            return Err(needed);
        }
        if !is_float {
            return Ok(Samples::U8(bytes.to_vec()));
        }
        let values = bytes.as_chunks::<4>().0.iter();
        Ok(Samples::F32(
            values.copied().map(f32::from_le_bytes).collect(),
        ))
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Samples::U8(bytes) => bytes.len(),
            Samples::F32(values) => values.len(),
        }
    }

    /// Returns true if there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the value of sample `i`.
    #[must_use]
    pub fn real(&self, i: usize) -> f64 {
        match self {
            Samples::U8(bytes) => f64::from(bytes[i]),
            Samples::F32(values) => f64::from(values[i]),
        }
    }

    /// Converts all samples to real numbers.
    #[must_use]
    pub fn to_reals(&self) -> Vec<f64> {
        (0..self.len()).map(|i| self.real(i)).collect()
    }

    /// Returns `u8` or `f32`.
    #[must_use]
    pub const fn sample_type(&self) -> &'static str {
        match self {
            Samples::U8(_) => "u8",
            Samples::F32(_) => "f32",
        }
    }

    /// Returns the size of the samples in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match self {
            Samples::U8(bytes) => bytes.len(),
            Samples::F32(values) => 4 * values.len(),
        }
    }
}

impl Hash for Samples {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        match self {
            Samples::U8(bytes) => bytes.hash(hasher),
            Samples::F32(values) => {
                // One call for many values takes less time.
                for values in values.chunks(64) {
                    let mut bytes = [0; 4 * 64];
                    let fields = bytes.chunks_exact_mut(4).zip(values);
                    fields.for_each(|(field, value)| field.copy_from_slice(&value.to_le_bytes()));
                    hasher.write(&bytes[..4 * values.len()]);
                }
            }
        }
    }
}

impl Hash for Frame {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.shape().hash(hasher);
        self.samples.hash(hasher);
    }
}

impl Frame {
    /// Creates a frame of this width, height and number of channels, whose samples were not compressed lossily.
    #[must_use]
    pub fn exact(view: ViewKind, shape: [u32; 3], samples: Samples) -> Frame {
        let [width, height, channels] = shape;
        Frame {
            view,
            width,
            height,
            channels,
            samples,
            lossy: false,
        }
    }

    /// Returns true if both frames are bitwise equal. A NaN equals only a NaN with the same bits.
    #[must_use]
    pub fn is_equivalent(&self, other: &Frame) -> bool {
        self.shape() == other.shape()
            && match (&self.samples, &other.samples) {
                (Samples::U8(a), Samples::U8(b)) => a == b,
                (Samples::F32(a), Samples::F32(b)) => {
                    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
                }
                _ => false,
            }
    }

    /// Returns the view, the width, the height and the number of channels.
    #[must_use]
    pub const fn shape(&self) -> (ViewKind, u32, u32, u32) {
        (self.view, self.width, self.height, self.channels)
    }

    /// Renders `ptm` in `view` under the reference's reading.
    #[must_use]
    pub fn render(ptm: &Ptm, view: &View) -> Frame {
        let samples = if *view == View::Raw {
            // Bytes are copied without a conversion to real numbers.
            Samples::U8(ptm.planes.samples.clone())
        } else {
            view.kind().samples(&view.values(ptm, &Reading::SPEC))
        };
        Frame::of_map(ptm, view, samples)
    }

    /// Returns the frame of the map `ptm` with the given samples: all its texels, with the channels of the view.
    #[must_use]
    pub fn of_map(ptm: &Ptm, view: &View, samples: Samples) -> Frame {
        let (kind, size) = (view.kind(), ptm.planes.size);
        let channels = kind.channels(ptm.planes.shape.channels()) as u32;
        Frame::exact(kind, [size.width, size.height, channels], samples)
    }

    /// Writes the PTM1 line and the samples.
    ///
    /// # Errors
    /// Returns an error if `out` cannot be written.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let (width, height) = (self.width, self.height);
        self.write_line(Size { width, height }, out)?;
        self.write_samples(out)
    }

    /// Returns the PTM1 line and the samples as bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write(&mut bytes)
            .expect("writing to memory does not fail");
        bytes
    }

    /// Writes the PTM1 line of a frame of the given size. `self` may be only a piece of that frame.
    fn write_line(&self, size: Size, out: &mut impl Write) -> io::Result<()> {
        let (view, channels, Size { width, height }) = (self.view, self.channels, size);
        let kind = self.samples.sample_type();
        writeln!(out, "PTM1 {view} {width} {height} {channels} {kind}")
    }

    fn write_samples(&self, out: &mut impl Write) -> io::Result<()> {
        match &self.samples {
            Samples::U8(bytes) => out.write_all(bytes),
            Samples::F32(values) => values
                .iter()
                .try_for_each(|value| out.write_all(&value.to_le_bytes())),
        }
    }

    /// Parses exactly one frame.
    ///
    /// # Errors
    /// Returns the reason why `bytes` is not a frame.
    pub fn read(bytes: &[u8]) -> Result<Frame> {
        if bytes.is_empty() {
            return Error::invalid("standard output is empty");
        }
        if !bytes.starts_with(b"PTM1 ") {
            let beginning = bytes[..bytes.len().min(24)].escape_ascii();
            return Error::invalid(format!(
                "standard output begins with \"{beginning}\" instead of a PTM1 line"
            ));
        }
        let mut beginning = bytes.iter().take(MAX_LINE_LENGTH);
        let end = beginning.position(|&byte| byte == b'\n');
        let end = end.ok_or("the PTM1 line does not end in a line feed")?;
        let line = std::str::from_utf8(&bytes[..end]).map_err(|_| "the PTM1 line is not ASCII")?;
        let mut frame = Frame::parse_line(line)?;
        let samples = &bytes[end + 1..];
        let shape = [frame.width, frame.height, frame.channels];
        let is_float = matches!(frame.samples, Samples::F32(_));
        frame.samples = Samples::parse(is_float, shape, samples).map_err(|needed| {
            let is_cut = (samples.len() as u64) < needed && bytes.len().is_multiple_of(65_536);
            let needed = byte_count(needed);
            let hint = match is_cut {
                true => {
                    "; the output is truncated at a multiple of 65,536 bytes; does the program exit before its output is flushed?"
                }
                false => "",
            };
            format!(
                "{line:?} announces {needed} of samples, but {} follow{hint}",
                samples.len()
            )
        })?;
        Ok(frame)
    }

    /// Parses a PTM1 line into a frame without samples.
    fn parse_line(line: &str) -> Result<Frame> {
        if line.ends_with('\r') {
            return Error::invalid("the PTM1 line ends in CR LF; is standard output in text mode?");
        }
        let words: Vec<&str> = line.split(' ').collect();
        let [_, view, width, height, channels, kind] = words[..] else {
            return Error::invalid(format!(
                "{line:?} is not \"PTM1 VIEW WIDTH HEIGHT CHANNELS TYPE\""
            ));
        };
        let view = ViewKind::from_name(view).ok_or_else(|| format!("unknown view in {line:?}"))?;
        let number = |word: &str| {
            let is_digits = word.bytes().all(|byte| byte.is_ascii_digit());
            let number = is_digits.then(|| word.parse::<u32>().ok()).flatten();
            number.ok_or_else(|| format!("{word:?} in {line:?} is not a number"))
        };
        let shape = [number(width)?, number(height)?, number(channels)?];
        if shape.contains(&0) {
            return Error::invalid(format!("{line:?} announces an image without texels"));
        }
        let samples = match kind {
            "u8" => Samples::U8(Vec::new()),
            "f32" => Samples::F32(Vec::new()),
            _ => return Error::invalid(format!("unknown type in {line:?}; types are u8 and f32")),
        };
        Ok(Frame::exact(view, shape, samples))
    }
}

/// Writes the frame of a map in `view` in pieces, so that the whole frame is never in memory.
///
/// # Errors
/// Returns an error if `out` cannot be written.
pub fn write_view(map: &StoredMap<'_>, view: &View, out: &mut impl Write) -> io::Result<()> {
    for (i, piece) in map.pieces().enumerate() {
        let frame = Frame::render(&piece, view);
        if i == 0 {
            frame.write_line(map.header.size, out)?;
        }
        frame.write_samples(out)?;
    }
    Ok(())
}

/// The result of one request: a frame for a PTM file, or `T` for another kind of request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer<T = Frame> {
    /// Exit status 0 and the requested output.
    Decoded(T),
    /// Exit status 65: the decoder considers the file malformed.
    Rejected,
    /// Exit status 69: the decoder does not support the file.
    Unsupported,
    /// Exit status 0 and output that is not exactly one frame.
    ProtocolError(String),
    /// The decoder was killed by a signal, or exited with any other status.
    Crashed(String),
    /// The decoder exceeded this time limit.
    TimedOut(TimeLimit),
    /// The decoder wrote more output than the largest possible frame for the file.
    Flooded(String),
    /// The decoder used more memory than allowed.
    OutOfMemory(String),
    /// The decoder changed or removed its input file.
    Tampered(String),
    /// The operating system could not start the decoder.
    NotStarted(String),
    /// This program could not send the request, so nothing is known about the decoder.
    NotAsked(String),
}

/// A wall-clock limit that a call exceeded. It is a fact about the run, not only about the decoder: the machine may be busy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TimeLimit(pub Duration);

impl fmt::Display for TimeLimit {
    /// Writes a verb phrase that takes the decoder or the file as its subject.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.as_secs_f64();
        write!(f, "exceeds the time limit of {seconds} s (`--timeout`)")
    }
}

/// The way in which a crashed process ended. Its text form is part of the report format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProcessEnd {
    /// Exit status.
    Status(i32),
    /// Number of the signal that killed the process.
    Signal(i32),
}

impl ProcessEnd {
    /// Parses the details of [`Answer::Crashed`]. Returns `None` if they do not describe how a single process ended.
    #[must_use]
    pub fn parse(details: &str) -> Option<ProcessEnd> {
        let (words, number) = details.rsplit_once(' ')?;
        let number = number.parse().ok()?;
        match words {
            "exit status" => Some(ProcessEnd::Status(number)),
            "killed by signal" => Some(ProcessEnd::Signal(number)),
            _ => None,
        }
    }
}

impl fmt::Display for ProcessEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ProcessEnd::Status(status) => write!(f, "exit status {status}"),
            ProcessEnd::Signal(signal) => write!(f, "killed by signal {signal}"),
        }
    }
}

impl<T> Answer<T> {
    /// Returns the decoded value, or any other answer as an `Answer<U>`.
    ///
    /// # Errors
    /// Returns any answer other than [`Answer::Decoded`].
    pub fn decoded<U>(self) -> Result<T, Answer<U>> {
        Err(match self {
            Answer::Decoded(decoded) => return Ok(decoded),
            Answer::Rejected => Answer::Rejected,
            Answer::Unsupported => Answer::Unsupported,
            Answer::ProtocolError(details) => Answer::ProtocolError(details),
            Answer::Crashed(details) => Answer::Crashed(details),
            Answer::TimedOut(limit) => Answer::TimedOut(limit),
            Answer::Flooded(details) => Answer::Flooded(details),
            Answer::OutOfMemory(details) => Answer::OutOfMemory(details),
            Answer::Tampered(details) => Answer::Tampered(details),
            Answer::NotStarted(details) => Answer::NotStarted(details),
            Answer::NotAsked(details) => Answer::NotAsked(details),
        })
    }

    /// Returns a short name of the answer, for reports.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Answer::Decoded(_) => "decoded",
            Answer::Rejected => "rejected",
            Answer::Unsupported => "unsupported",
            Answer::ProtocolError(_) => "protocol error",
            Answer::Crashed(_) => "crash",
            Answer::TimedOut(_) => "timeout",
            Answer::Flooded(_) => "flood",
            Answer::OutOfMemory(_) => "out of memory",
            Answer::Tampered(_) => "tampering",
            Answer::NotStarted(_) => "not started",
            Answer::NotAsked(_) => "not asked",
        }
    }

    /// Returns the name of the answer. If the answer is a violation, the details follow.
    #[must_use]
    pub fn describe(&self) -> String {
        match (self, self.violation()) {
            (Answer::TimedOut(limit), _) => limit.to_string(),
            (_, Some(details)) => format!("{}: {details}", self.name()),
            (_, None) => self.name().to_owned(),
        }
    }

    /// Returns the details of a violation, or `None` for an image or a refusal.
    #[must_use]
    pub fn violation(&self) -> Option<Cow<'_, str>> {
        match self {
            Answer::Decoded(_) | Answer::Rejected | Answer::Unsupported => None,
            Answer::TimedOut(limit) => Some(limit.to_string().into()),
            Answer::ProtocolError(details)
            | Answer::Crashed(details)
            | Answer::Flooded(details)
            | Answer::OutOfMemory(details)
            | Answer::Tampered(details)
            | Answer::NotStarted(details)
            | Answer::NotAsked(details) => Some(details.into()),
        }
    }

    /// Returns true if both answers are of the same kind. All exceeded limits count as one kind, because timing determines which
    /// one is exceeded first.
    #[must_use]
    pub fn is_same_kind_as(&self, other: &Answer<T>) -> bool {
        let is_limit = |answer: &Answer<T>| {
            matches!(
                answer,
                Answer::TimedOut(_) | Answer::Flooded(_) | Answer::OutOfMemory(_)
            )
        };
        is_limit(self) && is_limit(other)
            || std::mem::discriminant(self) == std::mem::discriminant(other)
    }
}

impl Answer {
    /// Returns true if the answers agree in everything that the decoder controls: images bitwise, failures by kind.
    #[must_use]
    pub fn is_equivalent(&self, other: &Answer) -> bool {
        match (self, other) {
            (Answer::Decoded(a), Answer::Decoded(b)) => a.is_equivalent(b),
            _ => self.is_same_kind_as(other),
        }
    }
}

/// Prefix of the hexadecimal text of a lossy frame.
const LOSSY_PREFIX: &str = "lossy ";

/// Serializes a frame as hexadecimal text.
impl Serialize for Frame {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mark = if self.lossy { LOSSY_PREFIX } else { "" };
        let digits = HEXLOWER.encode(&self.to_bytes());
        serializer.serialize_str(&format!("{mark}{digits}"))
    }
}

impl<'de> Deserialize<'de> for Frame {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Frame, D::Error> {
        let text = String::deserialize(deserializer)?;
        let lossy = text.starts_with(LOSSY_PREFIX);
        let digits = text.trim_start_matches(LOSSY_PREFIX);
        let bytes = HEXLOWER.decode(digits.as_bytes());
        let bytes = bytes.map_err(|_| D::Error::custom("a frame is not hexadecimal"))?;
        let frame = Frame::read(&bytes).map_err(D::Error::custom)?;
        Ok(Frame { lossy, ..frame })
    }
}
