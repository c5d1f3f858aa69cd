//! Kinds of files that the reference refuses, although some readers open them.
//!
//! For such a file, a [`StandIn`] is a legal file that is read in the same way by a reader that opens the kind. It makes the correct
//! image known, and with it the effect of the other misreadings of the reader.

use serde::{Deserialize, Serialize};

use crate::dissection::{Dissection, FilePart, Role};
use crate::segments::{frame, segments};
use ptm::decode::decode;
use ptm::{Coding, Format};

/// A kind of file that the reference refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum UnusualKind {
    /// The first line is `PTM_1.1`. An LRGB file of this version has nine interleaved bytes per texel.
    #[serde(rename = "version-1.1")]
    Version11,
    /// The lines of the header end in CR LF.
    CrLf,
    /// A bias has a decimal point and a fraction.
    DecimalBias,
    /// A plane is a progressive JPEG stream.
    Progressive,
    /// A plane is a JPEG stream with three components.
    ThreeComponents,
}

/// A legal file that is read in the same way as a file that the reference refuses.
pub(super) struct StandIn {
    pub(super) bytes: Vec<u8>,
    /// True if the legal file has the values of the file; false if its values are similar or arbitrary.
    pub(super) is_exact: bool,
}

const VERSION_1_1: &[u8] = b"PTM_1.1\n";
const VERSION_1_2: &[u8] = b"PTM_1.2\n";

impl UnusualKind {
    /// Describes files of this kind: "files …".
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            UnusualKind::Version11 => "of version 1.1",
            UnusualKind::CrLf => "whose header lines end in CR LF",
            UnusualKind::DecimalBias => "with a fractional bias",
            UnusualKind::Progressive => "with progressive planes",
            UnusualKind::ThreeComponents => "with planes of three components",
        }
    }

    /// Returns the kind of a file that the reference refuses, if the kind is known.
    pub(super) fn new(dissection: &Dissection) -> Option<UnusualKind> {
        let error = dissection.outcome.as_ref().err()?;
        let file = dissection.file;
        match error.clause() {
            _ if file.starts_with(VERSION_1_1) => Some(UnusualKind::Version11),
            _ if file.starts_with(b"PTM_1.2\r\n") => Some(UnusualKind::CrLf),
            "2.4/4" => fraction(file, error.offset()).map(|_| UnusualKind::DecimalBias),
            "2.9.8/3" if dissection.format.and_then(Format::coding) == Some(Coding::Jpeg) => {
                kind_of_streams(dissection)
            }
            _ => None,
        }
    }

    /// Returns the legal file that corresponds to a file of this kind, or `None` if the file has other faults as well.
    pub(super) fn stand_in(self, dissection: &Dissection) -> Option<StandIn> {
        let (bytes, is_exact) = match self {
            UnusualKind::Version11 => (as_version_1_2(dissection.file)?, true),
            UnusualKind::CrLf => (without_carriage_returns(dissection.file), true),
            UnusualKind::DecimalBias => (with_rounded_biases(dissection.file), false),
            UnusualKind::Progressive | UnusualKind::ThreeComponents => {
                (with_baseline_streams(dissection)?, false)
            }
        };
        let made = Dissection::parse(&bytes);
        // Surplus bytes show that the payload was converted with the header.
        let is_whole = self != UnusualKind::CrLf || made.end() == bytes.len();
        let is_legal = made.outcome.is_ok() && is_whole;
        is_legal.then_some(StandIn { bytes, is_exact })
    }
}

/// Returns the kind of the streams of a file: three components, if any stream has them, or else progressive.
fn kind_of_streams(dissection: &Dissection) -> Option<UnusualKind> {
    let mut kind = None;
    for plane in 0..dissection.compressed_planes() {
        let stream = dissection.bytes(Role::Stream(plane))?;
        match frame(&segments(stream)) {
            Some((0xc0..=0xc2, _, _, _, 3)) => return Some(UnusualKind::ThreeComponents),
            Some((0xc2, _, _, _, 1)) => kind = Some(UnusualKind::Progressive),
            _ => {}
        }
    }
    kind
}

/// Converts a file of version 1.1 to version 1.2. The layout of LRGB differs: nine interleaved bytes per texel. RGB is equal in
/// both versions. The layouts of the other formats are unknown.
fn as_version_1_2(file: &[u8]) -> Option<Vec<u8>> {
    let renamed = [VERSION_1_2, file.strip_prefix(VERSION_1_1)?].concat();
    let dissection = Dissection::parse(&renamed);
    let range = dissection.part(Role::Block(0)).map(FilePart::range)?;
    let values = renamed.get(range.start..)?;
    match dissection.format? {
        Format::Rgb => Some(renamed),
        Format::Lrgb => {
            let texels = values.chunks_exact(9);
            let coefficients = texels.clone().flat_map(|texel| &texel[..6]);
            let values = coefficients.chain(texels.flat_map(|texel| &texel[6..]));
            Some(
                renamed[..range.start]
                    .iter()
                    .chain(values)
                    .copied()
                    .collect(),
            )
        }
        _ => None,
    }
}

/// Removes the carriage returns that the reference stops at, one at a time, so that the payload is never changed.
fn without_carriage_returns(file: &[u8]) -> Vec<u8> {
    let mut bytes = file.to_vec();
    while let Err(error) = decode(&bytes) {
        let rest = bytes[error.offset().min(bytes.len())..].iter();
        let line_end = rest.take(64).position(|byte| matches!(byte, b'\r' | b'\n'));
        match line_end.map(|length| error.offset() + length) {
            Some(place) if bytes[place..].starts_with(b"\r\n") => bytes.remove(place),
            _ => break,
        };
    }
    bytes
}

/// Rounds the biases that have a fraction.
fn with_rounded_biases(file: &[u8]) -> Vec<u8> {
    let mut bytes = file.to_vec();
    while let Err(error) = decode(&bytes) {
        let Some((length, value)) = fraction(&bytes, error.offset()) else {
            break;
        };
        let rounded = format!("{value:.0}");
        bytes.splice(
            error.offset()..error.offset() + length,
            rounded.into_bytes(),
        );
    }
    bytes
}

/// Returns the length and the value of a decimal number with a fraction at `offset`.
fn fraction(file: &[u8], offset: usize) -> Option<(usize, f64)> {
    let rest = file.get(offset..)?;
    let end = rest.iter().position(u8::is_ascii_whitespace)?;
    let token = std::str::from_utf8(&rest[..end]).ok()?;
    let is_decimal = token.bytes().all(|byte| b"+-.0123456789".contains(&byte));
    let value: f64 = token.parse().ok().filter(|_| is_decimal)?;
    (value.fract() != 0.0).then_some((end, value))
}

/// Replaces the stream of each plane by a sequential stream of one component with arbitrary samples.
fn with_baseline_streams(dissection: &Dissection) -> Option<Vec<u8>> {
    const QUALITY: u8 = 90;
    let size = dissection.size?;
    let mut edits = Vec::new();
    for plane in 0..dissection.compressed_planes() {
        let mut state = plane as u32 + 1;
        let samples = std::iter::repeat_with(|| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        });
        let samples: Vec<u8> = samples.take(size.texels()).collect();
        let stream = Coding::Jpeg.encode(&samples, (size.width, size.height), QUALITY);
        let length = dissection.part(Role::StreamSize(plane))?.range();
        edits.push((length, stream.len().to_string().into_bytes()));
        edits.push((dissection.part(Role::Stream(plane))?.range(), stream));
    }
    // Apply edits from the end, so that the ranges of earlier edits remain valid.
    edits.sort_by_key(|(range, _)| std::cmp::Reverse(range.start));
    let mut bytes = dissection.file.to_vec();
    for (range, replacement) in edits {
        bytes.splice(range, replacement);
    }
    Some(bytes)
}
