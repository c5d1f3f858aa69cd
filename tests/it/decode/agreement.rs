//! Compares the Python decoder with the reference, which was written independently, on randomly generated files.

use crate::common::{Workspace, have_python, python_example};

const MIN_FILES: usize = 10_000;

/// Number of calls, which is larger than the number of files because some files are requested several times.
const CALLS: usize = 13_000;

#[test]
#[ignore = "draws 10,000 files; takes minutes"]
fn the_python_decoder_agrees_with_the_reference_on_10_000_generated_files() {
    if !have_python(&["PIL", "pillow_jpls"]) {
        return;
    }
    let decoder = python_example("decoders/ptm_decoder.py");
    let options = format!("--seed 2001 --view raw --executions {CALLS} --out finds");
    let said = Workspace::new().succeeds(&format!("fuzz {options} -- {decoder}"));
    println!("{said}");
    let drawn: usize = said
        .split_whitespace()
        .next()
        .and_then(|word| word.parse().ok())
        .expect("a number of files");
    assert!(drawn >= MIN_FILES, "{said}");
}
