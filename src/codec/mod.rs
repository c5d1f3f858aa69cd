//! The two standards that PTM borrows for its planes.
//!
//! A compressed PTM stores each plane as a complete stream of another standard: JPEG (ITU-T T.81)
//! or JPEG-LS (ITU-T T.87). Both are read and written here for what a plane is, one component of 8
//! bits:
//!
//! ```text
//! &[u8] → markers and segments → parameters and tables → entropy-coded scan → samples
//!         T.81 B.1.1             T.81 B.2, T.87 C.2      jpeg, jpeg_ls
//! ```
//!
//! A stream is a row of *markers*, some of which open a *segment* with a length; one segment, the
//! scan header, is followed by entropy-coded data that has no length and ends where the next marker
//! stands. T.87 took this syntax over from T.81 whole, and with it the frame header and the scan
//! header; so this file reads it for both.
//!
//! Format notes
//! - Any number of bytes 0xFF may stand before a marker (B.1.1.2). Within a segment there are none.
//! - A length counts its own two bytes and not the marker (B.1.1.4). Numbers are stored high byte
//!   first (B.1.1.1).
//! - What follows the end of the image (EOI) belongs to somebody else and is not looked at.
//! - Height comes before width in the frame header. A height of zero means "told later, by DNL"
//!   (B.2.5).

#![forbid(unsafe_code)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    clippy::cast_lossless,
    reason = "both standards count in a few bits, and every narrowing stands behind a bound"
)]

use std::fmt;

pub mod jpeg;

pub mod jpeg_ls;

/// Whose fault it is that a stream was not decoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Class {
    /// The stream breaks its standard, or is not what was asked for.
    Malformed,
    /// The stream may well be legal, but uses what this decoder does not implement.
    Unsupported,
}

/// Why a stream was not decoded, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// Whose fault it is.
    pub class: Class,
    /// The byte of the stream that shows it, counted from 0.
    pub offset: usize,
    /// What is wrong, as part of a sentence.
    pub what: String,
}

impl fmt::Display for Error {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "byte {}: {}", self.offset, self.what)
    }
}

impl std::error::Error for Error {}

type Result<T> = std::result::Result<T, Error>;

fn malformed(offset: usize, what: impl Into<String>) -> Error {
    Error {
        class: Class::Malformed,
        offset,
        what: what.into(),
    }
}

fn unsupported(offset: usize, what: impl Into<String>) -> Error {
    Error {
        class: Class::Unsupported,
        offset,
        what: what.into(),
    }
}

/// What an encoder made.
#[cfg(feature = "generate")]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Encoded {
    /// The complete stream, from SOI to EOI.
    pub stream: Vec<u8>,
    /// The samples that an exact decoder returns for it, in row order.
    ///
    /// They are by-products of encoding: no decoder was asked.
    pub samples: Vec<u8>,
}

/// The markers that both standards use, by their second byte (T.81 Table B.1, T.87 Table C.1).
mod marker {
    pub const RST0: u8 = 0xD0;
    pub const SOI: u8 = 0xD8;
    pub const EOI: u8 = 0xD9;
    pub const SOS: u8 = 0xDA;
    pub const DNL: u8 = 0xDC;
    pub const DRI: u8 = 0xDD;
    pub const APP0: u8 = 0xE0;
    pub const APP15: u8 = 0xEF;
    pub const COM: u8 = 0xFE;
}

/// A marker and where its 0xFF stands.
#[derive(Clone, Copy)]
struct Marker {
    code: u8,
    at: usize,
}

impl fmt::Display for Marker {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "marker FF{:02X}", self.code)
    }
}

/// A stream, or one segment of it, and the next byte to read.
///
/// A segment is the same stream with an earlier end, so that offsets count from the same zero.
struct Input<'a> {
    stream: &'a [u8],
    at: usize,
    /// What ends where `stream` ends, for the sentence of the error.
    name: &'static str,
}

impl<'a> Input<'a> {
    /// Opens a stream with its first marker, which stands at the first byte (B.2.1).
    fn open(stream: &'a [u8]) -> Result<Self> {
        match stream {
            [] => Err(malformed(0, "the stream is empty")),
            [0xFF, marker::SOI, ..] => Ok(Input {
                stream,
                at: 2,
                name: "the stream",
            }),
            _ => Err(malformed(
                0,
                "the stream does not start with SOI, bytes FF D8",
            )),
        }
    }

    fn byte(&mut self, what: &str) -> Result<u8> {
        let byte = self.stream.get(self.at).copied();
        let byte =
            byte.ok_or_else(|| malformed(self.at, format!("{} ends before {what}", self.name)))?;
        self.at += 1;
        Ok(byte)
    }

    fn u16(&mut self, what: &str) -> Result<u16> {
        Ok(u16::from_be_bytes([self.byte(what)?, self.byte(what)?]))
    }

    fn at_end(&self) -> bool {
        self.at == self.stream.len()
    }

    /// Nothing may be left over in a segment that has been read.
    fn expect_end(&self) -> Result<()> {
        let left = self.stream.len() - self.at;
        if left == 0 {
            Ok(())
        } else {
            Err(malformed(
                self.at,
                format!("{} is {left} bytes too long", self.name),
            ))
        }
    }

    /// The next marker, after any fill bytes (B.1.1.2).
    fn marker(&mut self) -> Result<Marker> {
        let found = self.byte("a marker")?;
        if found != 0xFF {
            return Err(malformed(
                self.at - 1,
                format!("expected a marker, found byte {found:02X}"),
            ));
        }
        let mut code = 0xFF;
        while code == 0xFF {
            code = self.byte("the code of a marker")?;
        }
        Ok(Marker {
            code,
            at: self.at - 2,
        })
    }

    /// The segment that the marker just read opens (B.1.1.4); this input continues behind it.
    fn segment(&mut self, name: &'static str) -> Result<Input<'a>> {
        let start = self.at;
        let length = self.u16("the length of a segment")?;
        let end = start + usize::from(length);
        if length < 2 {
            return Err(malformed(
                start,
                format!("{name} has length {length}, which does not cover the length itself"),
            ));
        }
        if end > self.stream.len() {
            return Err(malformed(
                start,
                format!("{name} of {length} bytes runs past the end of the stream"),
            ));
        }
        self.at = end;
        Ok(Input {
            stream: &self.stream[..end],
            at: start + 2,
            name,
        })
    }
}

/// What a frame header (T.81 B.2.2, T.87 C.2.2) tells beyond what is already known of a plane.
struct Frame {
    /// The name that the scan header must repeat.
    component: u8,
    /// The quantisation table of the component, which only JPEG has.
    table: u8,
}

impl Frame {
    /// Reads the header of a frame that must be `width` × `height`, one component, 8 bits.
    ///
    /// `other_precisions` are those that the standard allows and we do not implement.
    fn read(input: &mut Input, width: u32, height: u32, other_precisions: &[u8]) -> Result<Frame> {
        let mut header = input.segment("the frame header")?;

        let at = header.at;
        let precision = header.byte("the sample precision")?;
        if other_precisions.contains(&precision) {
            return Err(unsupported(
                at,
                format!("samples of {precision} bits are not implemented"),
            ));
        }
        if precision != 8 {
            return Err(malformed(
                at,
                format!("samples of {precision} bits do not exist here"),
            ));
        }

        let at = header.at;
        let (rows, columns) = (header.u16("the height")?, header.u16("the width")?);
        if rows == 0 {
            return Err(unsupported(
                at,
                "a height that DNL tells later is not implemented",
            ));
        }
        // plane-stream: a plane is as large as its PTM. Nothing has been allocated yet.
        if (u32::from(columns), u32::from(rows)) != (width, height) {
            return Err(malformed(
                at,
                format!("expected {width} x {height} samples, found {columns} x {rows}"),
            ));
        }

        let at = header.at;
        let components = header.byte("the number of components")?;
        if components != 1 {
            return Err(malformed(
                at,
                format!("expected one component, found {components}"),
            ));
        }
        let component = header.byte("the name of the component")?;
        // Factors set the size of a component against the *others* (A.1.1), and the blocks of a
        // scan of one component run in plain rows (A.2.2). So any pair of legal factors means the
        // same here.
        let at = header.at;
        let factors = header.byte("the sampling factors")?;
        if !(1..=4).contains(&(factors >> 4)) || !(1..=4).contains(&(factors & 15)) {
            return Err(malformed(
                at,
                format!(
                    "sampling factors {} x {} are not within 1 to 4",
                    factors >> 4,
                    factors & 15
                ),
            ));
        }
        let table = header.byte("the quantisation table of the component")?;
        header.expect_end()?;
        Ok(Frame { component, table })
    }
}

/// A scan header (T.81 B.2.3, T.87 C.2.3): the tables of the one component and three parameters,
/// whose meaning differs between the standards.
struct Scan {
    tables: u8,
    parameters: [u8; 3],
    /// Where `tables` and `parameters` stand.
    at: usize,
}

impl Scan {
    fn read(input: &mut Input, frame: &Frame) -> Result<Scan> {
        let mut header = input.segment("the scan header")?;
        let at = header.at;
        let components = header.byte("the number of components")?;
        if components != 1 {
            return Err(malformed(
                at,
                format!("expected a scan of one component, found {components}"),
            ));
        }
        let at = header.at;
        let component = header.byte("the name of the component")?;
        if component != frame.component {
            return Err(malformed(
                at,
                format!(
                    "the scan is of component {component}, the frame has only {}",
                    frame.component
                ),
            ));
        }
        let at = header.at;
        let tables = header.byte("the tables of the component")?;
        let parameters = [
            header.byte("its parameters")?,
            header.byte("its parameters")?,
            header.byte("its parameters")?,
        ];
        header.expect_end()?;
        Ok(Scan {
            tables,
            parameters,
            at,
        })
    }
}

/// Room for all samples; a refusal instead of an abort where there is not enough memory.
fn room_for_samples(width: u32, height: u32, at: usize) -> Result<Vec<u8>> {
    let mut samples = Vec::new();
    // Neither side is over 65,535, or the frame header would have differed.
    let enough = usize::try_from(u64::from(width) * u64::from(height))
        .is_ok_and(|n| samples.try_reserve_exact(n).is_ok());
    if enough {
        Ok(samples)
    } else {
        Err(unsupported(
            at,
            format!("no memory for {width} x {height} samples"),
        ))
    }
}

/// For tests: streams as the standards see them, in hexadecimal, with spaces wherever they help,
/// and `01*64` for sixty-four bytes 01.
#[cfg(test)]
fn bytes(text: &str) -> Vec<u8> {
    let word = |word: &str| {
        let (digits, times) = word.split_once('*').unwrap_or((word, "1"));
        let byte = u8::from_str_radix(digits, 16).expect("two hexadecimal digits");
        vec![byte; times.parse().expect("a number of times")]
    };
    text.split_whitespace().flat_map(word).collect()
}
