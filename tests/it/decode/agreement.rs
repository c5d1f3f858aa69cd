//! The decoder in Python and the reference, which were written apart from each other, on files that nobody chose.

use crate::common::{Workspace, have_python, python_example};

const FILES: usize = 10_000;

/// Some files are asked for more than once.
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
    assert!(drawn >= FILES, "{said}");
}
