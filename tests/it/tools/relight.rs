//! Pages on which a map can be relit.

use std::process::Command;

use crate::common::{Workspace, have_tool, repository, stdout};

/// One map of each shape.
const MAPS: [&str; 3] = ["lrgb/first-lrgb", "lum/first-lum", "rgb/first-rgb"];

#[test]
fn pages_need_nothing_else() {
    let here = Workspace::new();
    here.copy_from_corpus("lrgb/first-lrgb.ptm");
    here.succeeds("render first-lrgb.ptm -o page.html");
    let page = here.text("page.html");
    assert!(page.contains("<noscript>") && page.contains("data:image/png;base64,"));
    assert!(!page.contains("http:") && !page.contains("https:") && !page.contains("{map}"));
    // The name of a file cannot add markup.
    here.write("<b>&.ptm", here.read("first-lrgb.ptm"));
    here.succeeds("render '<b>&.ptm' -o page.html");
    let page = here.text("page.html");
    assert!(page.contains("&lt;b&gt;&amp;.ptm") && !page.contains("<b>"));
    here.assert_lines(
        "
2 | render first-lrgb.ptm --normals -o page.html | no --sheet, --normals or --zoom
2 | render first-lrgb.ptm -o page.pdf | .html",
    );
}

#[test]
fn pages_show_the_same_colors_as_the_reference() {
    if !"node chromium chromedriver".split(' ').all(have_tool) {
        return;
    }
    let here = Workspace::new();
    let mut browser = Command::new("node");
    browser.arg(repository("tests/it/tools/relight.mjs"));
    for map in MAPS {
        let name = map.rsplit('/').next().expect("a name");
        here.copy_from_corpus(&format!("{map}.ptm"));
        here.succeeds(&format!("render {name}.ptm -o {name}.html"));
        let frame = here.command(&format!("reference rgb:-0.35,0.4 {name}.ptm"));
        let frame = { frame }.output().expect("the program starts").stdout;
        here.write(&format!("{name}.frame"), frame);
        browser.args([
            here.path(&format!("{name}.html")),
            here.path(&format!("{name}.frame")),
        ]);
        browser.arg(format!("{}/relight-{name}", env!("CARGO_TARGET_TMPDIR")));
    }
    stdout(&mut browser);
}
