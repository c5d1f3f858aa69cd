//! The reference decoder: bytes → header → planes. Each section of the text has one file.
//!
//! ```text
//! 50 54 4D 5F 31 2E 32 0A                    PTM_1.2                    header_string     §2.1
//! 50 54 4D 5F … 5F 4C 52 47 42 0A            PTM_FORMAT_LRGB            format_string     §2.2
//! 31 0A 31 0A                                1, 1                       image_size        §2.3
//! 31 20 31 20 31 20 31 20 31 20 31 0A        1 1 1 1 1 1                scale_bias        §2.4
//! 30 20 30 20 30 20 30 20 30 20 30 0A        0 0 0 0 0 0
//! 01 02 03 04 05 06 72 67 62                 a0 … a5, R, G, B           texels            §2.7
//! ```
//!
//! [`decode`] is the entry point. This module does no I/O, does not depend on file names, and contains no misreadings.
//!
//! The modules of the sections contain the functions of the decisions in [`Reading`], and beside each the alternatives that are
//! equally correct.

#![allow(
    clippy::missing_errors_doc,
    clippy::must_use_candidate,
    reason = "the decoder calls the functions of decisions; each returns the error of its clause"
)]

/// §2.1 Header String
mod header_string;

/// §2.2 Format String
mod format_string;

/// §2.3 Image Size
mod image_size;

/// §2.4 Scale and Bias
mod scale_bias;

/// §2.5 Lookup Table
pub mod lookup_table;

/// §2.6 Color Matrix
pub mod color_matrix;

/// §2.7 Uncompressed Per Texel Data
pub mod texels;

/// §2.8 Lookup Table Indices
pub mod indices;

/// §2.9 Compressed Data: the parameter and the lists (§2.9.1 – 2.9.7)
pub mod compressed;

/// §2.9.2 – 2.9.5 Prediction of a plane from its reference
pub mod predict;

/// §2.9.8 Compressed Coefficient Planes
pub mod planes;

/// Reuse of decoded streams under several readings
mod reuse;

/// Parallel decoding of the streams of 2.9.8
#[cfg(feature = "parallel")]
mod threads;

/// Fast displacement of a plane (2.9.3)
mod displace;

/// Parts of a file (2.7, 2.8, 2.9.8): each contains some channels of every texel
mod channels;

/// Fast copying of channels
mod runs;

/// Rows of the image, assembled from the values of 2.7, 2.8 or 2.9.8
mod stored;

/// [`Reading::SPEC`]
mod spec;

pub use compressed::Streams;

pub use stored::StoredMap;

use crate::error::{Error, Result};
use crate::input::Input;
use crate::reading::Reading;
use crate::types::{Field, Header, Limits, Ptm, Storage};

/// Decodes `file` under the reading of the reference.
///
/// ```
/// let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n\x01\x02\x03\x04\x05\x06rgb";
/// let ptm = ptm::decode(file)?;
/// assert_eq!(ptm.planes.samples, b"\x01\x02\x03\x04\x05\x06rgb");
/// # Ok::<(), ptm::Error>(())
/// ```
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn decode(file: &[u8]) -> Result<Ptm> {
    decode_as(file, &Reading::SPEC, &Limits::default())
}

/// Decodes `file` under a different reading of the open questions, or with different limits.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn decode_as(file: &[u8], reading: &Reading, limits: &Limits) -> Result<Ptm> {
    open_as(file, reading, limits)?.decode(limits)
}

/// Parses `file` like [`decode`], but leaves the values where they are stored, so that large maps can be processed in
/// pieces. A file that [`decode`] rejects is also rejected here, before the first piece.
///
/// ```
/// let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\nbottomupper.botTOP";
/// let map = ptm::open(file)?;
/// let rows: Vec<_> = map.pieces().map(|piece| piece.planes.samples).collect();
/// assert_eq!(rows, [b"upper.TOP", b"bottombot"]);
/// # Ok::<(), ptm::Error>(())
/// ```
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn open(file: &[u8]) -> Result<StoredMap<'_>> {
    open_as(file, &Reading::SPEC, &Limits::default())
}

/// Decodes `file` like [`decode`], with different limits.
///
/// # Errors
/// Returns the violated clause or the exceeded limit, the byte offset, and what was found there.
pub fn decode_with_limits(file: &[u8], limits: &Limits) -> Result<Ptm> {
    decode_as(file, &Reading::SPEC, limits)
}

/// Parses `file` like [`open`], but under a different reading of the open questions, or with different limits.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn open_as<'a>(file: &'a [u8], reading: &'a Reading, limits: &Limits) -> Result<StoredMap<'a>> {
    read_map(&mut Input::new(file), reading, limits)
}

/// Returns the fields of `file` in file order, up to the first error, and that error, if any.
#[must_use]
pub fn fields(file: &[u8]) -> (Vec<Field>, Option<Error>) {
    let (fields, outcome) = examine(file);
    (fields, outcome.err())
}

/// Returns the fields of `file` in file order, up to the first error, and the result of [`decode`].
pub fn examine(file: &[u8]) -> (Vec<Field>, Result<Ptm>) {
    examine_as(file, &Reading::SPEC)
}

/// Returns the fields of `file` under a different reading of the open questions, and the result of [`decode_as`].
pub fn examine_as(file: &[u8], reading: &Reading) -> (Vec<Field>, Result<Ptm>) {
    let (mut input, limits) = (Input::new(file), Limits::default());
    let outcome = read_map(&mut input, reading, &limits).and_then(|map| map.decode(&limits));
    (input.into_fields(), outcome)
}

/// Returns the fields of `file`, the result of [`decode`] and, for a compressed file with complete streams, the decoded streams.
pub fn examine_streams(file: &[u8]) -> (Vec<Field>, Result<Ptm>, Option<Streams<'_>>) {
    const SPEC: &Reading = &Reading::SPEC;
    let (mut input, limits) = (Input::new(file), Limits::default());
    let mut streams = None;
    let outcome = read_header(&mut input).and_then(|header| {
        let stored = match header.format.coding() {
            Some(coding) => streams
                .insert(Streams::read(&header, coding, &mut input, SPEC, &limits)?)
                .reconstruct_map(SPEC)?,
            None => read_values(&header, &mut input, SPEC, &limits)?,
        };
        stored.decode(&limits)
    });
    (input.into_fields(), outcome, streams)
}

/// Returns the fields of `file` under a different reading of the open questions, up to the first error. Does not decode the values,
/// so it is faster than [`examine_as`].
pub fn fields_as(file: &[u8], reading: &Reading) -> Vec<Field> {
    let mut input = Input::new(file);
    // Without memory for the planes, reading ends before the streams are decoded, but after the last field.
    let limits = Limits { memory: 0 };
    let (Ok(_) | Err(_)) = read_map(&mut input, reading, &limits);
    input.into_fields()
}

fn read_map<'a>(
    input: &mut Input<'a>,
    reading: &'a Reading,
    limits: &Limits,
) -> Result<StoredMap<'a>> {
    let header = read_header(input)?;
    read_values(&header, input, reading, limits)
}

/// Reads the header (2.1–2.4).
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn read_header(input: &mut Input) -> Result<Header> {
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

/// Reads the values (2.5–2.9). Bytes after the last value are ignored (ruling `trailing`).
fn read_values<'a>(
    header: &Header,
    input: &mut Input<'a>,
    reading: &'a Reading,
    limits: &Limits,
) -> Result<StoredMap<'a>> {
    let shape = header.format.shape();
    let shape = shape.with_matrix(|| color_matrix::read(input))?;
    // The nine formats become three shapes. Later code does not use the format.
    let parts = match header.format.storage() {
        Storage::Texels => texels::read(header, input, reading)?,
        Storage::Table | Storage::ColorTable => {
            let table = lookup_table::read(header.format, input, reading)?;
            indices::read(header, table, input, reading)?
        }
        Storage::Streams(coding) => compressed::read(header, coding, input, reading, limits)?,
    };
    Ok(StoredMap {
        header: *header,
        shape,
        parts,
        at: input.at(),
        reading,
    })
}
