//! Decoders of streams with one slip each, or with several.

use std::sync::LazyLock;

use super::jpeg_ls_slips;
use super::jpeg_slips;
use super::slips::Slip;
use crate::error::Result;
use crate::parts::PlaneStream;
use crate::ptm::Format;

/// A slip in the decoder of streams: of which codec, and its place in the list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum StreamSlip {
    Jpeg(usize),
    JpegLs(usize),
}

/// All lists of slips in decoders of JPEG-LS.
static JPEG_LS: LazyLock<Vec<&Slip<jpeg_ls_slips::Rules>>> =
    LazyLock::new(|| jpeg_ls_slips::LISTS.iter().copied().flatten().collect());

impl StreamSlip {
    /// All that are tried.
    pub fn all() -> impl Iterator<Item = StreamSlip> {
        let jpeg = (0..jpeg_slips::SLIPS.len()).map(StreamSlip::Jpeg);
        jpeg.chain((0..JPEG_LS.len()).map(StreamSlip::JpegLs))
    }

    /// What it makes of the decoder of JPEG; nothing where it is of the other codec.
    pub fn change_jpeg(self, rules: &mut jpeg_slips::Rules) {
        if let StreamSlip::Jpeg(place) = self {
            (jpeg_slips::SLIPS[place].change)(rules);
        }
    }

    /// The same of JPEG-LS.
    pub fn change_jpeg_ls(self, rules: &mut jpeg_ls_slips::Rules) {
        if let StreamSlip::JpegLs(place) = self {
            (JPEG_LS[place].change)(rules);
        }
    }

    /// How streams are read with it.
    pub fn stream(self) -> fn(&PlaneStream) -> Result<Vec<u8>> {
        match self {
            StreamSlip::Jpeg(place) => jpeg_slips::SLIPS[place].stream,
            StreamSlip::JpegLs(place) => JPEG_LS[place].stream,
        }
    }

    /// Which streams it is about.
    pub fn is_of(self, format: Format) -> bool {
        match self {
            StreamSlip::Jpeg(_) => format.is_jpeg(),
            StreamSlip::JpegLs(_) => format.is_jpeg_ls(),
        }
    }

    /// Whether a decoder with it may find no picture.
    pub fn may_refuse(self) -> bool {
        let mut rules = jpeg_slips::RIGHT;
        self.change_jpeg(&mut rules);
        matches!(self, StreamSlip::JpegLs(_)) || rules.may_refuse()
    }

    /// What it does.
    pub fn effect(self) -> &'static str {
        match self {
            StreamSlip::Jpeg(place) => jpeg_slips::SLIPS[place].says,
            StreamSlip::JpegLs(place) => JPEG_LS[place].says,
        }
    }

    /// What it is about, with the clause of the standard.
    pub fn about(self) -> &'static str {
        match self {
            StreamSlip::Jpeg(place) => jpeg_slips::SLIPS[place].about,
            StreamSlip::JpegLs(place) => JPEG_LS[place].about,
        }
    }

    /// As a sentence without its subject.
    pub fn says(self) -> String {
        let codec = match self {
            StreamSlip::Jpeg(_) => "JPEG",
            StreamSlip::JpegLs(_) => "JPEG-LS",
        };
        format!("{}, in its decoder of {codec}", self.effect())
    }

    /// What to do about it.
    pub fn fix(self) -> &'static str {
        match self {
            StreamSlip::Jpeg(place) => jpeg_slips::SLIPS[place].fix,
            StreamSlip::JpegLs(place) => JPEG_LS[place].fix,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::decode::planes;
    use crate::diagnose::codecs::slips::tests::each_stream;
    use crate::diagnose::tests::first_cause;
    use crate::reading::Reading;

    #[test]
    fn every_slip_shows_in_some_stream_of_the_suite() {
        let mut hidden: HashSet<&str> = StreamSlip::all().map(StreamSlip::effect).collect();
        // What is kept from one stream to the next shows in no stream by itself.
        hidden.retain(|says| !says.contains("of the stream before"));
        each_stream(Format::is_compressed, |stream| {
            let right = planes::stream(stream).expect("a legal stream");
            hidden.retain(|says| {
                let mut slips = StreamSlip::all();
                let slip = slips.find(|slip| slip.effect() == *says).expect("a slip");
                (slip.stream())(stream).expect("a legal stream") == right
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
            let slip = slips.find(|slip| slip.effect() == says).expect("a slip");
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
