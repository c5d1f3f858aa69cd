//! The compressed responses of seven public readers to this suite.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use ptm_conform::kit::digest::sha256;
use ptm_conform::protocol::frame::Frame;
use ptm_conform::report::shards::RecordedAnswer;
use ptm_conform::runner::run::AttemptKind;

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/recordings")
}

/// Returns the first 16 hexadecimal digits of the digest of a file. Recordings identify files by these digits.
pub fn digest(file: &[u8]) -> String {
    sha256(file)[..16].to_owned()
}

/// Returns the responses of a reader by file and view, including those to files that are no longer in the suite.
pub fn recorded_answers(reader: &str) -> HashMap<(String, String), RecordedAnswer<Frame>> {
    let path = folder().join(format!("{reader}.answers.gz"));
    let mut text = String::new();
    let file = File::open(path).expect("the recording exists");
    GzDecoder::new(file)
        .read_to_string(&mut text)
        .expect("the recording is text");
    let answers = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    answers
        .filter(|answer: &RecordedAnswer<Frame>| answer.attempt == AttemptKind::Usual)
        .map(|answer| ((answer.file.clone(), answer.view.clone()), answer))
        .collect()
}
