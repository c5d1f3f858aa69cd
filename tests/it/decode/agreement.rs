//! The decoder in Python and the reference, which were written apart from each other, on files that nobody chose.

use crate::common::{have_python, program, repository};

const FILES: usize = 10_000;

/// Some files are asked for more than once.
const CALLS: usize = 13_000;

#[test]
#[ignore = "draws 10,000 files; takes minutes"]
fn the_python_decoder_agrees_with_the_reference_on_10_000_generated_files() {
    if !have_python(&["PIL", "pillow_jpls"]) {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let output = program()
        .args([
            "fuzz",
            "--seed",
            "2001",
            "--view",
            "raw",
            "--executions",
            &CALLS.to_string(),
            "--out",
        ])
        .arg(scratch.path().join("finds"))
        .args([
            "--",
            "python3",
            &repository("examples/decoders/ptm_decoder.py"),
        ])
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    println!("{said}");
    assert_eq!(output.status.code(), Some(0), "{said}");
    let drawn: usize = said
        .split_whitespace()
        .next()
        .and_then(|word| word.parse().ok())
        .expect("a number of files");
    assert!(drawn >= FILES, "{said}");
}
