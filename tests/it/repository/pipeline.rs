//! One pipeline: one function judges a decoder on the cases of a suite. Texture questions have a pipeline of their own.
//!
//! These tests look at source code only. Requests need a `Session`, whose constructor is looked for, and verdicts need the function
//! `judge`. A function that sends requests and compares the answers in a new way, without these, is not detected.

use std::fs;
use std::path::Path;

use super::files_below;

/// Returns the source files that contain `code` outside comments and unit tests, without their directories.
fn files_with(code: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut found = Vec::new();
    for directory in ["src", "crates"] {
        for path in files_below(&root.join(directory)) {
            let text = fs::read_to_string(&path).unwrap_or_default();
            let text = text
                .split("#[cfg(test)]\nmod tests {")
                .next()
                .expect("a first part");
            let mut lines = text.lines().map(str::trim_start);
            if lines.any(|line| !line.starts_with("//") && line.contains(code)) {
                let name = path.file_name().expect("a file").to_string_lossy();
                let parent = path
                    .parent()
                    .and_then(Path::file_name)
                    .expect("a directory");
                found.push(format!("{}/{name}", parent.to_string_lossy()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn only_the_pipelines_send_requests_and_judge_answers() {
    let [files, texture] = ["pipeline/mod.rs", "pipeline/texture.rs"];
    assert_eq!(files_with(" Session::new("), [files]);
    assert_eq!(files_with("TextureSession::new("), [texture]);
    assert_eq!(files_with(".first_contact("), [files, texture]);
    assert_eq!(files_with(".verdicts("), [files, texture]);
    // The judge is called with the observations of a session.
    assert_eq!(
        files_with("= judge("),
        ["session/run.rs", "session/texture.rs"]
    );
}
