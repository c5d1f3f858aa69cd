//! §2.9.8 Compressed Coefficient Planes
//!
//! The planes follow one another in the order of the format, regardless of the order in which they are decoded (clause 2.9.8/1).
//! Each is a complete JPEG or JPEG-LS stream (clause 2.9.8/3), directly followed by its side information (clause 2.9.8/4):
//! records of five bytes, each a big-endian position and the value of the texel at that position (clause 2.9.8/5).
//!
//! ```text
//! stream 0 │ side information 0 │ stream 1 │ side information 1 │ …        sizes from §2.9.6 and §2.9.7
//!
//! 00 00 01 02 FF     a record: the texel with stored index 258 is 255
//! ```
//!
//! Records are needed because lossy codecs change residuals. A texel of 255 with a predictor of 200 has the residual 255 − 200 +
//! 128 = 183. If a codec returns 184, the error is only one, but the texel becomes 184 + 200 − 128 = 256, which wraps to 0.
//!
//! Format notes
//! - Lossy coding of values modulo 256 may turn 255 into 0. Records overwrite these texels, even in intra planes, before other
//!   planes are predicted from the corrected plane (clause 2.9.8/7).
//! - A position is the index of a texel in stored order. The first stored row is the bottom row of the image (clause
//!   2.9.8/6, ruling `side-information`).
//! - A stream defines its own tables, sampling factors and NEAR. The format prescribes only its size, one component and 8 bits
//!   (ruling `plane-stream`).
//! - A stream is self-contained: its tables and parameters do not apply to other planes.
//! - Records are applied regardless of the parameter, even in lossless files (ruling `side-lossless`). If two
//!   records have the same position, the last one wins (ruling `side-twice`).

use std::borrow::Cow;

use super::channels::{Channels, ValueLayout};
use super::predict;
use crate::codec::StreamFault;
use crate::error::{Error, Kind, Result};
use crate::input::Input;
use crate::parts::{Block, Coded, Plan, PlaneStream, Record};
use crate::reading::Reading;
use crate::types::{Coding, Header, Limits};

/// Reads the payload of a compressed file. Returns an error if the payload is incomplete (clause 2.9.8/2, ruling `payload-end`)
/// or its planes are too large. `declared_size` is the size of the payload if the byte ranges in `plan` overflow.
pub(super) fn take_payload<'a>(
    header: &Header,
    plan: &Plan,
    declared_size: u64,
    input: &mut Input<'a>,
    limits: &Limits,
) -> Result<&'a [u8]> {
    let parts = plan.extents.iter().flat_map(|extent| {
        let stream = ("2.9.8/2", "a compressed plane", extent.stream.clone());
        let side = ("2.9.8/4", "side information", extent.side.clone());
        [stream, side]
    });
    let ends = parts.clone().map(|(_, _, range)| range.end);
    let end = match ends.max().unwrap_or_default() {
        usize::MAX => declared_size,
        end => end as u64,
    };
    let what = "the compressed planes and their side information";
    let payload = input.take_parts("2.9.8/2", what, end, parts)?;
    // All planes are kept, because other planes may be predicted from them and the texels are assembled at the end.
    let planes = header.size.bytes(plan.steps.len());
    limits.check(planes, input.at())?;
    Ok(payload)
}

/// Decodes the streams in the order in which the planes are decoded (clause 2.9.8/3).
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn residuals(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    let decode = |&plane: &usize| (reading.stream)(&coded.stream(plane));
    coded.plan.sequence.iter().map(decode).collect()
}

/// Predicts and corrects the planes one by one, lowest rank first (clause 2.9.4/2). Returns all planes as they are stored, bottom
/// row first. `residuals` are the decoded streams in decoding order.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn reconstruct(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
) -> Result<Vec<Vec<u8>>> {
    // A reference has a lower rank (clause 2.9.4/2), so it is in `planes` when it is needed.
    let mut planes = coded.blank_planes();
    for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
        coded.predict(i, &mut plane, &planes, reading);
        // Correct the plane before another plane is predicted from it (clause 2.9.8/7).
        coded.correct(i, &mut plane, reading)?;
        planes[i] = plane;
    }
    Ok(planes)
}

/// Converts each plane to a part with one channel.
pub(super) fn planes_to_channels(planes: Vec<Vec<u8>>) -> Vec<Channels<'static>> {
    let to_channel = |(channel, plane)| Channels {
        block: Block {
            channel,
            channels: 1,
            clause: "2.9.8/1",
        },
        values: ValueLayout::Bytes(Cow::Owned(plane)),
    };
    planes.into_iter().enumerate().map(to_channel).collect()
}

impl<'a> Coded<'a> {
    /// Returns the stream of a plane.
    pub(crate) fn stream(&self, plane: usize) -> PlaneStream<'a> {
        let extent = self.plan.extents[plane].stream.clone();
        PlaneStream {
            coding: self.coding,
            plane,
            at: self.at + extent.start,
            bytes: &self.payload[extent],
            size: self.size,
        }
    }

    /// Returns one plane of zeros for each plane in the file.
    #[must_use]
    pub fn blank_planes(&self) -> Vec<Vec<u8>> {
        let blank = |_| vec![0; self.size.texels()];
        self.plan.steps.iter().map(blank).collect()
    }

    /// Adds the predictor to `plane`, which holds the residuals of plane `i`. Does nothing if there is no reference (clause
    /// 2.9.5/2).
    pub fn predict(&self, i: usize, plane: &mut [u8], planes: &[Vec<u8>], reading: &Reading) {
        let step = &self.plan.steps[i];
        if let Some(reference) = step.reference {
            let reference = &planes[reference];
            predict::predict_plane(self.coding, plane, reference, step, self.size, reading);
        }
    }

    /// Applies the side information of plane `i`.
    ///
    /// # Errors
    /// Returns the violated clause, the byte offset, and what was found there.
    pub fn correct(&self, i: usize, plane: &mut [u8], reading: &Reading) -> Result<()> {
        let at = self.at + self.plan.extents[i].side.start;
        let block = (reading.side_information)(self, i);
        let records = (reading.records)(block, at, self.size.texels())?;
        (reading.correct)(plane, &records);
        Ok(())
    }
}

/// Decodes a stream and returns its samples in stored order (clause 2.9.8/3).
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn decode_stream(stream: &PlaneStream) -> Result<Vec<u8>> {
    let (width, height) = (stream.size.width, stream.size.height);
    // plane-stream: a stream with a different size is rejected before memory is allocated for it. JPEG streams use
    // the integer inverse transform of the IJG (clause 2.9.8/11).
    let samples = stream.coding.decode(stream.bytes, width, height);
    samples.map_err(|error| {
        let kind = Kind::Stream {
            plane: stream.plane,
            unsupported: error.fault == StreamFault::Unsupported,
            what: error.what,
        };
        Error::new("2.9.8/3", stream.at + error.offset, kind)
    })
}

/// Returns the side information of a plane, regardless of the parameter (clause 2.9.8/10, ruling `side-lossless`).
#[must_use]
pub fn side_information<'a>(coded: &Coded<'a>, plane: usize) -> &'a [u8] {
    &coded.payload[coded.plan.extents[plane].side.clone()]
}

/// Returns the side information of a plane, or an empty block for lossless JPEG-LS (alternative to ruling `side-lossless`).
#[must_use]
pub fn side_information_if_lossy<'a>(coded: &Coded<'a>, plane: usize) -> &'a [u8] {
    if coded.coding == Coding::JpegLs && coded.plan.parameter == 0 {
        &[]
    } else {
        side_information(coded, plane)
    }
}

/// Parses a block of side information into positions and values (clause 2.9.8/5).
///
/// `at` is the offset of the block in the file, for errors.
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn parse_records(block: &[u8], at: usize, texels: usize) -> Result<Vec<Record>> {
    // P3, P2, P1, P0, V, without separators.
    let (records, rest) = block.as_chunks::<5>();
    if !rest.is_empty() {
        // side-malformed
        return Err(Error::new(
            "2.9.8/5",
            at,
            Kind::PartialRecord { bytes: block.len() },
        ));
    }
    let parse = |(i, &[p3, p2, p1, p0, value]): (usize, &[u8; 5])| {
        let position = u32::from_be_bytes([p3, p2, p1, p0]);
        // side-malformed: positions are zero-based, so the number of texels is already out of range.
        if position as usize >= texels {
            return Err(Error::new(
                "2.9.8/6",
                at + 5 * i,
                Kind::PositionOutOfRange { position, texels },
            ));
        }
        Ok((position, value))
    };
    records.iter().enumerate().map(parse).collect()
}

/// Overwrites decoded values with the values of records (clause 2.9.8/8). If records have the same position, the last
/// one wins (ruling `side-twice`).
pub fn overwrite_samples(plane: &mut [u8], records: &[Record]) {
    for &(position, value) in records {
        plane[position as usize] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::{Extent, Plan};

    #[test]
    fn side_information_of_lossless_jpeg_ls_is_skipped_under_the_other_reading() {
        for (coding, parameter, expected) in [
            (Coding::JpegLs, 0, &[][..]),
            (Coding::JpegLs, 3, &[2, 3]),
            (Coding::Jpeg, 0, &[2, 3]),
        ] {
            let (stream, side) = (0..1, 1..3);
            let plan = Plan {
                parameter,
                steps: Vec::new(),
                sequence: Vec::new(),
                extents: vec![Extent { stream, side }],
            };
            let (size, plan, payload) = ("1x1".parse().expect("a size"), &plan, &[1, 2, 3]);
            let at = 0;
            let coded = Coded {
                coding,
                size,
                plan,
                at,
                payload,
            };
            assert_eq!(side_information_if_lossy(&coded, 0), expected);
        }
    }
}
