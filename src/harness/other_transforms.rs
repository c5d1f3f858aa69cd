//! Decoders with another inverse DCT pass (ruling `jpeg-samples`).
//!
//! The samples of JPEG planes come from two independent decoders in turn; all else is the reference. Streams that such a
//! decoder does not read are left to the reference, and counted.

use std::sync::atomic::{AtomicUsize, Ordering};

use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::codec;
use crate::decode::planes;
use crate::harness::cases::{Expect, Suite, TableSpelling};
use crate::harness::check::{Plan, check};
use crate::harness::files::check_file;
use crate::harness::judge::Outcome;
use crate::harness::misreadings;
use crate::harness::report::Report;
use crate::harness::run::Request;
use crate::ptm::{Format, Size};
use crate::reading::Reading;

type Samples = std::result::Result<Vec<u8>, codec::Error>;

/// Planes that a decoder read, and planes that it left to the reference.
type Counts = [AtomicUsize; 2];

static BY_JPEG_DECODER: Counts = [AtomicUsize::new(0), AtomicUsize::new(0)];
static BY_ZUNE: Counts = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// The samples of `decode` where the reference has some at all, and `decode` too.
fn replaced(
    format: Format,
    plane: usize,
    stream: &[u8],
    size: Size,
    decode: fn(&[u8]) -> Option<Vec<u8>>,
    counts: &Counts,
) -> Samples {
    let own = planes::stream(format, plane, stream, size)?;
    if !matches!(format, Format::JpegRgb | Format::JpegLrgb) {
        return Ok(own);
    }
    let other = decode(stream).filter(|samples| samples.len() == own.len());
    counts[usize::from(other.is_none())].fetch_add(1, Ordering::Relaxed);
    Ok(other.unwrap_or(own))
}

fn by_jpeg_decoder(stream: &[u8]) -> Option<Vec<u8>> {
    jpeg_decoder::Decoder::new(stream).decode().ok()
}

fn by_zune(stream: &[u8]) -> Option<Vec<u8>> {
    let gray = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
    zune_jpeg::JpegDecoder::new_with_options(std::io::Cursor::new(stream), gray)
        .decode()
        .ok()
}

/// The report on the reference with such samples.
#[track_caller]
fn passes(reading: Reading, counts: &Counts) {
    let suite = Suite::load().expect("the suite loads");
    let is_jpeg = |format: Format| matches!(format, Format::JpegRgb | Format::JpegLrgb);
    let plan = Plan {
        selected: suite
            .cases
            .iter()
            .map(|case| is_jpeg(case.format()))
            .collect(),
        ..Plan::of(&suite, 2)
    };
    let ask = |request: &Request<'_>, _: usize| {
        misreadings::answer(&[], reading, request.file, request.view).into()
    };
    let run = check(&suite, &plan, &ask, &|_, _, _, _| ());
    let report = Report::new(&suite, &run, &[], &["decoder".to_owned()], Vec::new());
    let failed: Vec<_> = report
        .cases
        .iter()
        .filter(|case| case.outcome == Outcome::Fail.name())
        .map(|case| (&case.id, &case.says))
        .collect();
    let [read, left] = [0, 1].map(|i: usize| counts[i].load(Ordering::Relaxed));
    println!("{read} planes read, {left} left; {:?}", report.remarks);
    assert!(failed.is_empty(), "{} failed: {failed:#?}", failed.len());
    assert!(left * 20 < read, "{left} of {read} planes were left");
    assert!(
        report
            .remarks
            .iter()
            .any(|remark| remark.says.contains("another inverse DCT"))
    );
    // The same files as a user's own, of which only the bytes are known.
    let own = suite.cases.iter().filter(|case| {
        is_jpeg(case.format()) && case.expect == Expect::Decode && case.damage().is_none()
    });
    for case in own {
        let file = &case.build(TableSpelling::default()).file;
        let result = check_file(&case.id, file, &case.views, &|request| ask(request, 0));
        assert_eq!(
            result.outcome,
            Outcome::Pass.name(),
            "{}: {:?} {:?}",
            case.id,
            result.says,
            result.relations
        );
    }
}

#[test]
fn a_decoder_with_the_samples_of_jpeg_decoder_passes() {
    let reading = Reading {
        stream: |format, plane, bytes, size| {
            replaced(
                format,
                plane,
                bytes,
                size,
                by_jpeg_decoder,
                &BY_JPEG_DECODER,
            )
        },
        ..Reading::SPEC
    };
    passes(reading, &BY_JPEG_DECODER);
}

#[test]
fn a_decoder_with_the_samples_of_zune_jpeg_passes() {
    let reading = Reading {
        stream: |format, plane, bytes, size| {
            replaced(format, plane, bytes, size, by_zune, &BY_ZUNE)
        },
        ..Reading::SPEC
    };
    passes(reading, &BY_ZUNE);
}
