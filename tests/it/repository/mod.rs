//! The repository itself: module order, style, documents, and the CI files for other projects.

#![cfg(all(unix, feature = "cli"))]

mod action;
mod documents;
mod order;
mod tidy;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenTree};

/// Returns all files in a directory and its subdirectories.
pub fn files_below(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).expect("a directory");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let files = paths.flat_map(|path| match path.is_dir() {
        true => files_below(&path),
        false => vec![path],
    });
    files.collect()
}

/// Returns the contents of all files in a directory and its subdirectories, keyed by relative path.
pub fn tree(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let file = |path: PathBuf| {
        let name = path.strip_prefix(directory).expect("a path below");
        (name.to_owned(), fs::read(&path).expect("a file"))
    };
    files_below(directory).into_iter().map(file).collect()
}

/// Returns true if the next attribute restricts the item to tests: `cfg(test)`, or `cfg(all(…, test))`.
pub fn is_for_tests(tokens: &[TokenTree]) -> bool {
    let [hash, TokenTree::Group(attribute), ..] = tokens else {
        return false;
    };
    let text = attribute.stream().to_string().replace(' ', "");
    is_punct(hash, '#')
        && (text == "cfg(test)" || text.starts_with("cfg(all(") && text.contains("test"))
}

/// Returns the number of tokens in an item, up to its semicolon or its body.
pub fn item_length(tokens: &[TokenTree]) -> usize {
    let ends = |token: &TokenTree| {
        is_punct(token, ';')
            || matches!(token, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace)
    };
    let end = tokens.iter().position(ends);
    end.map_or(tokens.len(), |end| end + 1)
}

/// Returns true if `token` is the punctuation character `wanted`.
pub fn is_punct(token: &TokenTree, wanted: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == wanted)
}
