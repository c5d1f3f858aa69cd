//! The marker segments of a plane's stream (T.81 Annex B, T.87 Annex C), as far as they can be distinguished.
//!
//! This walk over a stream never refuses: damaged parts are shown as they are. The codecs decide if a stream is valid.

use std::borrow::Cow;
use std::ops::Range;

/// A part of a stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Its kind.
    pub kind: SegmentKind,
    /// Its bytes, relative to the beginning of the stream.
    pub range: Range<usize>,
    /// A description; empty if there is none.
    pub says: String,
}

/// The kind of a part of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentKind {
    /// A marker of this code, with its segment if it has one.
    Marker(u8),
    /// Bytes FF before a marker (T.81 B.1.1.2).
    Fill,
    /// Entropy-coded data.
    Data,
    /// Bytes after the end of the image.
    Behind,
    /// Bytes in place of a marker.
    Stray,
}

const SOI: u8 = 0xd8;
const EOI: u8 = 0xd9;
const SOS: u8 = 0xda;
const SOF55: u8 = 0xf7;

impl SegmentKind {
    /// Returns its name in its standard, and the clause of the standard that describes it.
    #[must_use]
    pub fn label(self) -> (Cow<'static, str>, &'static str) {
        let (name, clause) = match self {
            SegmentKind::Fill => ("fill bytes", "T.81 B.1.1.2"),
            SegmentKind::Data => ("entropy-coded data", "T.81 B.1.1.5"),
            SegmentKind::Behind => ("bytes after the end", "T.81 B.1.1.3"),
            SegmentKind::Stray => ("no marker", "T.81 B.1.1.3"),
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

/// Returns the parts of `stream` in sequence, without gaps.
#[must_use]
pub fn segments(stream: &[u8]) -> Vec<Segment> {
    let mut walk = Walk {
        stream,
        parts: Vec::new(),
        jpeg_ls: false,
    };
    while walk.at() < stream.len() {
        walk.step();
    }
    walk.parts
}

/// Returns values of the frame header among `parts`: its code, precision, height, width and number of components.
#[must_use]
pub fn frame(stream: &[u8], parts: &[Segment]) -> Option<(u8, u8, u16, u16, u8)> {
    let is_frame =
        |code| matches!(code, 0xc0..=0xcf | SOF55) && !matches!(code, 0xc4 | 0xc8 | 0xcc);
    parts.iter().find_map(|part| match part.kind {
        SegmentKind::Marker(code) if is_frame(code) => match stream[part.range.clone()] {
            [_, _, _, _, precision, h1, h0, w1, w0, components, ..] => Some((
                code,
                precision,
                u16::from_be_bytes([h1, h0]),
                u16::from_be_bytes([w1, w0]),
                components,
            )),
            _ => None,
        },
        _ => None,
    })
}

/// Returns NEAR from the scan header of a JPEG-LS stream (T.87 C.2.3).
#[must_use]
pub fn near(stream: &[u8], parts: &[Segment]) -> Option<u8> {
    let scan = parts
        .iter()
        .find(|part| part.kind == SegmentKind::Marker(SOS))?;
    let body = stream.get(scan.range.start + 4..scan.range.end)?;
    let components = usize::from(*body.first()?);
    body.get(1 + 2 * components).copied()
}

struct Walk<'a> {
    stream: &'a [u8],
    parts: Vec<Segment>,
    jpeg_ls: bool,
}

impl Walk<'_> {
    fn at(&self) -> usize {
        self.parts.last().map_or(0, |part| part.range.end)
    }

    fn push(&mut self, kind: SegmentKind, length: usize, says: String) {
        let start = self.at();
        let end = start.saturating_add(length).min(self.stream.len());
        self.parts.push(Segment {
            kind,
            range: start..end,
            says,
        });
    }

    fn step(&mut self) {
        let rest = &self.stream[self.at()..];
        let last = self.parts.last().map(|part| part.kind);
        if last == Some(SegmentKind::Marker(EOI)) {
            return self.push(SegmentKind::Behind, rest.len(), String::new());
        }
        if last == Some(SegmentKind::Marker(SOS)) {
            return self.data();
        }
        match *rest {
            [0xff, 0xff, ..] => {
                let fill = rest.iter().take_while(|&&byte| byte == 0xff).count() - 1;
                self.push(SegmentKind::Fill, fill, String::new());
            }
            [0xff, code, ..] if code != 0 => self.marker(code),
            _ => {
                let stray = rest[1..].iter().position(|&byte| byte == 0xff);
                self.push(
                    SegmentKind::Stray,
                    stray.map_or(rest.len(), |at| at + 1),
                    String::new(),
                );
            }
        }
    }

    fn marker(&mut self, code: u8) {
        let rest = &self.stream[self.at()..];
        self.jpeg_ls |= code == SOF55;
        if matches!(code, 0x01 | 0xd0..=0xd9) {
            return self.push(SegmentKind::Marker(code), 2, String::new());
        }
        // A length counts its own two bytes and not the marker (T.81 B.1.1.4).
        let length = match *rest {
            [_, _, high, low, ..] => usize::from(u16::from_be_bytes([high, low])),
            _ => return self.push(SegmentKind::Marker(code), rest.len(), "cut".to_owned()),
        };
        let body = rest.get(4..2 + length.max(2));
        let says = body.map_or_else(
            || format!("cut: {length} bytes, {} remain", rest.len() - 2),
            |body| describe(code, body, self.jpeg_ls),
        );
        self.push(SegmentKind::Marker(code), 2 + length.max(2), says);
    }

    /// Reads up to the next marker that is not a restart: in data, FF is followed by 00 (T.81) or by a byte below 80 (T.87).
    fn data(&mut self) {
        let rest = &self.stream[self.at()..];
        let mut restarts = 0;
        let mut at = 0;
        let end = loop {
            let Some(found) = rest[at..].iter().position(|&byte| byte == 0xff) else {
                break rest.len();
            };
            at += found;
            match rest.get(at + 1) {
                Some(0xd0..=0xd7) => restarts += 1,
                Some(0) => {}
                Some(0x01..=0x7f) if self.jpeg_ls => {}
                Some(_) => break at,
                None => break rest.len(),
            }
            at += 2;
        };
        let says = match restarts {
            0 => String::new(),
            _ => format!("{restarts} restart markers within"),
        };
        // At least one byte, so that the walk progresses: after an empty scan the marker is taken.
        if end == 0 {
            return match *rest {
                [0xff, code, ..] if code != 0xff => self.marker(code),
                _ => self.push(SegmentKind::Fill, 1, String::new()),
            };
        }
        self.push(SegmentKind::Data, end, says);
    }
}

/// Describes a segment.
fn describe(code: u8, body: &[u8], jpeg_ls: bool) -> String {
    match (code, body) {
        (0xc4, _) => huffman_tables(body),
        (0xc0..=0xcf | SOF55, &[precision, h1, h0, w1, w0, count, ..]) => {
            let sampling = match body {
                [_, _, _, _, _, 1, _, factors, ..] => {
                    format!(" of {}x{}", factors >> 4, factors & 15)
                }
                _ => String::new(),
            };
            format!(
                "{precision} bits, {} x {} samples, {count} component{}{sampling}",
                u16::from_be_bytes([w1, w0]),
                u16::from_be_bytes([h1, h0]),
                if count == 1 { "" } else { "s" }
            )
        }
        (SOS, &[count, ..]) => {
            let after = body.get(1 + 2 * usize::from(count)..).unwrap_or_default();
            match *after {
                [near, interleave, ..] if jpeg_ls => {
                    format!("NEAR {near}, interleave {interleave}")
                }
                [first, last, ..] => format!("coefficients {first} to {last}"),
                _ => String::new(),
            }
        }
        (0xdb, _) => quantisation_tables(body),
        (0xdd, &[high, low]) => format!("interval {}", u16::from_be_bytes([high, low])),
        (0xf8, &[1, ref rest @ ..]) => {
            let names = ["MAXVAL", "T1", "T2", "T3", "RESET"];
            let numbers = rest
                .as_chunks::<2>()
                .0
                .iter()
                .map(|pair| u16::from_be_bytes(*pair));
            let words: Vec<String> = names
                .iter()
                .zip(numbers)
                .map(|(name, number)| format!("{name} {number}"))
                .collect();
            words.join(", ")
        }
        (0xe0..=0xef | 0xfe, _) => body[..body.len().min(24)].escape_ascii().to_string(),
        _ => String::new(),
    }
}

/// Describes the tables of a DHT segment (T.81 B.2.4.2): class, number, number of codes.
fn huffman_tables(mut body: &[u8]) -> String {
    let mut words = Vec::new();
    while let [kind, rest @ ..] = body {
        let Some((counts, values)) = rest.split_at_checked(16) else {
            break;
        };
        let codes: usize = counts.iter().map(|&count| usize::from(count)).sum();
        let class = if kind >> 4 == 0 { "DC" } else { "AC" };
        words.push(format!("{class} table {} of {codes} codes", kind & 15));
        body = values.get(codes..).unwrap_or_default();
    }
    words.join(", ")
}

/// Describes the tables of a DQT segment (T.81 B.2.4.1): number, width, and the step of the DC coefficient.
fn quantisation_tables(mut body: &[u8]) -> String {
    let mut words = Vec::new();
    while let [kind, rest @ ..] = body {
        let wide = kind >> 4 != 0;
        let Some((table, more)) = rest.split_at_checked(if wide { 128 } else { 64 }) else {
            break;
        };
        let first = if wide {
            u16::from_be_bytes([table[0], table[1]])
        } else {
            u16::from(table[0])
        };
        words.push(format!(
            "table {} of {} bits, first divisor {first}",
            kind & 15,
            if wide { 16 } else { 8 }
        ));
        body = more;
    }
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::{jpeg, jpeg_ls};

    fn names(stream: &[u8]) -> Vec<Cow<'static, str>> {
        let parts = segments(stream);
        parts.iter().map(|part| part.kind.label().0).collect()
    }

    fn whole(stream: &[u8]) {
        let parts = segments(stream);
        let ends: Vec<usize> = parts.iter().map(|part| part.range.end).collect();
        let starts: Vec<usize> = parts.iter().map(|part| part.range.start).collect();
        assert_eq!(starts.first().copied().unwrap_or(0), 0);
        assert_eq!(ends.last().copied().unwrap_or(0), stream.len());
        assert!(
            starts
                .iter()
                .skip(1)
                .eq(ends.iter().take(ends.len().saturating_sub(1)))
        );
    }

    #[test]
    fn the_segments_of_both_codecs_are_named() {
        let samples: Vec<u8> = (0..=255).collect();
        let jpeg = jpeg::encode(&samples, 16, 16, &jpeg::JpegOptions::new(75)).stream;
        assert_eq!(
            names(&jpeg),
            [
                "SOI",
                "APP0",
                "DQT",
                "SOF0",
                "DHT",
                "DHT",
                "SOS",
                "entropy-coded data",
                "EOI"
            ]
        );
        assert!(frame(&jpeg, &segments(&jpeg)) == Some((0xc0, 8, 16, 16, 1)));
        let options = jpeg_ls::JpegLsOptions {
            near: 3,
            presets: None,
        };
        let stream = jpeg_ls::encode(&samples, 16, 16, &options).stream;
        assert_eq!(
            names(&stream),
            ["SOI", "SOF55", "SOS", "entropy-coded data", "EOI"]
        );
        assert_eq!(near(&stream, &segments(&stream)), Some(3));
    }

    #[test]
    fn any_bytes_are_walked_to_their_end() {
        let samples: Vec<u8> = (0..64).map(|i| i * 3).collect();
        let stream = jpeg::encode(&samples, 8, 8, &jpeg::JpegOptions::new(90)).stream;
        for at in 0..stream.len() {
            whole(&stream[..at]);
            for byte in [0, 0x7f, 0xda, 0xff] {
                let mut stream = stream.clone();
                stream[at] = byte;
                whole(&stream);
            }
        }
        whole(&[0xff; 9]);
        whole(&[0xff, 0xda, 0, 2, 0xff, 0xff, 0xff]);
    }
}
