//! Tests the order of sections, and that no file contains a path of one machine.

use std::fs;
use std::path::Path;

use super::files_below;

fn source(path: &str) -> String {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    fs::read_to_string(crates.join(path)).expect("a source file")
}

/// Returns the sections and names of the modules that a file declares.
fn sections(path: &str) -> Vec<(String, String)> {
    let text = source(path);
    let lines: Vec<&str> = text.lines().collect();
    let named = lines.windows(2).filter_map(|pair| {
        let section = pair[0].strip_prefix("/// §")?;
        let name = pair[1].trim_end_matches(';').rsplit(' ').next()?;
        Some((section.to_owned(), name.to_owned()))
    });
    named.collect()
}

#[test]
fn sections_are_in_the_order_of_the_specification() {
    let sections = sections("ptm/src/decode/mod.rs").into_iter();
    let sections: Vec<String> = sections.map(|(section, _)| section).collect();
    assert!(sections.len() >= 9, "{sections:?}");
    assert!(sections.is_sorted(), "{sections:?}");
}

#[test]
fn the_writer_mirrors_the_reader() {
    let names =
        |path| -> Vec<String> { sections(path).into_iter().map(|(_, name)| name).collect() };
    assert_eq!(
        names("ptm/src/decode/mod.rs"),
        names("ptm-generate/src/lib.rs")
    );
}

#[test]
fn files_contain_no_machine_paths() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for directory in [
        "src",
        "crates",
        "tests",
        "spec-cases",
        "examples",
        ".github",
        ".ci",
    ] {
        for path in files_below(&root.join(directory)) {
            let Ok(text) = fs::read_to_string(&path) else {
                continue;
            };
            let places = [["/ho", "me/"], ["/wo", "rk/"]].map(|parts| parts.concat());
            let has_path = places.iter().any(|place| text.contains(place));
            assert!(!has_path, "{}", path.display());
        }
    }
}
