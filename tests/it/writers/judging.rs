//! What is right, and what is wrong, in process.

use ptm_conform::suite::cases::{Expect, Suite};
use ptm_conform::writers::cases::WriterCase;
use ptm_conform::writers::judge::judge;
use ptm_conform::writers::reference::written;
use ptm_conform::writers::request::{RequestHeader, WriteRequest};

fn suite() -> Suite<WriterCase> {
    Suite::of_requests().expect("the requests load")
}

fn request(id: &str) -> WriteRequest {
    suite().case(id).expect("a request of this name").request()
}

#[track_caller]
fn judged(request: &WriteRequest, file: &[u8], says: &str) {
    let fault = judge(request, file).expect_err("the file is wrong");
    assert!(fault.says.contains(says), "{fault}");
}

/// Replaces the one place of `from` in a file.
#[track_caller]
fn replaced(file: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    let at = file.windows(from.len()).position(|window| window == from);
    let at = at.expect("it is in the file");
    [&file[..at], to, &file[at + from.len()..]].concat()
}

#[test]
fn there_are_requests_enough_and_the_reference_carries_them_out() {
    let suite = suite();
    assert!(suite.cases.len() >= 120, "{} requests", suite.cases.len());
    for case in &suite.cases {
        let request = case.request();
        match written(&request) {
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
fn a_request_is_what_its_schema_says_and_is_read_back() {
    let schema = include_str!("../../../spec-cases/schema/writer-request.schema.json");
    let schema: serde_json::Value = serde_json::from_str(schema).expect("JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema");
    for case in &suite().cases {
        let request = case.request();
        let json = request.header.to_json();
        let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        assert!(validator.is_valid(&value), "{}: {json}", case.id);
        let header = RequestHeader::read(json.as_bytes()).expect("a request");
        assert_eq!(header.with_planes(&request.array()).as_ref(), Ok(&request));
    }
}

#[test]
fn a_wrong_header_is_told_by_its_numbers() {
    let request = request("lrgb-bias-negative");
    let file = written(&request).expect("the reference writes it");
    let clamped = replaced(&file, b"-1 -20 -128 -214 -5 -100", b"0 0 0 0 0 0");
    judged(&request, &clamped, "bias 0: expected -1, the file has 0");
    let other = replaced(&file, b"PTM_1.2", b"PTM_1.1");
    judged(
        &request,
        &other,
        "the reference refuses the file: header string (§2.1), byte 0",
    );
}

#[test]
fn a_scale_with_too_few_decimals_is_wrong() {
    let request = request("lrgb-scale-six-decimals-are-too-few");
    let file = written(&request).expect("the reference writes it");
    let short = replaced(&file, b"0.00001525878", b"0.000015");
    judged(&request, &short, "scale 1: expected 0.00001525878");
}

#[test]
fn a_wrong_value_is_told_by_its_byte() {
    let request = request("rgb-5x3");
    let mut file = written(&request).expect("the reference writes it");
    let last = file.len() - 1;
    file[last] ^= 1;
    judged(&request, &file, &format!("is read from byte {last}"));
}

#[test]
fn a_lossy_plane_may_lose_what_its_quality_allows_and_no_more() {
    let request = request("jpeg-lrgb-quality-90");
    let mut worse = request.clone();
    worse.header.quality = Some(20);
    let file = written(&worse).expect("the reference writes it");
    judged(
        &request,
        &file,
        "expected the compression parameter 90, the file has 20",
    );
    // The right number over the wrong streams.
    let disguised = replaced(&file, b"\n20\n0 0", b"\n90\n0 0");
    judged(&request, &disguised, "and quality 90 allows");
}

#[test]
fn a_texel_that_wraps_needs_side_information() {
    let request = request("jpegls-lrgb-wraps-5");
    let file = written(&request).expect("the reference writes it");
    assert_eq!(judge(&request, &file), Ok(()));
    // The same values, painted one less at the upper end: what a record corrected is now wrong.
    let mut other = request.clone();
    let top = other.samples.iter().position(|&value| value == 255);
    other.samples[top.expect("an extreme")] = 127;
    assert!(judge(&other, &file).is_err());
}
