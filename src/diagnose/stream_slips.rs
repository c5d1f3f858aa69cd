//! Decoders of streams with one slip each.

use std::sync::PoisonError;

use super::jpeg_ls_slips;
use super::jpeg_slips;
use super::slips::Slip;
use super::stream_cache::stream_once;
use super::witness::Witness;
use crate::error::Result;
use crate::evaluate::final_coefficient;
use crate::generate::planes::StoredPlane;
use crate::parts::PlaneStream;
use crate::protocol::frame::{Frame, Samples};
use crate::ptm::Format;
use crate::suite::compare::is_close;

/// Fewer wrong samples may agree by chance.
const FEWEST: usize = 4;

/// A slip in the decoder of streams: of which codec, and its place in the list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum StreamSlip {
    Jpeg(usize),
    JpegLs(usize),
}

impl StreamSlip {
    /// All that are tried.
    pub fn all() -> impl Iterator<Item = StreamSlip> {
        let jpeg = (0..jpeg_slips::SLIPS.len()).map(StreamSlip::Jpeg);
        let jpeg_ls = jpeg_ls_slips::SLIPS.len() + jpeg_ls_slips::WRONG_ENTRIES.len();
        jpeg.chain((0..jpeg_ls).map(StreamSlip::JpegLs))
    }

    fn slip(self) -> &'static Slip {
        match self {
            StreamSlip::Jpeg(place) => &jpeg_slips::SLIPS[place],
            StreamSlip::JpegLs(place) => {
                let mut all = jpeg_ls_slips::SLIPS
                    .iter()
                    .chain(jpeg_ls_slips::WRONG_ENTRIES);
                all.nth(place).expect("a place in both lists")
            }
        }
    }

    /// How streams are read with it.
    pub fn stream(self) -> fn(&PlaneStream) -> Result<Vec<u8>> {
        self.slip().stream
    }

    /// Which streams it is about.
    pub fn is_of(self, format: Format) -> bool {
        match self {
            StreamSlip::Jpeg(_) => format.is_jpeg(),
            StreamSlip::JpegLs(_) => format.is_jpeg_ls(),
        }
    }

    /// Whether a decoder with it may find no picture: those of JPEG read all codes as they should.
    pub const fn may_refuse(self) -> bool {
        matches!(self, StreamSlip::JpegLs(_))
    }

    /// By how much samples may differ that inverse transforms make.
    fn slack(self) -> f64 {
        match self {
            StreamSlip::Jpeg(_) => 1.0,
            StreamSlip::JpegLs(_) => 0.0,
        }
    }

    /// What it does.
    pub fn effect(self) -> &'static str {
        self.slip().says
    }

    /// As a sentence without its subject.
    pub fn says(self) -> String {
        let codec = match self {
            StreamSlip::Jpeg(_) => "JPEG",
            StreamSlip::JpegLs(_) => "JPEG-LS",
        };
        format!("{}, in its decoder of {codec}", self.slip().says)
    }

    /// What to do about it.
    pub const fn fix(self) -> &'static str {
        match self {
            StreamSlip::Jpeg(_) => "do there as T.81 says",
            StreamSlip::JpegLs(_) => "do there as T.87 says",
        }
    }

    /// Whether streams of this file come out wrong with it, by more than inverse transforms may differ.
    pub fn acts_on(self, witness: &Witness) -> bool {
        if !self.is_of(witness.case.format()) {
            return false;
        }
        let known = || witness.slips.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&acts) = known().get(self.effect()) {
            return acts;
        }
        let acts = self.changes_streams(witness);
        known().insert(self.effect(), acts);
        acts
    }

    fn changes_streams(self, witness: &Witness) -> bool {
        streams_of(witness).iter().any(|stream| {
            let (right, made) = (stream_once(stream), (self.slip().stream)(stream));
            let (Ok(right), Ok(made)) = (right, made) else {
                return false;
            };
            let mut pairs = right.iter().zip(made);
            pairs.any(|(right, made)| f64::from(right.abs_diff(made)) > self.slack())
        })
    }

    /// Whether the stored or final values that were received are what a decoder with this slip finds, as far as it does not
    /// lose its way. Only planes are asked that nothing but their stream makes; some wrong samples must be among them.
    pub fn is_shown(self, witness: &Witness, shown: &Frame) -> bool {
        let streams = streams_of(witness);
        let Ok(ptm) = witness.decoded() else {
            return false;
        };
        let (size, channels) = (ptm.planes.size, shown.channels as usize);
        let (w, h) = (size.width as usize, size.height as usize);
        if witness.observation.view.name() == "rgb" || streams.len() != channels {
            return false;
        }
        let mut wrong = 0;
        let roots = (0..channels).filter(|&plane| witness.is_of_stream(plane));
        let is_as_shown = roots.into_iter().all(|plane| {
            let Ok(partial) = (self.slip().partial)(&streams[plane]) else {
                return false;
            };
            let final_value = |sample: u8| match channels {
                8 | 9 if plane > 5 => f64::from(sample),
                _ => final_coefficient(sample, plane, &ptm.header.scale_bias),
            };
            (0..w * h).all(|stored| {
                // The stream has the bottom row first.
                let i = ((h - 1 - stored / w) * w + stored % w) * channels + plane;
                let (sample, right) = (partial.samples[stored], ptm.planes.samples[i]);
                let off = f64::from(sample.abs_diff(right));
                wrong += usize::from(stored < partial.known && off > self.slack());
                stored >= partial.known
                    || match &shown.samples {
                        Samples::U8(shown) => {
                            (f64::from(shown[i]) - f64::from(sample)).abs() <= self.slack()
                        }
                        Samples::F32(shown) => {
                            let step = (final_value(1) - final_value(0)).abs() * self.slack();
                            is_close(final_value(sample), f64::from(shown[i]), step)
                        }
                    }
            })
        });
        is_as_shown && wrong >= FEWEST
    }
}

/// The streams of a file's planes, where they are known.
fn streams_of<'w>(witness: &'w Witness) -> Vec<PlaneStream<'w>> {
    let Some(model) = witness.model() else {
        return Vec::new();
    };
    let planes = model.compressed.iter().flat_map(|coded| &coded.planes);
    let stream = |(plane, stored): (usize, &'w StoredPlane)| PlaneStream {
        format: model.format,
        plane,
        at: 0,
        bytes: &stored.stream,
        size: model.size,
    };
    planes.enumerate().map(stream).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::super::tests::first_cause;
    use super::*;
    use crate::decode::planes;
    use crate::diagnose::slips::tests::each_stream;
    use crate::reading::Reading;

    #[test]
    fn every_slip_shows_in_some_stream_of_the_suite() {
        let mut hidden: HashSet<&str> = StreamSlip::all().map(|slip| slip.slip().says).collect();
        each_stream(Format::is_compressed, |stream| {
            let right = planes::stream(stream).expect("a legal stream");
            hidden.retain(|says| {
                let mut slips = StreamSlip::all().map(StreamSlip::slip);
                let slip = slips.find(|slip| slip.says == *says).expect("a slip");
                (slip.stream)(stream).expect("a legal stream") == right
            });
        });
        assert_eq!(hidden, HashSet::new());
    }

    #[test]
    fn a_slip_in_a_codec_is_told_by_what_it_makes_of_streams() {
        for says in [
            "takes 0 for d (Rd) in the last column, where b belongs",
            "starts with A = 4, whatever RANGE is",
            "leaves the coefficients of the block before, where it reads none",
        ] {
            let mut slips = StreamSlip::all();
            let slip = slips.find(|slip| slip.slip().says == says).expect("a slip");
            let reading = Reading {
                stream: slip.stream(),
                ..Reading::SPEC
            };
            let told = first_cause(reading, |case| {
                matches!(case.format(), Format::JpeglsLrgb | Format::JpegLrgb)
            });
            assert!(told.contains(says), "{says}: {told}");
        }
    }
}
