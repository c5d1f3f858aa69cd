//! Tests of pages of every kind in a real browser, controlled by `tests/it/site/browser.mjs`.
//!
//! The tests need node, chromium and chromedriver.

use std::process::Command;

use super::SITE;
use crate::common::{Workspace, have_tool, repository, stdout};

#[test]
fn pages_open_without_errors_or_network_requests() {
    if !"node chromium chromedriver".split(' ').all(have_tool) {
        return;
    }
    let here = Workspace::new();
    for file in SITE.iter() {
        here.write(&file.path, &file.bytes);
    }
    stdout(
        Command::new("node")
            .arg(repository("tests/it/site/browser.mjs"))
            .arg(here.path(""))
            .arg(env!("CARGO_TARGET_TMPDIR")),
    );
}
