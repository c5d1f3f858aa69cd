//! Pages of every kind in a real browser: `tests/it/site/browser.mjs` opens them and says what it saw.
//!
//! Needs node, chromium and chromedriver.

use std::process::Command;

use super::SITE;
use crate::common::{have, repository};

#[test]
fn pages_of_every_kind_open_without_an_error_or_a_request() {
    if !["node", "chromium", "chromedriver"].into_iter().all(have) {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    for file in SITE.iter() {
        let path = scratch.path().join(&file.path);
        std::fs::create_dir_all(path.parent().expect("a directory")).expect("a directory");
        std::fs::write(path, &file.bytes).expect("a file");
    }
    let output = Command::new("node")
        .arg(repository("tests/it/site/browser.mjs"))
        .arg(scratch.path())
        .arg(env!("CARGO_TARGET_TMPDIR"))
        .output()
        .expect("node starts");
    let says = [output.stdout, output.stderr].concat();
    let says = String::from_utf8_lossy(&says);
    print!("{says}");
    assert!(output.status.success(), "{says}");
}
