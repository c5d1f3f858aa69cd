//! Tests that decoders with a different inverse DCT pass (ruling `jpeg-samples`). The test runs once with each of two independent
//! decoders. The samples of JPEG planes come from that decoder, and everything else comes from the reference. Streams that an
//! independent decoder cannot read are left to the reference and counted.

use std::sync::atomic::{AtomicUsize, Ordering};

use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use crate::pipeline::judge_answers;
use crate::session::files::check_file;
use crate::session::plan::RunPlan;
use ptm::Coding;
use ptm::decode::planes;
use ptm::parts::PlaneStream;
use ptm::reading::Reading;
use ptm_suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_suite::protocol::request::Request;
use ptm_suite::test_case::Allowance;
use ptm_suite::verdicts::{observation::Response, outcome::Outcome};

/// Number of planes read by the decoder of the current test, and number of planes left to the reference.
static COUNTS: [AtomicUsize; 2] = [AtomicUsize::new(0), AtomicUsize::new(0)];

/// Samples of a stream, or the decoding error.
type DecodedStream = ptm::error::Result<Vec<u8>>;

/// Returns the samples from `decode`, or those from the reference if `decode` cannot read the stream.
fn decode_with(stream: &PlaneStream, decode: fn(&[u8]) -> Option<Vec<u8>>) -> DecodedStream {
    let own = planes::decode_stream(stream)?;
    if stream.coding != Coding::Jpeg {
        return Ok(own);
    }
    let other = decode(stream.bytes).filter(|samples| samples.len() == own.len());
    COUNTS[usize::from(other.is_none())].fetch_add(1, Ordering::Relaxed);
    Ok(other.unwrap_or(own))
}

#[test]
fn samples_of_other_decoders_pass() {
    assert_passes(|stream| {
        decode_with(stream, |bytes| {
            jpeg_decoder::Decoder::new(bytes).decode().ok()
        })
    });
    assert_passes(|stream| {
        decode_with(stream, |bytes| {
            let gray = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
            let bytes = std::io::Cursor::new(bytes);
            let mut decoder = zune_jpeg::JpegDecoder::new_with_options(bytes, gray);
            decoder.decode().ok()
        })
    });
}

/// Checks that the reference passes with the samples from `stream`.
#[track_caller]
fn assert_passes(stream: fn(&PlaneStream) -> DecodedStream) {
    let mut reading = Reading::SPEC;
    reading.stream = stream;
    let suite = Suite::load().expect("the suite loads");
    let is_jpeg = |case: &Case| case.format().coding() == Some(Coding::Jpeg);
    let plan = RunPlan {
        selected: suite.cases.iter().map(is_jpeg).collect(),
        ..RunPlan::new(&suite, 2)
    };
    let ask = |request: &Request<'_>, _: usize| {
        ptm_mistakes::answer(&[], reading, request.file, request.view).into()
    };
    let run = judge_answers(&suite, &plan, &ask);
    let failed = run.judgment.with_outcome(Outcome::Fail);
    let failed = failed.map(|i| (&suite.cases[i].id, &run.judgment.cases[i]));
    let failed: Vec<_> = failed.collect();
    let [read, left] = [0, 1].map(|i: usize| COUNTS[i].swap(0, Ordering::Relaxed));
    assert!(failed.is_empty(), "{} failed: {failed:#?}", failed.len());
    assert!(left * 20 < read, "{left} of {read} planes were not decoded");
    let allowed = run.observations.iter().flatten();
    let mut allowed = allowed.filter_map(|observation| match &observation.response {
        Response::Image { allowance, .. } => Some(*allowance),
        _ => None,
    });
    assert!(allowed.any(|allowance| matches!(allowance, Allowance::AnotherTransform(_))));
    // Also check the files as user files, for which only the bytes are known.
    for case in suite.cases.iter().filter(|case| is_jpeg(case)) {
        if case.expect == Expect::Decode && case.damage().is_none() {
            let file = &case.build(TableSpelling::default()).file;
            let result = check_file(&case.id, file, &case.views, &|request| ask(request, 0));
            assert_eq!(result.outcome, Outcome::Pass, "{result:?}");
        }
    }
}
