//! Pages of every kind in a real browser: `tests/it/site/browser.mjs` opens them and reports its observations.
//!
//! Needs node, chromium and chromedriver.

use std::process::Command;

use super::SITE;
use crate::common::{Workspace, have, outcome, repository};

#[test]
fn pages_of_every_kind_open_without_an_error_or_a_request() {
    if !["node", "chromium", "chromedriver"].into_iter().all(have) {
        return;
    }
    let here = Workspace::new();
    for file in SITE.iter() {
        here.write(&file.path, &file.bytes);
    }
    let output = Command::new("node")
        .arg(repository("tests/it/site/browser.mjs"))
        .arg(here.path(""))
        .arg(env!("CARGO_TARGET_TMPDIR"))
        .output()
        .expect("node starts");
    let (status, text) = outcome(&output);
    print!("{text}");
    assert_eq!(status, 0, "{text}");
}
