//! Bytes → header → planes, a file for each section of the text, in its order.
//!
//! [`decode`] is the contents page. Nothing here does I/O, looks at a file name, or asks about mistakes.

mod input;

/// §2.1 Header String
mod header_string;

/// §2.2 Format String
mod format_string;

/// §2.3 Image Size
mod image_size;

/// §2.4 Scale and Bias
mod scale_bias;

/// §2.5 Lookup Table
pub(crate) mod lookup_table;

/// §2.6 Color Matrix
pub(crate) mod color_matrix;

/// §2.7 Uncompressed Per Texel Data
pub(crate) mod texels;

/// §2.8 Lookup Table Indices
pub(crate) mod indices;

/// §2.9 Compressed Data: the parameter and the lists (§2.9.1 – 2.9.7)
pub(crate) mod compressed;

/// §2.9.2 – 2.9.5 put to work: a plane from its reference
pub(crate) mod predict;

/// §2.9.8 Compressed Coefficient Planes
pub(crate) mod planes;

/// Compressed files made by hand, for tests.
#[cfg(all(test, feature = "generate"))]
pub(crate) mod by_hand;

/// The rows of the picture from what 2.7, 2.8 and 2.9.8 store
mod stored;

pub(crate) use input::Input;
pub use stored::Stored;

use crate::error::{Error, Result};
use crate::ptm::{Field, Format, Planes, ScaleBias, Shape, Size};
use crate::reading::Reading;

/// What 2.1–2.4 say of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// Which of the nine formats (2.2).
    pub format: Format,
    /// Width and height (2.3).
    pub size: Size,
    /// What makes final coefficients of raw ones (2.4).
    pub scale_bias: ScaleBias,
}

/// A whole file, decoded.
#[derive(Clone, Debug, PartialEq)]
pub struct Ptm {
    /// The header.
    pub header: Header,
    /// The stored values, top row first.
    pub planes: Planes,
}

/// How much a file may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes that the planes may take; 1 GiB unless told.
    pub memory: usize,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { memory: 1 << 30 }
    }
}

/// Decodes `file` as the reference reads it.
///
/// ```
/// let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n\x01\x02\x03\x04\x05\x06rgb";
/// let ptm = ptm_conform::decode(file)?;
/// assert_eq!(ptm.planes.samples, b"\x01\x02\x03\x04\x05\x06rgb");
/// # Ok::<(), ptm_conform::Error>(())
/// ```
pub fn decode(file: &[u8]) -> Result<Ptm> {
    decode_as(file, &Reading::SPEC, &Limits::default())
}

/// Decodes `file` under another reading of the open points, or other limits.
pub fn decode_as(file: &[u8], reading: &Reading, limits: &Limits) -> Result<Ptm> {
    let stored = open_as(file, reading, limits)?;
    Ok(Ptm {
        header: stored.header,
        planes: stored.planes(limits)?,
    })
}

/// Reads `file` as the reference does and leaves its values where they are stored: for maps that are passed on in
/// pieces. What [`decode`] refuses, this refuses too, before there is a first piece.
///
/// ```
/// let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\nbottomupper.botTOP";
/// let map = ptm_conform::decode::open(file)?;
/// let rows: Vec<_> = map.pieces().map(|piece| piece.planes.samples).collect();
/// assert_eq!(rows, [b"upper.TOP", b"bottombot"]);
/// # Ok::<(), ptm_conform::Error>(())
/// ```
pub fn open(file: &[u8]) -> Result<Stored<'_>> {
    open_as(file, &Reading::SPEC, &Limits::default())
}

/// Reads `file` under another reading of the open points, or other limits, and leaves its values where they are stored.
pub fn open_as<'a>(file: &'a [u8], reading: &'a Reading, limits: &Limits) -> Result<Stored<'a>> {
    let mut input = Input::new(file);
    let header = read_header(&mut input)?;
    read_values(&header, &mut input, reading, limits)
}

/// The fields of `file` as far as they can be read, in file order; and the error that ended the reading, if one did.
#[must_use]
pub fn fields(file: &[u8]) -> (Vec<Field>, Option<Error>) {
    let (fields, outcome) = examine(file);
    (fields, outcome.err())
}

/// The fields of `file` as far as they can be read, in file order; and what [`decode`] makes of it.
pub fn examine(file: &[u8]) -> (Vec<Field>, Result<Ptm>) {
    examine_as(file, &Reading::SPEC)
}

/// The fields of `file` under another reading of the open points, and what [`decode_as`] makes of it.
pub fn examine_as(file: &[u8], reading: &Reading) -> (Vec<Field>, Result<Ptm>) {
    let mut input = Input::new(file);
    let outcome = read_header(&mut input).and_then(|header| {
        let stored = read_values(&header, &mut input, reading, &Limits::default())?;
        Ok(Ptm {
            planes: stored.planes(&Limits::default())?,
            header,
        })
    });
    (input.into_fields(), outcome)
}

/// 2.1–2.4.
fn read_header(input: &mut Input) -> Result<Header> {
    header_string::read(input)?;
    let format = format_string::read(input)?;
    let size = image_size::read(input)?;
    let scale_bias = scale_bias::read(input)?;
    Ok(Header {
        format,
        size,
        scale_bias,
    })
}

/// 2.5–2.9. What follows the last value belongs to nobody and is left alone (ruling `trailing`).
fn read_values<'a>(
    header: &Header,
    input: &mut Input<'a>,
    reading: &'a Reading,
    limits: &Limits,
) -> Result<Stored<'a>> {
    let (shape, parts) = match header.format {
        Format::Rgb => (Shape::Rgb, texels::read(header, input, reading)?),
        Format::Lrgb => (Shape::Lrgb, texels::read(header, input, reading)?),
        Format::Lum => {
            let matrix = color_matrix::read(input)?;
            (Shape::Lum(matrix), texels::read(header, input, reading)?)
        }
        Format::PtmLut | Format::PtmCLut => {
            let table = lookup_table::read(header.format, input, reading)?;
            (Shape::Lrgb, indices::read(header, table, input, reading)?)
        }
        Format::JpegRgb | Format::JpeglsRgb => (
            Shape::Rgb,
            compressed::read(header, input, reading, limits)?,
        ),
        Format::JpegLrgb | Format::JpeglsLrgb => (
            Shape::Lrgb,
            compressed::read(header, input, reading, limits)?,
        ),
    };
    Ok(Stored {
        header: *header,
        shape,
        parts,
        at: input.at(),
        reading,
    })
}
