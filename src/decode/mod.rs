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

pub(crate) use input::Input;

use crate::error::{Error, Kind, Result};
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
    let mut input = Input::new(file);
    let header = read_header(&mut input)?;
    let planes = read_planes(&header, &mut input, reading, limits)?;
    Ok(Ptm { header, planes })
}

/// The fields of `file` as far as they can be read, in file order; and the error that ended the reading, if one did.
#[must_use]
pub fn fields(file: &[u8]) -> (Vec<Field>, Option<Error>) {
    let mut input = Input::new(file);
    let outcome = read_header(&mut input).and_then(|header| {
        read_planes(&header, &mut input, &Reading::SPEC, &Limits::default()).map(|_| ())
    });
    (input.into_fields(), outcome.err())
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
fn read_planes(
    header: &Header,
    input: &mut Input,
    reading: &Reading,
    limits: &Limits,
) -> Result<Planes> {
    match header.format {
        Format::Rgb => texels::read(header, Shape::Rgb, input, reading, limits),
        Format::Lrgb => texels::read(header, Shape::Lrgb, input, reading, limits),
        Format::Lum => {
            let matrix = color_matrix::read(input)?;
            texels::read(header, Shape::Lum(matrix), input, reading, limits)
        }
        Format::PtmLut | Format::PtmCLut => {
            let table = lookup_table::read(header.format, input, reading)?;
            indices::read(header, &table, input, reading, limits)
        }
        Format::JpegRgb | Format::JpegLrgb | Format::JpeglsRgb | Format::JpeglsLrgb => {
            compressed::read(header, input, reading, limits)
        }
    }
}

/// Planes of `header.size` full of zeros, if the limit allows them.
fn blank(header: &Header, shape: Shape, limits: &Limits, input: &Input) -> Result<Planes> {
    check_room(header, shape.channels(), limits, input)?;
    Ok(Planes {
        size: header.size,
        shape,
        samples: vec![0; header.size.texels() * shape.channels()],
    })
}

/// Whether the limit allows that many planes at a time.
fn check_room(header: &Header, planes: usize, limits: &Limits, input: &Input) -> Result<()> {
    let needs = header.size.texels().saturating_mul(planes);
    if needs > limits.memory {
        return Err(Error::new(
            "2.3/3",
            input.at(),
            Kind::TooLarge {
                needs,
                limit: limits.memory,
            },
        ));
    }
    Ok(())
}
