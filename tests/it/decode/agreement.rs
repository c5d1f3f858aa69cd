//! Compares the Python decoder with the reference on randomly generated files. The two decoders were written independently.

use crate::common::{Workspace, have_python, python_example};

const MIN_FILES: usize = 10_000;

/// Number of calls. Some files are requested several times, so there are fewer files.
const CALLS: usize = 13_000;

#[test]
#[ignore = "generates 10,000 files; takes minutes"]
fn the_python_decoder_agrees_with_the_reference_on_10_000_generated_files() {
    if !have_python(&["PIL", "pillow_jpls"]) {
        return;
    }
    let decoder = python_example("decoders/ptm_decoder.py");
    let options = format!("--seed 2001 --view raw --executions {CALLS} --out finds");
    let output = Workspace::new().succeeds(&format!("fuzz {options} -- {decoder}"));
    println!("{output}");
    let files: usize = output
        .split_whitespace()
        .next()
        .and_then(|word| word.parse().ok())
        .expect("a number of files");
    assert!(files >= MIN_FILES, "{output}");
}
