//! The repository itself: the order of its sections, documents, and the CI files for other projects.

#![cfg(unix)]

mod action;
mod documents;
mod pipeline;
mod tidy;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns all files in a directory and its subdirectories.
pub fn files_below(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).expect("a directory");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .flat_map(|path| {
            if path.is_dir() {
                files_below(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

/// Returns the contents of all files in a directory and its subdirectories, keyed by relative path.
pub fn tree(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let file = |path: PathBuf| {
        let name = path.strip_prefix(directory).expect("a path below");
        (name.to_owned(), fs::read(&path).expect("a file"))
    };
    files_below(directory).into_iter().map(file).collect()
}
