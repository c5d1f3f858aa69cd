//! Tests that the judge accepts correct files and describes the faults of wrong ones.

use ptm_suite::cases::{Expect, Suite};
use ptm_writers::cases::load_writer_requests;
use ptm_writers::request::{RequestHeader, WriteRequest};
use ptm_writers::{cases::WriterCase, judge::judge, reference::write_requested_file};

use crate::common::assert_conforms;

fn suite() -> Suite<WriterCase> {
    load_writer_requests().expect("the requests load")
}

/// Returns a request and the file that the reference writes for it.
fn request(id: &str) -> (WriteRequest, Vec<u8>) {
    let request = suite().case(id).expect("a request").request();
    let file = write_requested_file(&request).expect("the reference writes it");
    (request, file)
}

#[track_caller]
fn assert_fault(request: &WriteRequest, file: &[u8], says: &str) {
    let fault = judge(request, file).expect_err("the file is wrong");
    assert!(fault.message.contains(says), "{fault}");
}

/// Replaces the only occurrence of `from` in a file.
#[track_caller]
fn replace_bytes(file: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = file.windows(from.len()).position(|window| window == from);
    let at = at.expect("an occurrence");
    [&file[..at], to, &file[at + from.len()..]].concat()
}

#[test]
fn reference_writes_every_request() {
    let suite = suite();
    assert!(suite.cases.len() >= 120, "{} requests", suite.cases.len());
    for case in &suite.cases {
        let request = case.request();
        match write_requested_file(&request) {
            Ok(file) => {
                assert_eq!(case.expect, Expect::Decode, "{}", case.id);
                let judged = judge(&request, &file);
                assert_eq!(judged, Ok(()), "{}", case.id);
            }
            Err(why) => assert_eq!(case.expect, Expect::Refuse, "{}: {why:?}", case.id),
        }
    }
}

#[test]
fn requests_conform_to_their_schema_and_round_trip() {
    for case in &suite().cases {
        let request = case.request();
        let json = request.header.to_json();
        assert_conforms(
            &serde_json::from_str(&json).expect("JSON"),
            "writer-request",
        );
        let header = RequestHeader::read(json.as_bytes()).expect("a request");
        assert_eq!(header.with_planes(&request.to_npy()).as_ref(), Ok(&request));
    }
}

#[test]
fn header_faults_name_expected_and_found_values() {
    let (request, file) = request("lrgb-bias-negative");
    let clamped = replace_bytes(&file, b"-1 -20 -128 -214 -5 -100", b"0 0 0 0 0 0");
    assert_fault(&request, &clamped, "bias 0: expected -1, found 0");
    let other = replace_bytes(&file, b"PTM_1.2", b"PTM_1.1");
    assert_fault(
        &request,
        &other,
        "the reference refuses the file: header string (§2.1), byte 0",
    );
}

#[test]
fn truncated_scales_are_detected() {
    let (request, file) = request("lrgb-scale-six-decimals-are-too-few");
    let short = replace_bytes(&file, b"0.00001525878", b"0.000015");
    assert_fault(&request, &short, "scale 1: expected 0.00001525878");
}

#[test]
fn wrong_samples_are_named_with_their_bytes() {
    let (request, mut file) = request("rgb-5x3");
    let last = file.len() - 1;
    file[last] ^= 1;
    assert_fault(&request, &file, &format!("is read from byte {last}"));
}

#[test]
fn lossy_planes_stay_within_their_quality() {
    let (request, _) = request("jpeg-lrgb-quality-90");
    let mut worse = request.clone();
    worse.header.quality = Some(20);
    let file = write_requested_file(&worse).expect("the reference writes it");
    assert_fault(
        &request,
        &file,
        "expected the compression parameter 90, found 20",
    );
    // The parameter is correct, but the streams were encoded with a different one.
    let disguised = replace_bytes(&file, b"\n20\n0 0", b"\n90\n0 0");
    assert_fault(&request, &disguised, "but quality 90 allows only");
}

#[test]
fn wrapping_texels_need_side_information() {
    let (request, file) = request("jpegls-lrgb-wraps-5");
    assert_eq!(judge(&request, &file), Ok(()));
    // Change one of the extreme values, so that its record contains the wrong value.
    let mut other = request.clone();
    let top = other.samples.iter().position(|&value| value == 255);
    other.samples[top.expect("an extreme")] = 127;
    assert!(judge(&other, &file).is_err());
}
