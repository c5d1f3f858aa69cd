//! The compressed responses of programs to this suite: seven public readers of PTM files, three texture stages and a renderer on an
//! NVIDIA H200 (driver 580.159.04), and a decoder with the crate jpeg-decoder 0.3.2.
//!
//! The recording of the renderer lacks four images of 200 kB each, for their size. They were correct.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use ptm_harness::report::shards::RecordedAnswer;
use ptm_suite::kit::digest::sha256;
use ptm_suite::protocol::frame::Frame;
use ptm_suite::protocol::request::AttemptKind;
use serde::de::DeserializeOwned;

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/recordings")
}

/// Returns the first 16 hexadecimal digits of the digest of a file. Recordings identify files by these digits.
pub fn digest(file: &[u8]) -> String {
    sha256(file)[..16].to_owned()
}

/// Returns the responses of a program in the order in which they were recorded, without repetitions in a new process.
pub fn recording<T: DeserializeOwned>(program: &str) -> Vec<RecordedAnswer<T>> {
    let path = folder().join(format!("{program}.answers.gz"));
    let mut text = String::new();
    let file = File::open(path).expect("the recording exists");
    GzDecoder::new(file)
        .read_to_string(&mut text)
        .expect("the recording is text");
    // The last line describes the run.
    let answers = text
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    answers
        .filter(|answer: &RecordedAnswer<T>| answer.attempt == AttemptKind::Usual)
        .collect()
}

/// Returns the responses of a reader by file and view, including those to files that are no longer in the suite.
pub fn recorded_answers(reader: &str) -> HashMap<(String, String), RecordedAnswer<Frame>> {
    let answers = recording(reader).into_iter();
    answers
        .map(|answer| ((answer.file.clone(), answer.view.clone()), answer))
        .collect()
}
