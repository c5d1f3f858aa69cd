//! The pages in a real browser: `tests/it/report/html_browser.mjs` drives one and says what it saw.
//!
//! Needs node, chromium and chromedriver.

use std::process::Command;

use crate::common::{have, repository};

#[test]
fn the_page_works_in_a_browser() {
    if !["node", "chromium", "chromedriver"].into_iter().all(have) {
        return;
    }
    let scratch = tempfile::tempdir().expect("a scratch directory");
    let decoder = scratch.path().join("decoder");
    // Right but for the tone of everything: each byte of the frame's samples is another one; and it prints markup.
    let script = format!(
        "#!/bin/sh\n\
         echo '<script>document.title = \"owned\"</script><img src=x onerror=\"document.title = 1\">' >&2\n\
         {} reference \"$1\" \"$2\" > frame || exit $?\n\
         head -n 1 frame\n\
         tail -n +2 frame | tr '\\000-\\377' '\\001-\\377\\000'\n",
        env!("CARGO_BIN_EXE_ptm-conform")
    );
    std::fs::write(&decoder, script).expect("a file");
    let mode = <std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o755);
    std::fs::set_permissions(&decoder, mode).expect("a mode");
    let page = scratch.path().join("report.html");
    let report = scratch.path().join("report.yaml");
    let checked = crate::common::program()
        .args(["check", "--case", "*lrgb*", "--case", "hand-*", "--report"])
        .arg(&report)
        .arg("--html")
        .arg(&page)
        .arg("--")
        .arg(&decoder)
        .output()
        .expect("the program starts");
    assert_eq!(checked.status.code(), Some(1));
    let matrix = scratch.path().join("matrix.html");
    let made = crate::common::program()
        .args(["report", "html"])
        .args([
            &report,
            &report,
            std::path::Path::new(&repository("reports/reference.yaml")),
        ])
        .arg("-o")
        .arg(&matrix)
        .output()
        .expect("the program starts");
    assert_eq!(made.status.code(), Some(0));
    let output = Command::new("node")
        .arg(repository("tests/it/report/html_browser.mjs"))
        .args([&page, &matrix])
        .arg(env!("CARGO_TARGET_TMPDIR"))
        .output()
        .expect("node starts");
    let says = [output.stdout, output.stderr].concat();
    let says = String::from_utf8_lossy(&says);
    print!("{says}");
    assert!(output.status.success(), "{says}");
}
