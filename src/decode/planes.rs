//! §2.9.8 Compressed Coefficient Planes
//!
//! The planes lie one after another in the order of the format, whatever the order in which they are decoded (clause
//! 2.9.8/1). Each is a whole JPEG or JPEG-LS stream (clause 2.9.8/3), directly followed by its side information (clause
//! 2.9.8/4): records of five bytes, a position with its high byte first and the value that belongs there (clause 2.9.8/5).
//!
//! Format notes
//! - Lossy coding of numbers that wrap turns a 255 into a 0 now and then. The records put that right, so they overwrite;
//!   and they do so before any other plane is predicted from this one (clause 2.9.8/7), intra planes included.
//! - A position counts texels as they are stored, and the first stored row is the bottom row of the picture (clause
//!   2.9.8/6, ruling `side-information`).
//! - What a stream says of itself counts: its tables, its sampling factors, its NEAR. Only its size, its one component and
//!   its 8 bits are the file's to say (ruling `plane-stream`).

use std::borrow::Cow;

use super::compressed::Plan;
use super::stored::{Part, Values};
use super::{Header, Input, Limits, predict};
use crate::codec::{self, jpeg, jpeg_ls};
use crate::error::{Error, Kind, Result};
use crate::ptm::{Format, Size};
use crate::reading::Reading;

/// All planes of a file, still compressed, and what to do with them.
pub struct Coded<'a> {
    /// JPEG or JPEG-LS.
    pub format: Format,
    /// Texels of every plane.
    pub size: Size,
    /// What to do.
    pub plan: &'a Plan,
    /// Where in the file `payload` starts.
    pub at: usize,
    /// All streams and their side information, as `plan.extents` counts them.
    pub payload: &'a [u8],
}

pub(super) fn read(
    header: &Header,
    plan: &Plan,
    input: &mut Input,
    reading: &Reading,
    limits: &Limits,
) -> Result<Vec<Part<'static>>> {
    let coded = Coded {
        format: header.format,
        size: header.size,
        plan,
        at: input.at(),
        payload: cut(plan, input)?,
    };
    // Every plane is held, for those that may be predicted from it and until the texels are made of them.
    let planes = header.size.texels().saturating_mul(plan.steps.len());
    limits.check(planes, input.at())?;
    let planes = (reading.reconstruct)(&coded, reading)?;
    let part = |(channel, plane)| Part {
        channel,
        channels: 1,
        values: Values::Bytes(Cow::Owned(plane)),
    };
    Ok(planes.into_iter().enumerate().map(part).collect())
}

/// The bytes of all planes, if they are there (clause 2.9.8/2, ruling `payload-end`).
fn cut<'a>(plan: &Plan, input: &mut Input<'a>) -> Result<&'a [u8]> {
    let parts = plan.extents.iter().flat_map(|extent| {
        let stream = ("2.9.8/2", "a compressed plane", extent.stream.clone());
        let side = ("2.9.8/4", "side information", extent.side.clone());
        [stream, side]
    });
    let end = parts
        .clone()
        .map(|(_, _, range)| range.end)
        .max()
        .unwrap_or_default();
    input.take_parts(
        "2.9.8/2",
        "the compressed planes and their side information",
        end,
        parts,
    )
}

/// All planes as they are stored, bottom row first: decoded, predicted and mended one after another, lowest rank first.
pub(crate) fn reconstruct(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    reconstruct_from(coded, reading, |i| coded.residuals(i, reading))
}

/// All planes, from what their streams hold.
fn reconstruct_from(
    coded: &Coded,
    reading: &Reading,
    mut residuals: impl FnMut(usize) -> Result<Vec<u8>>,
) -> Result<Vec<Vec<u8>>> {
    let mut planes = coded.blank_planes();
    for &i in &coded.plan.sequence {
        let mut plane = residuals(i)?;
        coded.predict(i, &mut plane, &planes, reading);
        // Corrected before anyone predicts from it (clause 2.9.8/7).
        coded.mend(i, &mut plane, reading)?;
        planes[i] = plane;
    }
    Ok(planes)
}

/// The same planes as [`reconstruct`] makes, and the same error where it has one; the streams, which hold on to nothing
/// but themselves, are decoded by as many threads as the machine has for it.
#[cfg(feature = "parallel")]
pub(crate) fn reconstruct_in_parallel(coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    /// Planes of fewer texels are done before a thread has started.
    const WORTH_A_THREAD: usize = 1 << 16;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    if threads == 1 || coded.size.texels() < WORTH_A_THREAD {
        reconstruct(coded, reading)
    } else {
        reconstruct_by(threads, coded, reading)
    }
}

#[cfg(feature = "parallel")]
fn reconstruct_by(threads: usize, coded: &Coded, reading: &Reading) -> Result<Vec<Vec<u8>>> {
    let mut residuals = coded.all_residuals(threads, reading);
    reconstruct_from(coded, reading, |i| {
        let decoded = residuals[i].take();
        // A plan with a mistake in it may ask for a plane twice.
        decoded.unwrap_or_else(|| coded.residuals(i, reading))
    })
}

impl Coded<'_> {
    /// A plane full of zeros for each plane to come.
    pub(crate) fn blank_planes(&self) -> Vec<Vec<u8>> {
        self.plan
            .steps
            .iter()
            .map(|_| vec![0; self.size.texels()])
            .collect()
    }

    /// What the stream of plane `i` holds: residuals, or the plane itself if it is intra coded (clause 2.9.8/3).
    pub(crate) fn residuals(&self, i: usize, reading: &Reading) -> Result<Vec<u8>> {
        let extent = self.plan.extents[i].stream.clone();
        let at = self.at + extent.start;
        let told = |error: codec::Error| {
            let unsupported = error.class == codec::Class::Unsupported;
            let kind = Kind::Stream {
                plane: i,
                unsupported,
                what: error.what,
            };
            Error::new("2.9.8/3", at + error.offset, kind)
        };
        (reading.stream)(self.format, i, &self.payload[extent], self.size).map_err(told)
    }

    /// What the streams of all planes hold.
    #[cfg(feature = "parallel")]
    fn all_residuals(&self, threads: usize, reading: &Reading) -> Vec<Option<Result<Vec<u8>>>> {
        use std::sync::atomic::{AtomicUsize, Ordering};

        let mut all: Vec<_> = self.plan.steps.iter().map(|_| None).collect();
        let count = all.len();
        let next = AtomicUsize::new(0);
        let decode_some = || {
            let following = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < count);
            std::iter::from_fn(following)
                .map(|i| (i, self.residuals(i, reading)))
                .collect::<Vec<_>>()
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads.min(count))
                .map(|_| scope.spawn(decode_some))
                .collect();
            for worker in workers {
                for (i, residuals) in worker.join().expect("the codecs do not panic") {
                    all[i] = Some(residuals);
                }
            }
        });
        all
    }

    /// Adds to `plane` what is predicted from its reference; nothing if it has none (clause 2.9.5/2).
    pub(crate) fn predict(
        &self,
        i: usize,
        plane: &mut [u8],
        planes: &[Vec<u8>],
        reading: &Reading,
    ) {
        let step = &self.plan.steps[i];
        if let Some(reference) = step.reference {
            predict::apply(
                self.format,
                plane,
                &planes[reference],
                step,
                self.size,
                reading,
            );
        }
    }

    /// Puts the values of the side information of plane `i` in their places.
    pub(crate) fn mend(&self, i: usize, plane: &mut [u8], reading: &Reading) -> Result<()> {
        if (reading.side_counts)(self.format, self.plan.parameter) {
            let extent = self.plan.extents[i].side.clone();
            let at = self.at + extent.start;
            let records = (reading.records)(&self.payload[extent], at, self.size.texels())?;
            (reading.mend)(plane, &records);
        }
        Ok(())
    }
}

/// The samples of a stream, in the order in which they are stored (clause 2.9.8/3).
pub(crate) fn stream(
    format: Format,
    _plane: usize,
    stream: &[u8],
    size: Size,
) -> std::result::Result<Vec<u8>, codec::Error> {
    // plane-stream: a stream of another size is refused before room is made for it.
    match format {
        // By the integer inverse transform of the IJG (clause 2.9.8/11).
        Format::JpegRgb | Format::JpegLrgb => jpeg::decode(stream, size.width, size.height),
        _ => jpeg_ls::decode(stream, size.width, size.height),
    }
}

/// The records of a block of side information: positions and values (clause 2.9.8/5).
///
/// `at` is where in the file the block starts, for errors.
pub(crate) fn records(block: &[u8], at: usize, texels: usize) -> Result<Vec<(u32, u8)>> {
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

/// A record's value takes the place of what was decoded (clause 2.9.8/8); of two records, the later counts (ruling `side-twice`).
pub(crate) fn overwrite(plane: &mut [u8], records: &[(u32, u8)]) {
    for &(position, value) in records {
        plane[position as usize] = value;
    }
}

/// Records count whatever the parameter says (clause 2.9.8/10, ruling `side-lossless`).
pub(crate) fn side_always(_: Format, _parameter: i64) -> bool {
    true
}

/// Lossless JPEG-LS has no side information to apply; its bytes are stepped over: the other reading of `side-lossless`.
pub(crate) fn side_if_lossy(format: Format, parameter: i64) -> bool {
    !(matches!(format, Format::JpeglsRgb | Format::JpeglsLrgb) && parameter == 0)
}

#[cfg(all(test, feature = "generate"))]
mod tests {
    use super::super::by_hand::{ByHand, rejects, stored};
    use crate::codec::{jpeg, jpeg_ls};
    use crate::decode::{Limits, decode_as};
    use crate::error::Class;
    use crate::ptm::Format;
    use crate::{Reading, decode};

    /// Two columns, three rows; plane 0 counts from 1 to 6 as it is stored.
    fn counted() -> ByHand {
        let mut file = ByHand::new(Format::JpeglsLrgb, 2, 3);
        file.stream(0, &[1, 2, 3, 4, 5, 6]);
        file
    }

    /// Where the stream of plane `plane` starts.
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
        // The planes behind it are where they belong.
        assert_eq!(stored(&file.bytes(), 1), [10; 6]);
    }

    #[test]
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
    fn side_information_counts_in_lossless_files_unless_read_otherwise() {
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
        file.moved(0, 5, -7);
        assert_eq!(stored(&file.bytes(), 0), [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn vectors_count_only_with_their_bit() {
        let mut file = counted();
        file.predicted(1, 1, 0, 1, &[128; 6]);
        file.moved(1, 2, 2);
        file.predicted(2, 1, 0, 2, &[128; 6]);
        file.moved(2, 2, 2);
        file.predicted(3, 1, 0, 3, &[128; 6]);
        file.moved(3, 2, -1);
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
        rejects(
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
            rejects(
                &file.bytes(),
                &format!(
                    "compressed data (§2.9.8), byte {at}: a record for texel {position}, the last texel is 5"
                ),
            );
        }
    }

    #[test]
    fn streams_that_are_no_such_plane_are_refused_where_they_show_it() {
        let stream_8x8 = jpeg::encode(&[7; 64], 8, 8, &jpeg::Options::new(100)).stream;
        let mut file = ByHand::new(Format::JpegLrgb, 16, 8);
        file.streams[4] = stream_8x8;
        // SOI, APP0 with 16 bytes, DQT with 67: the frame's size stands behind FFC0, its length and its precision.
        let frame = file.streams[4]
            .windows(2)
            .position(|pair| pair == [0xFF, 0xC0])
            .unwrap();
        let at = start(&file, 4) + frame + 5;
        rejects(
            &file.bytes(),
            &format!(
                "compressed data (§2.9.8), byte {at}: plane 4: expected 16 x 8 samples, found 8 x 8"
            ),
        );

        let mut file = counted();
        file.streams[2] = Vec::new();
        rejects(
            &file.bytes(),
            &format!(
                "compressed data (§2.9.8), byte {}: plane 2: the stream is empty",
                start(&file, 2)
            ),
        );
        file.streams[2] = vec![0; 9];
        rejects(
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
            &jpeg_ls::Options {
                near: 0,
                presets: None,
            },
        )
        .stream;
        assert_eq!(decode(&file.bytes()).unwrap_err().class(), Class::Malformed);
        let mut file = ByHand::new(Format::JpeglsLrgb, 8, 8);
        file.streams[0] = jpeg::encode(&[1; 64], 8, 8, &jpeg::Options::new(100)).stream;
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

    #[cfg(feature = "parallel")]
    #[test]
    fn threads_find_the_same_planes_and_the_same_error() {
        let alone = crate::Reading {
            reconstruct: super::reconstruct,
            ..Reading::SPEC
        };
        let by_three = crate::Reading {
            reconstruct: |coded, reading| super::reconstruct_by(3, coded, reading),
            ..Reading::SPEC
        };
        let both = |bytes: &[u8]| {
            let limits = Limits::default();
            let found = decode_as(bytes, &by_three, &limits);
            assert_eq!(found, decode_as(bytes, &alone, &limits));
            assert_eq!(found, decode(bytes));
            found
        };
        let mut file = ByHand::new(Format::JpeglsLrgb, 256, 256);
        let noise = |seed: usize| (0..1 << 16).map(move |i: usize| ((i * i + seed * i) >> 5) as u8);
        for plane in 0..9 {
            file.stream(plane, &noise(plane).collect::<Vec<_>>());
        }
        file.predicted(0, 3, 4, 1, &noise(77).collect::<Vec<_>>());
        file.predicted(7, 4, 0, 2, &noise(78).collect::<Vec<_>>());
        file.moved(7, 3, -5);
        file.record(4, 300, 1);
        assert!(both(&file.bytes()).is_ok());

        // The error is that of the plane that is decoded first, wherever it stands.
        file.order[8] = -1;
        for plane in [2, 8] {
            file.streams[plane].truncate(1000);
        }
        let error = both(&file.bytes()).unwrap_err().to_string();
        assert!(error.contains("plane 8"), "{error}");
    }
}
