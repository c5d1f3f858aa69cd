//! The order of the text and the independence of the two sides are facts and not a hope.

use std::fs;
use std::path::{Path, PathBuf};

fn source(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(path))
        .expect("a source file")
}

/// The sections and names of the modules that a `mod.rs` lists.
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

fn files_below(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory)
        .expect("a directory")
        .map(|entry| entry.expect("an entry").path());
    entries
        .flat_map(|path| {
            if path.is_dir() {
                files_below(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

#[test]
fn sections_are_listed_in_the_order_of_the_text() {
    let sections: Vec<String> = sections("decode/mod.rs")
        .into_iter()
        .map(|(section, _)| section)
        .collect();
    assert!(sections.len() >= 9, "{sections:?}");
    assert!(sections.is_sorted(), "{sections:?}");
}

#[test]
fn the_writer_mirrors_the_reader() {
    let names =
        |path| -> Vec<String> { sections(path).into_iter().map(|(_, name)| name).collect() };
    assert_eq!(names("decode/mod.rs"), names("generate/mod.rs"));
}

#[test]
fn the_writer_never_asks_the_reader() {
    for path in files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/generate")) {
        let text = fs::read_to_string(&path).expect("a source file");
        let code = text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"));
        for line in code {
            assert!(!line.contains("decode::"), "{}: {line}", path.display());
        }
    }
}

#[test]
fn modules_depend_in_one_direction() {
    // Each module may use only those before it; reading and decode are two halves of one: the decisions and their functions.
    let layers = [
        (
            "ptm.rs",
            &["error", "decode", "evaluate", "generate", "harness"][..],
        ),
        ("error.rs", &["evaluate", "generate", "harness"][..]),
    ];
    for (file, forbidden) in layers {
        for module in forbidden {
            assert!(
                !source(file).contains(&format!("use crate::{module}")),
                "{file} uses {module}"
            );
        }
    }
    let core = files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/decode"));
    for path in core
        .iter()
        .chain([&Path::new(env!("CARGO_MANIFEST_DIR")).join("src/evaluate.rs")])
    {
        let text = fs::read_to_string(path).expect("a source file");
        assert!(
            !text.contains("crate::harness") && !text.contains("crate::generate"),
            "{}",
            path.display()
        );
    }
}

#[test]
fn no_file_speaks_of_a_machine() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for directory in ["src", "tests", "spec-cases", "examples", ".github", ".ci"] {
        for path in files_below(&root.join(directory)) {
            let Ok(text) = fs::read_to_string(&path) else {
                continue;
            };
            let home = ["/ho", "me/"].concat();
            let work = ["/wo", "rk/"].concat();
            assert!(
                !text.contains(&home) && !text.contains(&work),
                "{}",
                path.display()
            );
        }
    }
}
