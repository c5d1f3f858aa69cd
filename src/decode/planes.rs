//! §2.9.8 Compressed Coefficient Planes
//!
//! The planes lie one after another in the order of the format, whatever the order in which they
//! are decoded (clause 2.9.8/1). Each is a whole JPEG or JPEG-LS stream (clause 2.9.8/3), directly
//! followed by its side information (clause 2.9.8/4): records of five bytes, a position
//! (big-endian) and the value of that texel (clause 2.9.8/5).
//!
//! ```text
//! stream 0 │ side information 0 │ stream 1 │ side information 1 │ …        sizes from §2.9.6 and §2.9.7
//!
//! 00 00 01 02 FF     a record: the stored texel 258 is 255
//! ```
//!
//! Why there are records: let a texel be 255 and its predictor 200, so that its residual is 255 −
//! 200 + 128 = 183. A lossy codec may return 184 for it. That is an error of one, but the texel
//! becomes 184 + 200 − 128 = 256, which wraps to 0.
//!
//! Format notes
//! - Lossy coding of numbers that wrap sometimes turns a 255 into a 0. Records overwrite such texels, intra planes
//!   included, before any other plane is predicted from this one (clause 2.9.8/7).
//! - A position counts texels as they are stored, and the first stored row is the bottom row of the image (clause
//!   2.9.8/6, ruling `side-information`).
//! - A stream decides its own tables, sampling factors and NEAR. The file prescribes only its size, its one component and
//!   its 8 bits (ruling `plane-stream`).
//! - A stream is complete: its tables and parameters do not apply to other planes.
//! - Records are applied whatever the parameter is, in lossless files as well (ruling `side-lossless`); of two records
//!   for one texel the later counts (ruling `side-twice`).

use std::borrow::Cow;

use super::channels::{Channels, Values};
use super::predict;
use crate::codec::{StreamFault, jpeg, jpeg_ls};
use crate::error::{Error, Kind, Result};
use crate::input::Input;
use crate::parts::{Block, Coded, Plan, PlaneStream, Record};
use crate::ptm::{Header, Limits};
use crate::reading::Reading;

/// Takes the payload of a compressed file, if it is complete (clause 2.9.8/2, ruling `payload-end`) and its planes are not too
/// large. `announced` is its size if the plan could not count it.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "limits and headers are passed by reference whatever their size"
)]
pub(super) fn take<'a>(
    header: &Header,
    plan: &Plan,
    announced: u64,
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
        usize::MAX => announced,
        end => end as u64,
    };
    let what = "the compressed planes and their side information";
    let payload = input.take_parts("2.9.8/2", what, end, parts)?;
    // Every plane is kept, because others may be predicted from it and the texels are made at the end.
    let planes = header.size.bytes(plan.steps.len());
    limits.check(planes, input.at())?;
    Ok(payload)
}

/// Decodes the streams, in the order in which the planes are decoded (clause 2.9.8/3).
pub(crate) fn residuals(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    let one = |&plane: &usize| (reading.stream)(&coded.stream(plane));
    coded.plan.sequence.iter().map(one).collect()
}

/// Returns all planes as they are stored, bottom row first: predicted and corrected one after another, lowest rank first
/// (clause 2.9.4/2). `residuals` are the decoded streams, in that order.
pub(crate) fn reconstruct(
    coded: &Coded,
    residuals: Vec<Vec<u8>>,
    reading: &Reading,
) -> Result<Vec<Vec<u8>>> {
    // A reference that exists has a lower rank (clause 2.9.4/2), so it is in `planes` when it is needed.
    let mut planes = coded.blank_planes();
    for (&i, mut plane) in coded.plan.sequence.iter().zip(residuals) {
        coded.predict(i, &mut plane, &planes, reading);
        // Corrected before another plane is predicted from it (clause 2.9.8/7).
        coded.correct(i, &mut plane, reading)?;
        planes[i] = plane;
    }
    Ok(planes)
}

/// Converts planes to channels of every texel, one plane each.
pub(super) fn channels(planes: Vec<Vec<u8>>) -> Vec<Channels<'static>> {
    let one = |(channel, plane)| Channels {
        block: Block {
            channel,
            channels: 1,
        },
        values: Values::Bytes(Cow::Owned(plane)),
    };
    planes.into_iter().enumerate().map(one).collect()
}

impl<'a> Coded<'a> {
    /// Returns the stream of plane `plane`.
    pub(crate) fn stream(&self, plane: usize) -> PlaneStream<'a> {
        let extent = self.plan.extents[plane].stream.clone();
        PlaneStream {
            format: self.format,
            plane,
            at: self.at + extent.start,
            bytes: &self.payload[extent],
            size: self.size,
        }
    }

    /// Returns a plane of zeros for each plane to be decoded.
    pub(crate) fn blank_planes(&self) -> Vec<Vec<u8>> {
        let blank = |_| vec![0; self.size.texels()];
        self.plan.steps.iter().map(blank).collect()
    }

    /// Adds the predictor to `plane`, the residuals of plane `i`; does nothing if it has no reference (clause 2.9.5/2).
    pub(crate) fn predict(
        &self,
        i: usize,
        plane: &mut [u8],
        planes: &[Vec<u8>],
        reading: &Reading,
    ) {
        let step = &self.plan.steps[i];
        if let Some(reference) = step.reference {
            let reference = &planes[reference];
            predict::apply(self.format, plane, reference, step, self.size, reading);
        }
    }

    /// Writes the values of the side information of plane `i` to their places.
    pub(crate) fn correct(&self, i: usize, plane: &mut [u8], reading: &Reading) -> Result<()> {
        let at = self.at + self.plan.extents[i].side.start;
        let block = (reading.side_information)(self, i);
        let records = (reading.records)(block, at, self.size.texels())?;
        (reading.correct)(plane, &records);
        Ok(())
    }
}

/// Returns the samples of a stream, in the order in which they are stored (clause 2.9.8/3).
pub(crate) fn stream(stream: &PlaneStream) -> Result<Vec<u8>> {
    let (width, height) = (stream.size.width, stream.size.height);
    // plane-stream: a stream of another size is refused before memory is allocated for it.
    let samples = if stream.format.is_jpeg() {
        // With the integer inverse transform of the IJG (clause 2.9.8/11).
        jpeg::decode(stream.bytes, width, height)
    } else {
        jpeg_ls::decode(stream.bytes, width, height)
    };
    samples.map_err(|error| {
        let kind = Kind::Stream {
            plane: stream.plane,
            unsupported: error.fault == StreamFault::Unsupported,
            what: error.what,
        };
        Error::new("2.9.8/3", stream.at + error.offset, kind)
    })
}

/// Returns the side information of a plane: all of it, whatever the parameter is (clause 2.9.8/10, ruling `side-lossless`).
pub(crate) fn side_information<'a>(coded: &Coded<'a>, plane: usize) -> &'a [u8] {
    &coded.payload[coded.plan.extents[plane].side.clone()]
}

/// Returns no side information for lossless JPEG-LS, so that its bytes are skipped: the other reading of `side-lossless`.
pub(crate) fn side_information_if_lossy<'a>(coded: &Coded<'a>, plane: usize) -> &'a [u8] {
    if coded.format.is_jpeg_ls() && coded.plan.parameter == 0 {
        &[]
    } else {
        side_information(coded, plane)
    }
}

/// Reads the records of a block of side information: positions and values (clause 2.9.8/5).
///
/// `at` is the position of the block in the file, for errors.
pub(crate) fn records(block: &[u8], at: usize, texels: usize) -> Result<Vec<Record>> {
    // P3, P2, P1, P0, V, and nothing between records.
    let (whole, rest) = block.as_chunks::<5>();
    if !rest.is_empty() {
        // side-malformed
        return Err(Error::new(
            "2.9.8/5",
            at,
            Kind::PartialRecord { bytes: block.len() },
        ));
    }
    let one = |(i, &[p3, p2, p1, p0, value]): (usize, &[u8; 5])| {
        let position = u32::from_be_bytes([p3, p2, p1, p0]);
        // side-malformed: positions count from 0, so the number of texels is already out of range.
        if position as usize >= texels {
            return Err(Error::new(
                "2.9.8/6",
                at + 5 * i,
                Kind::PositionOutOfRange { position, texels },
            ));
        }
        Ok((position, value))
    };
    whole.iter().enumerate().map(one).collect()
}

/// Replaces decoded values by those of records (clause 2.9.8/8); of two records, the later counts (ruling `side-twice`).
pub(crate) fn overwrite(plane: &mut [u8], records: &[Record]) {
    for &(position, value) in records {
        plane[position as usize] = value;
    }
}

#[cfg(feature = "generate")]
#[cfg(test)]
mod tests {
    use super::super::by_hand::{ByHand, assert_rejects, stored};
    use crate::codec::{jpeg, jpeg_ls};
    use crate::decode::decode_as;
    use crate::error::Class;
    use crate::ptm::{Format, Limits};
    use crate::{Reading, decode};

    /// Returns a file of two columns and three rows; plane 0 counts from 1 to 6 in stored order.
    fn counted() -> ByHand {
        let mut file = ByHand::new(Format::JpeglsLrgb, 2, 3);
        file.stream(0, &[1, 2, 3, 4, 5, 6]);
        file
    }

    /// Returns the position of the stream of plane `plane`.
    fn start(file: &ByHand, plane: usize) -> usize {
        let parts = file.streams[plane..].iter().chain(&file.sides[plane..]);
        file.bytes().len() - parts.map(Vec::len).sum::<usize>()
    }

    #[test]
    fn the_bottom_row_is_stored_first() {
        let ptm = decode(&counted().bytes()).unwrap();
        let a0: Vec<u8> = ptm.planes.texels().map(|texel| texel[0]).collect();
        assert_eq!(a0, [5, 6, 3, 4, 1, 2]);
    }

    #[test]
    fn planes_lie_in_their_own_order_whatever_their_ranks() {
        let mut file = counted();
        file.order = vec![8, 7, 6, 5, 4, 3, 2, 1, 0];
        assert_eq!(stored(&file.bytes(), 0), [1, 2, 3, 4, 5, 6]);
        assert_eq!(stored(&file.bytes(), 8), [80; 6]);
    }

    #[test]
    fn side_information_counts_stored_texels_from_zero_to_the_last() {
        let mut file = counted();
        file.record(0, 0, 77);
        file.record(0, 5, 99);
        assert_eq!(stored(&file.bytes(), 0), [77, 2, 3, 4, 5, 99]);
        // The planes after it are in their places.
        assert_eq!(stored(&file.bytes(), 1), [10; 6]);
    }

    #[test]
    #[expect(
        clippy::naive_bytecount,
        reason = "files are small where bytes are counted"
    )]
    fn a_position_has_its_high_byte_first() {
        let mut file = ByHand::new(Format::JpeglsLrgb, 300, 1);
        file.record(2, 256, 1);
        file.record(2, 1, 2);
        let plane = stored(&file.bytes(), 2);
        assert_eq!((plane[256], plane[1]), (1, 2));
        assert_eq!(plane.iter().filter(|&&value| value == 20).count(), 298);
    }

    #[test]
    fn the_later_of_two_records_wins() {
        let mut file = counted();
        file.record(0, 3, 8);
        file.record(0, 3, 9);
        assert_eq!(stored(&file.bytes(), 0), [1, 2, 3, 9, 5, 6]);
    }

    #[test]
    fn side_information_overwrites_after_prediction() {
        let mut file = counted();
        file.predicted(1, 1, 0, 0, &[128, 128, 128, 128, 128, 0]);
        file.record(1, 5, 200);
        assert_eq!(stored(&file.bytes(), 1), [1, 2, 3, 4, 5, 200]);
    }

    #[test]
    fn a_reference_is_corrected_before_its_dependants() {
        let mut file = counted();
        file.record(0, 1, 102);
        file.predicted(4, 1, 0, 0, &[130; 6]);
        file.record(4, 0, 50);
        file.predicted(2, 2, 4, 1, &[128; 6]);
        assert_eq!(stored(&file.bytes(), 4), [50, 104, 5, 6, 7, 8]);
        assert_eq!(stored(&file.bytes(), 2), [205, 151, 250, 249, 248, 247]);
    }

    #[test]
    fn side_information_counts_in_lossless_files_except_under_the_other_reading() {
        let mut file = counted();
        file.record(0, 0, 77);
        let other = decode_as(
            &file.bytes(),
            &Reading::SPEC.with_side_information_only_if_lossy(),
            &Limits::default(),
        )
        .unwrap();
        assert_eq!(other.planes.samples[4 * 9], 1);
        assert_eq!(other.planes.samples[1], 10);
        assert_eq!(stored(&file.bytes(), 0)[0], 77);
        file.parameter = 3;
        let other = decode_as(
            &file.bytes(),
            &Reading::SPEC.with_side_information_only_if_lossy(),
            &Limits::default(),
        )
        .unwrap();
        assert_eq!(other.planes.samples[4 * 9], 77);
    }

    #[test]
    fn transforms_and_vectors_of_intra_planes_are_not_looked_at() {
        let mut file = counted();
        file.transforms[0] = 3;
        file.displace(0, 5, -7);
        assert_eq!(stored(&file.bytes(), 0), [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn vectors_count_only_with_their_bit() {
        let mut file = counted();
        file.predicted(1, 1, 0, 1, &[128; 6]);
        file.displace(1, 2, 2);
        file.predicted(2, 1, 0, 2, &[128; 6]);
        file.displace(2, 2, 2);
        file.predicted(3, 1, 0, 3, &[128; 6]);
        file.displace(3, 2, -1);
        assert_eq!(stored(&file.bytes(), 1), [254, 253, 252, 251, 250, 249]);
        assert_eq!(stored(&file.bytes(), 2), [4, 4, 6, 6, 6, 6]);
        // Column 1 twice, half a row down: inverted 253, 251, 249; (253 + 253 + 1) >> 1, (251 + 253 + 1) >> 1, …
        assert_eq!(stored(&file.bytes(), 3), [253, 253, 252, 252, 250, 250]);
    }

    #[test]
    fn side_information_of_partial_records_is_refused() {
        let mut file = counted();
        file.record(3, 0, 1);
        file.sides[3].pop();
        let at = start(&file, 3) + file.streams[3].len();
        assert_rejects(
            &file.bytes(),
            &format!(
                "compressed data (§2.9.8), byte {at}: 4 bytes of side information are no whole number of records of 5 bytes"
            ),
        );
    }

    #[test]
    fn positions_past_the_last_texel_are_refused() {
        for position in [6, u32::MAX] {
            let mut file = counted();
            file.record(8, 1, 1);
            file.record(8, position, 1);
            let at = file.bytes().len() - 5;
            assert_rejects(
                &file.bytes(),
                &format!(
                    "compressed data (§2.9.8), byte {at}: a record for texel {position}, the last texel is 5"
                ),
            );
        }
    }

    #[test]
    fn streams_that_are_no_such_plane_are_refused_where_they_show_it() {
        let stream_8x8 = jpeg::encode(&[7; 64], 8, 8, &jpeg::JpegOptions::new(100)).stream;
        let mut file = ByHand::new(Format::JpegLrgb, 16, 8);
        file.streams[4] = stream_8x8;
        // SOI, APP0 with 16 bytes, DQT with 67: the frame's size follows FFC0, its length and its precision.
        let frame = file.streams[4]
            .windows(2)
            .position(|pair| pair == [0xFF, 0xC0])
            .unwrap();
        let at = start(&file, 4) + frame + 5;
        assert_rejects(
            &file.bytes(),
            &format!(
                "compressed data (§2.9.8), byte {at}: plane 4: expected 16 x 8 samples, found 8 x 8"
            ),
        );

        let mut file = counted();
        file.streams[2] = Vec::new();
        assert_rejects(
            &file.bytes(),
            &format!(
                "compressed data (§2.9.8), byte {}: plane 2: the stream is empty",
                start(&file, 2)
            ),
        );
        file.streams[2] = vec![0; 9];
        assert_rejects(
            &file.bytes(),
            &format!(
                "compressed data (§2.9.8), byte {}: plane 2: the stream does not start with SOI, bytes FF D8",
                start(&file, 2)
            ),
        );
    }

    #[test]
    fn kinds_of_streams_that_are_not_read_are_unsupported() {
        let mut file = counted();
        let precision = file.streams[1]
            .windows(2)
            .position(|pair| pair == [0xFF, 0xF7])
            .unwrap()
            + 4;
        file.streams[1][precision] = 12;
        let error = decode(&file.bytes()).unwrap_err();
        assert_eq!(error.class(), Class::Unsupported);
        assert_eq!(error.offset(), start(&file, 1) + precision);
    }

    #[test]
    fn the_other_codec_is_refused() {
        let mut file = ByHand::new(Format::JpegLrgb, 8, 8);
        file.streams[0] = jpeg_ls::encode(
            &[1; 64],
            8,
            8,
            &jpeg_ls::JpegLsOptions {
                near: 0,
                presets: None,
            },
        )
        .stream;
        assert_eq!(decode(&file.bytes()).unwrap_err().class(), Class::Malformed);
        let mut file = ByHand::new(Format::JpeglsLrgb, 8, 8);
        file.streams[0] = jpeg::encode(&[1; 64], 8, 8, &jpeg::JpegOptions::new(100)).stream;
        assert_eq!(decode(&file.bytes()).unwrap_err().class(), Class::Malformed);
    }

    #[test]
    fn all_planes_held_at_once_count_against_the_limit() {
        let file = counted().bytes();
        let limited = |memory| decode_as(&file, &Reading::SPEC, &Limits { memory });
        assert!(limited(6 * 18).is_ok());
        assert_eq!(limited(6 * 18 - 1).unwrap_err().class(), Class::Limit);
    }

    #[test]
    fn what_follows_the_last_plane_is_left_alone() {
        let file = counted().bytes();
        assert_eq!(decode(&[&file[..], b"more"].concat()), decode(&file));
    }
}
