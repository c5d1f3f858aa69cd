//! The properties of the fuzz targets, tested with proptest and with every input that made a target fail.

use std::path::Path;

use proptest::prelude::*;
use ptm_harness::fuzz::properties;

use crate::repository::files_below;

/// Fast targets and their names in `fuzz/fuzz_targets/`.
const TARGETS: [(&str, fn(&[u8])); 10] = [
    ("file", properties::file),
    ("recipe", properties::recipe),
    ("spelling", properties::spelling),
    ("re_encoding", properties::re_encoding),
    ("jpeg_stream", properties::jpeg_stream),
    ("jpeg_ls_stream", properties::jpeg_ls_stream),
    ("jpeg_round_trip", compare_jpeg_decoders),
    ("jpeg_ls_round_trip", properties::jpeg_ls_round_trip),
    ("frame", properties::frame),
    ("case_file", properties::case_file),
];

/// Targets that take about a second per call.
const SLOW_TARGETS: [(&str, fn(&[u8])); 1] = [("diagnosis", properties::diagnosis)];

/// Compares the samples of a JPEG stream with those of another decoder, with a tolerance for rounding.
fn compare_jpeg_decoders(bytes: &[u8]) {
    let Some((stream, width, height, samples)) = properties::jpeg_round_trip(bytes) else {
        return;
    };
    let mut other = jpeg_decoder::Decoder::new(&stream[..]);
    let theirs = other.decode().expect("a legal stream");
    let info = other.info().expect("decoded");
    let size = (u32::from(info.width), u32::from(info.height));
    assert_eq!(size, (width, height));
    assert!(properties::nearly_equal(&samples, &theirs, width));
}

#[test]
fn seeds_and_earlier_findings_pass() {
    for (target, property) in TARGETS.into_iter().chain(SLOW_TARGETS) {
        for kind in ["seeds", "finds"] {
            let directory = format!("{}/fuzz/{kind}/{target}", env!("CARGO_MANIFEST_DIR"));
            let Ok(entries) = std::fs::read_dir(&directory) else {
                assert_eq!(kind, "finds", "{directory} is missing");
                continue;
            };
            for entry in entries {
                let path = entry.expect("an entry").path();
                property(&std::fs::read(&path).expect("a file"));
            }
        }
    }
}

#[test]
fn every_corpus_file_gives_a_result_in_every_reading() {
    let corpus = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/corpus"));
    let mut files = files_below(corpus);
    files.retain(|path| path.extension().is_some_and(|suffix| suffix == "ptm"));
    for path in &files {
        properties::file(&std::fs::read(path).expect("a file"));
    }
    assert!(files.len() > 1000, "{}", files.len());
}

#[test]
fn every_target_calls_its_property() {
    for (target, _) in TARGETS.into_iter().chain(SLOW_TARGETS) {
        let path = format!(
            "{}/fuzz/fuzz_targets/{target}.rs",
            env!("CARGO_MANIFEST_DIR")
        );
        let text = std::fs::read_to_string(&path).expect("a target");
        assert!(text.contains(&format!("properties::{target}")), "{path}");
    }
}

proptest! {
    #[test]
    fn properties_hold_for_random_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..3000)) {
        for (_, property) in TARGETS {
            property(&bytes);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn diagnosis_ends_for_any_answers(bytes in proptest::collection::vec(any::<u8>(), 1..80)) {
        for (_, property) in SLOW_TARGETS {
            property(&bytes);
        }
    }
}
