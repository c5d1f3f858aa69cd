//! The page of `lint --format html` in a real browser.
//!
//! The test needs node, chromium and chromedriver.

use std::fs;
use std::process::Command;

use crate::common::{Workspace, have_tool, repository, stdout};

#[test]
fn page_of_two_hundred_files_works_in_a_browser() {
    if !"node chromium chromedriver".split(' ').all(have_tool) {
        return;
    }
    let here = Workspace::new();
    let originals = [
        "lrgb/first-lrgb",
        "lrgb/half-payload-lrgb",
        "lum/first-lum",
        "jpeg_lrgb/first-jpeg-lrgb",
    ];
    let long = "a-long-file-name-without-a-space-as-scanners-write-them-".repeat(3);
    for file in 0..200 {
        let map = repository(&format!("corpus/{}.ptm", originals[file % 4]));
        let name = if file == 0 { &long } else { "coin-" };
        here.write(
            &format!("files/{name}{file:03}.ptm"),
            fs::read(map).expect("a file"),
        );
    }
    let page = here.command("lint -q --format html files").output();
    here.write("page.html", page.expect("the program starts").stdout);
    stdout(
        Command::new("node")
            .arg(repository("tests/it/tools/lint_page.mjs"))
            .arg(here.path("page.html"))
            .arg("200")
            .arg(format!("{}/lint-page", env!("CARGO_TARGET_TMPDIR"))),
    );
}
