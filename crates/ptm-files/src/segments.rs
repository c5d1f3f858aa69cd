//! Marker segments of the stream of a compressed plane (T.81 Annex B, T.87 Annex C).
//!
//! This parser never fails: damaged parts are returned as they are. The codecs decide whether a stream is valid.

use std::borrow::Cow;
use std::ops::Range;

use crate::join_texts;

/// Part of a stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment<'a> {
    /// Kind of the part.
    pub kind: SegmentKind,
    /// Byte range, relative to the beginning of the stream.
    pub range: Range<usize>,
    /// Bytes of the part.
    pub bytes: &'a [u8],
    /// Description; may be empty.
    pub description: String,
}

/// Kind of a part of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentKind {
    /// Marker with this code, including its segment if it has one.
    Marker(u8),
    /// Fill bytes (FF) before a marker (T.81 B.1.1.2).
    Fill,
    /// Entropy-coded data.
    Data,
    /// Bytes after the end of the image.
    Trailing,
    /// Stray bytes where a marker is expected.
    Stray,
}

const SOI: u8 = 0xd8;
pub(super) const EOI: u8 = 0xd9;
const SOS: u8 = 0xda;
const SOF55: u8 = 0xf7;

impl SegmentKind {
    /// Returns the name that the standard uses for this kind, and the clause that defines the kind.
    #[must_use]
    pub fn label(self) -> (Cow<'static, str>, &'static str) {
        let (name, clause) = match self {
            SegmentKind::Fill => ("fill bytes", "T.81 B.1.1.2"),
            SegmentKind::Data => ("entropy-coded data", "T.81 B.1.1.5"),
            SegmentKind::Trailing => ("bytes after the end", "T.81 B.1.1.3"),
            SegmentKind::Stray => ("stray bytes", "T.81 B.1.1.3"),
            SegmentKind::Marker(code) => match code {
                SOI => ("SOI", "T.81 B.2.1"),
                EOI => ("EOI", "T.81 B.2.1"),
                SOS => ("SOS", "T.81 B.2.3"),
                SOF55 => ("SOF55", "T.87 C.2.2"),
                0xf8 => ("LSE", "T.87 C.2.4.1"),
                0xc4 => ("DHT", "T.81 B.2.4.2"),
                0xcc => ("DAC", "T.81 B.2.4.3"),
                0xdb => ("DQT", "T.81 B.2.4.1"),
                0xdc => ("DNL", "T.81 B.2.5"),
                0xdd => ("DRI", "T.81 B.2.4.4"),
                0xfe => ("COM", "T.81 B.2.4.5"),
                0xc0..=0xcf => return (format!("SOF{}", code - 0xc0).into(), "T.81 B.2.2"),
                0xe0..=0xef => return (format!("APP{}", code - 0xe0).into(), "T.81 B.2.4.6"),
                0xd0..=0xd7 => return (format!("RST{}", code - 0xd0).into(), "T.81 B.1.1.3"),
                _ => return (format!("marker FF{code:02X}").into(), "T.81 B.1.1.3"),
            },
        };
        (name.into(), clause)
    }
}

/// Splits `stream` into consecutive parts without gaps.
#[must_use]
pub fn segments(stream: &[u8]) -> Vec<Segment<'_>> {
    let mut parts: Vec<Segment> = Vec::new();
    let (mut rest, mut is_jpeg_ls) = (stream, false);
    while !rest.is_empty() {
        let (kind, length) = match parts.last().map(|part| part.kind) {
            Some(SegmentKind::Marker(EOI)) => (SegmentKind::Trailing, rest.len()),
            Some(SegmentKind::Marker(SOS)) => match data_length(rest, is_jpeg_ls) {
                0 => marker_or_gap(rest),
                length => (SegmentKind::Data, length),
            },
            _ => marker_or_gap(rest),
        };
        is_jpeg_ls |= kind == SegmentKind::Marker(SOF55);
        let bytes;
        (bytes, rest) = rest.split_at(length.min(rest.len()));
        let end = stream.len() - rest.len();
        parts.push(Segment {
            kind,
            range: end - bytes.len()..end,
            bytes,
            description: describe(kind, bytes, is_jpeg_ls),
        });
    }
    parts
}

/// Returns the kind and length of the marker segment, fill bytes or stray bytes at the beginning of `rest`.
fn marker_or_gap(rest: &[u8]) -> (SegmentKind, usize) {
    match *rest {
        [0xff, 0xff, ..] => {
            let fill = rest.iter().take_while(|&&byte| byte == 0xff).count() - 1;
            (SegmentKind::Fill, fill)
        }
        [0xff, code, ..] if has_no_segment(code) => (SegmentKind::Marker(code), 2),
        // The length includes its own two bytes but not the marker (T.81 B.1.1.4).
        [0xff, code, high, low, ..] if code != 0 => {
            let length = usize::from(u16::from_be_bytes([high, low]));
            (SegmentKind::Marker(code), 2 + length.max(2))
        }
        [0xff, code, ..] if code != 0 => (SegmentKind::Marker(code), rest.len()),
        _ => {
            let stray = rest[1..].iter().position(|&byte| byte == 0xff);
            (SegmentKind::Stray, stray.map_or(rest.len(), |i| i + 1))
        }
    }
}

/// Returns true for markers without a segment (T.81 Table B.1).
const fn has_no_segment(code: u8) -> bool {
    matches!(code, 0x01 | 0xd0..=0xd9)
}

/// Returns the length of the entropy-coded data up to the next marker other than RST. In the data, FF is followed by 00
/// (T.81) or by a byte below 80 (T.87).
fn data_length(rest: &[u8], is_jpeg_ls: bool) -> usize {
    let is_in_data = |byte| match byte {
        0 | 0xd0..=0xd7 => true,
        _ => is_jpeg_ls && byte < 0x80,
    };
    let ends = |pair: &[u8]| pair[0] == 0xff && !is_in_data(pair[1]);
    rest.windows(2).position(ends).unwrap_or(rest.len())
}

/// Finds the frame header and returns its marker code, precision, height, width and number of components.
#[must_use]
pub fn frame(parts: &[Segment]) -> Option<(u8, u8, u16, u16, u8)> {
    parts.iter().find_map(|part| {
        let SegmentKind::Marker(code @ (0xc0..=0xcf | SOF55)) = part.kind else {
            return None;
        };
        let is_frame = !matches!(code, 0xc4 | 0xc8 | 0xcc);
        let &[_, _, _, _, precision, h1, h0, w1, w0, count, ..] = part.bytes else {
            return None;
        };
        let (height, width) = (u16::from_be_bytes([h1, h0]), u16::from_be_bytes([w1, w0]));
        is_frame.then_some((code, precision, height, width, count))
    })
}

/// Returns NEAR from the scan header of a JPEG-LS stream (T.87 C.2.3).
#[must_use]
pub fn near(parts: &[Segment]) -> Option<u8> {
    let is_scan = |part: &&Segment| part.kind == SegmentKind::Marker(SOS);
    let body = parts.iter().find(is_scan)?.bytes.get(4..)?;
    let components = usize::from(*body.first()?);
    body.get(1 + 2 * components).copied()
}

/// Describes a part of a stream. Returns an empty string if there is nothing to describe.
fn describe(kind: SegmentKind, bytes: &[u8], is_jpeg_ls: bool) -> String {
    match (kind, bytes) {
        (SegmentKind::Data, _) => {
            let is_restart = |pair: &&[u8]| matches!(pair, [0xff, 0xd0..=0xd7]);
            match bytes.windows(2).filter(is_restart).count() {
                0 => String::new(),
                restarts => format!("{restarts} restart markers"),
            }
        }
        (SegmentKind::Marker(code), _) if has_no_segment(code) => String::new(),
        (SegmentKind::Marker(code), &[_, _, high, low, ref body @ ..]) => {
            let length = usize::from(u16::from_be_bytes([high, low]));
            match bytes.len() < 2 + length {
                true => format!("truncated: {} of {length} bytes", bytes.len() - 2),
                false => describe_segment(code, body, is_jpeg_ls),
            }
        }
        (SegmentKind::Marker(_), _) => "truncated".to_owned(),
        _ => String::new(),
    }
}

fn describe_segment(code: u8, body: &[u8], is_jpeg_ls: bool) -> String {
    match (code, body) {
        (0xc4, _) => huffman_tables(body),
        (0xc0..=0xcf | SOF55, &[precision, h1, h0, w1, w0, count, ..]) => {
            let (width, height) = (u16::from_be_bytes([w1, w0]), u16::from_be_bytes([h1, h0]));
            let components = match *body {
                [_, _, _, _, _, 1, _, f, ..] => format!("component sampled {}x{}", f >> 4, f & 15),
                [_, _, _, _, _, 1, ..] => "component".to_owned(),
                _ => "components".to_owned(),
            };
            format!("{precision} bits, {width} x {height} samples, {count} {components}")
        }
        (SOS, &[count, ..]) => {
            let after = body.get(1 + 2 * usize::from(count)..).unwrap_or_default();
            match *after {
                [near, interleave, ..] if is_jpeg_ls => {
                    format!("NEAR {near}, interleave {interleave}")
                }
                [first, last, ..] => format!("coefficients {first} to {last}"),
                _ => String::new(),
            }
        }
        (0xdb, _) => quantization_tables(body),
        (0xdd, &[high, low]) => format!("interval {}", u16::from_be_bytes([high, low])),
        (0xf8, &[1, ref rest @ ..]) => {
            let names = ["MAXVAL", "T1", "T2", "T3", "RESET"];
            let pairs = names.iter().zip(rest.as_chunks::<2>().0);
            let text = |(name, &pair): (_, _)| format!("{name} {}", u16::from_be_bytes(pair));
            join_texts(pairs.map(text), ", ")
        }
        (0xe0..=0xef | 0xfe, _) => body[..body.len().min(24)].escape_ascii().to_string(),
        _ => String::new(),
    }
}

/// Describes each table in a DHT segment: its class, its number and the number of codes (T.81 B.2.4.2).
fn huffman_tables(mut body: &[u8]) -> String {
    let mut tables = Vec::new();
    while let [kind, rest @ ..] = body
        && let Some((counts, values)) = rest.split_at_checked(16)
    {
        let codes: usize = counts.iter().map(|&count| usize::from(count)).sum();
        let class = if kind >> 4 == 0 { "DC" } else { "AC" };
        tables.push(format!("{class} table {} of {codes} codes", kind & 15));
        body = values.get(codes..).unwrap_or_default();
    }
    tables.join(", ")
}

/// Describes each table in a DQT segment: its number, element width and DC step (T.81 B.2.4.1).
fn quantization_tables(mut body: &[u8]) -> String {
    let mut tables = Vec::new();
    while let [kind, rest @ ..] = body {
        let size = if kind >> 4 == 0 { 1 } else { 2 };
        let Some((table, more)) = rest.split_at_checked(64 * size) else {
            break;
        };
        let first = table[..size].iter();
        let first = first.fold(0, |step, &byte| step << 8 | u16::from(byte));
        let table = format!("table {} of {} bits", kind & 15, 8 * size);
        tables.push(format!("{table}, DC step {first}"));
        body = more;
    }
    tables.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use ptm::codec::jpeg;

    fn check_coverage(stream: &[u8]) {
        let mut end = 0;
        for part in segments(stream) {
            assert_eq!(part.range.start, end);
            end = part.range.end;
        }
        assert_eq!(end, stream.len());
    }

    #[test]
    fn segments_of_arbitrary_bytes_cover_the_stream() {
        let samples: Vec<u8> = (0..64).map(|i| i * 3).collect();
        let stream = jpeg::encode(&samples, 8, 8, &jpeg::JpegOptions::new(90)).stream;
        for i in 0..stream.len() {
            check_coverage(&stream[..i]);
            for byte in [0, 0x7f, 0xda, 0xff] {
                let mut stream = stream.clone();
                stream[i] = byte;
                check_coverage(&stream);
            }
        }
        check_coverage(&[0xff; 9]);
        check_coverage(&[0xff, 0xda, 0, 2, 0xff, 0xff, 0xff]);
    }
}
