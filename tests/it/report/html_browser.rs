//! Tests of report pages in a real browser, controlled by `tests/it/report/html_browser.mjs`.
//!
//! The tests need node, chromium and chromedriver.

use std::process::Command;

use crate::common::{PROGRAM, Workspace, have_tool, repository, stdout};

#[test]
fn report_page_works_in_a_browser() {
    if !"node chromium chromedriver".split(' ').all(have_tool) {
        return;
    }
    let here = Workspace::new();
    // The decoder changes every byte of the samples and prints markup.
    let script = format!(
        "#!/bin/sh\n\
         echo '<script>document.title = \"owned\"</script><img src=x onerror=\"document.title = 1\">' >&2\n\
         {PROGRAM} reference \"$1\" \"$2\" > frame || exit $?\n\
         head -n 1 frame\n\
         tail -n +2 frame | tr '\\000-\\377' '\\001-\\377\\000'\n"
    );
    here.write_program("decoder", script);
    let cases = "--case first-* --case hand-* --case motion-*";
    here.check(&format!("{cases} --html report.html -- ./decoder"))
        .assert_exit(1, "");
    here.succeeds("check --report published.yaml");
    here.succeeds("report html report.yaml report.yaml published.yaml -o matrix.html");
    stdout(
        Command::new("node")
            .arg(repository("tests/it/report/html_browser.mjs"))
            .args([here.path("report.html"), here.path("matrix.html")])
            .arg(env!("CARGO_TARGET_TMPDIR")),
    );
}
