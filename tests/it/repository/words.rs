//! Searches comments and documents for words and openings that the style guide does not allow, and lists all messages.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use proc_macro2::TokenTree;

use super::files_below;
use super::tidy::{sources, visit_tokens};

/// Openings that comments must not have: a comment starts with a noun phrase or a verb.
const OPENINGS: &str = "What|How|Where|Which|Who|Whose|Whether|Those of|The same|…";

/// Words and phrases that the style guide does not allow.
const WORDS: &str = "all the same|as ever|at the least|behaviour|behind|beside|besides|by the clock|catalogue|centre|colour|\
                     comes to|is told|licence|looked at here|neighbour|of its own|of their own|that is none|told apart|\
                     which is none";

/// Names that do not say what a function returns or does: prepositions, adverbs and participles.
const BARE_NAMES: &str = "above|absent|affected|after|against|alike|alone|among|before|beside|besides|between|by|covered|\
                          damaged|denied|each|edited|either|else|everywhere|found|given|grouped|inside|kept|known|likewise|\
                          lit|made|named|nearly|of|only|other|others|out|over|plus|rightly|said|seen|shown|slack|such|told|\
                          under|whole|with|without|wrong";

/// Words that are allowed in a file, each with the reason.
const ALLOWED: &[(&str, &str, &str)] = &[(
    "src/codec/jpeg_ls/run_mode.rs",
    "…",
    "an ellipsis in a row of an example",
)];

/// Returns the text of a comment line, or of a document line without code.
fn prose(is_rust: bool, line: &str) -> Option<&str> {
    let line = line.trim_start();
    match is_rust {
        true => Some(
            line.strip_prefix("//")?
                .trim_start_matches(['/', '!'])
                .trim(),
        ),
        false => Some(line).filter(|line| !line.contains('`')),
    }
}

/// Returns true if a line contains a word, except as a part of another word or of a hyphenated name.
fn has_word(line: &str, word: &str) -> bool {
    let (line, word) = (line.to_lowercase(), word.to_lowercase());
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || "-_`".contains(c));
    line.match_indices(&word).any(|(at, _)| {
        let after = &line[at + word.len()..];
        !is_part(line[..at].chars().next_back()) && !is_part(after.chars().next())
    })
}

#[test]
fn comments_and_documents_use_plain_words() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = "src tests/it benches examples fuzz/fuzz_targets docs".split(' ');
    let files = folders.flat_map(|folder| files_below(&root.join(folder)));
    let documents = "README.md CONTRIBUTING.md CHANGELOG.md SECURITY.md".split(' ');
    let mut found = Vec::new();
    for path in files.chain(documents.map(|name| root.join(name))) {
        let name = path.strip_prefix(root).expect("a path below");
        let name = name.to_string_lossy().into_owned();
        let has_suffix = |suffix| path.extension().is_some_and(|own| own == suffix);
        let is_rust = has_suffix("rs");
        if !is_rust && !has_suffix("md") || path.ends_with("words.rs") {
            continue;
        }
        let text = fs::read_to_string(&path).expect("UTF-8");
        for line in text.lines().filter_map(|line| prose(is_rust, line)) {
            let starts =
                |opening: &&str| is_rust && line.starts_with(opening) && has_word(line, opening);
            let words = WORDS.split('|').filter(|word| has_word(line, word));
            let all = OPENINGS.split('|').filter(starts).chain(words);
            let is_allowed =
                |word: &&str| ALLOWED.iter().any(|row| (row.0, row.1) == (&*name, *word));
            let wrong = all.filter(|word| !is_allowed(word));
            found.extend(wrong.map(|word| format!("{name}: {word:?} in {line:?}")));
        }
    }
    assert!(ALLOWED.len() <= 40);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn functions_are_named_for_what_they_return_or_do() {
    let mut found = Vec::new();
    for (file, text) in sources() {
        visit_tokens(text.parse().expect("Rust"), &mut |tokens| {
            if let [TokenTree::Ident(word), TokenTree::Ident(name), ..] = tokens
                && word == "fn"
            {
                let name = name.to_string();
                if name.starts_with("of_") || BARE_NAMES.split('|').any(|bare| bare == name) {
                    found.push(format!("{file}: {name}"));
                }
            }
        });
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// Returns true if a string literal has at least three lowercase words, as a message does.
fn is_message(literal: &str) -> bool {
    let is_word = |word: &&str| word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase());
    literal
        .split([' ', ',', '.', ':', ';'])
        .filter(is_word)
        .count()
        >= 3
}

/// `messages.txt` lists all message templates for review. `UPDATE_MESSAGES=1 cargo test messages` updates it.
#[test]
fn messages_are_listed_in_one_file() {
    let mut sources: Vec<_> = sources().collect();
    sources.sort();
    let mut list = String::new();
    for (file, text) in sources {
        let mut messages = Vec::new();
        visit_tokens(text.parse().expect("Rust"), &mut |tokens| {
            if let TokenTree::Literal(literal) = &tokens[0] {
                let lines = literal.to_string().replace("\\\n", "\n");
                let words: Vec<&str> = lines.split_whitespace().collect();
                let message = words.join(" ");
                if message.contains('"') && is_message(&message) {
                    messages.push(message);
                }
            }
        });
        if !messages.is_empty() {
            writeln!(list, "# {file}\n{}\n", messages.join("\n")).expect("memory");
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/repository/messages.txt");
    if std::env::var_os("UPDATE_MESSAGES").is_some() {
        fs::write(&path, &list).expect("the list is written");
    }
    let listed = fs::read_to_string(&path).expect("messages.txt");
    assert!(listed == list, "run: UPDATE_MESSAGES=1 cargo test messages");
}
