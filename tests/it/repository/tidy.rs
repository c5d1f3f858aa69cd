//! Tests the order of sections, the length of functions, and the share of comments.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use proc_macro2::{TokenStream, TokenTree};

use super::{files_below, is_for_tests, is_punct, item_length};

fn source(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(path))
        .expect("a source file")
}

/// Returns the sections and names of the modules in a `mod.rs`.
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
    let sections = sections("decode/mod.rs").into_iter();
    let sections: Vec<String> = sections.map(|(section, _)| section).collect();
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
fn files_contain_no_machine_paths() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for directory in ["src", "tests", "spec-cases", "examples", ".github", ".ci"] {
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

#[test]
fn functions_are_short() {
    let mut lengths: Vec<(usize, String)> = sources()
        .flat_map(|(file, text)| {
            functions(&text)
                .into_iter()
                .map(move |(name, lines)| (lines, format!("{file}: {name}")))
        })
        .collect();
    lengths.sort_unstable();
    let decile = lengths[lengths.len() * 9 / 10].0;
    assert!(decile <= 30, "the longest tenth begins at {decile} lines");
    let long = |limit: usize| -> Vec<String> {
        let long = lengths.iter().filter(|(lines, _)| *lines > limit);
        long.map(|(lines, name)| format!("{name}: {lines} lines"))
            .collect()
    };
    assert!(long(80).is_empty(), "{:#?}", long(80));
    assert!(long(60).len() <= 8, "{:#?}", long(60));
}

#[test]
fn no_two_types_share_a_name() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (file, text) in sources() {
        for name in types(text.parse().expect("Rust")) {
            places.entry(name).or_default().push(file.clone());
        }
    }
    places.retain(|_, places| places.len() > 1);
    assert!(places.is_empty(), "{places:#?}");
}

#[test]
fn decoder_and_codecs_have_comments() {
    for module in ["decode/", "codec/"] {
        let (mut comments, mut code) = (0, 0);
        for (_, text) in sources().filter(|(file, _)| file.starts_with(module)) {
            let mut parts = text.split("#[cfg(test)]\nmod tests");
            let code_part = parts.next().expect("a first part");
            let lines = code_part
                .lines()
                .map(str::trim)
                .filter(|line| !line.is_empty());
            let (comment_lines, code_lines): (Vec<&str>, Vec<&str>) =
                lines.partition(|line| line.starts_with("//"));
            comments += comment_lines.len();
            code += code_lines.len();
        }
        assert!(
            comments * 10 >= code * 4,
            "{module}: {comments} comment lines for {code} lines of code"
        );
    }
}

#[test]
fn few_lints_are_allowed() {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"));
    let manifest = manifest.expect("Cargo.toml");
    let lints = manifest.split("[lints.clippy]").nth(1).expect("lints");
    let lines = lints.lines().take_while(|line| !line.starts_with('['));
    let lines: Vec<&str> = lines.collect();
    let allowed = lines.iter().filter(|line| line.ends_with("= \"allow\""));
    assert!(allowed.count() <= 12);
    let have_reasons = lines
        .windows(2)
        .filter(|pair| pair[1].ends_with("= \"allow\""))
        .all(|pair| pair[0].starts_with('#'));
    assert!(have_reasons, "a lint is allowed without a reason");
}

/// Returns every file in `src` with its text.
pub fn sources() -> impl Iterator<Item = (String, String)> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let files = files_below(&source).into_iter();
    let files = files.filter(|path| path.extension().is_some_and(|extension| extension == "rs"));
    files.map(move |path| {
        let name = path.strip_prefix(&source).expect("below src");
        let name = name.to_string_lossy().into_owned();
        (name, fs::read_to_string(&path).expect("a source file"))
    })
}

/// Returns the functions of a file, except tests: the name, and the number of lines from the name to the closing brace.
fn functions(text: &str) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    visit_tokens(text.parse().expect("Rust"), &mut |tokens| {
        if let [TokenTree::Ident(word), TokenTree::Ident(name), rest @ ..] = tokens
            && word == "fn"
        {
            let end = &rest[item_length(rest) - 1];
            if let TokenTree::Group(body) = end {
                let lines = body.span_close().end().line - name.span().start().line + 1;
                found.push((name.to_string(), lines));
            }
        }
    });
    found
}

/// Returns the types in a file, except associated types and types in tests.
fn types(tokens: TokenStream) -> Vec<String> {
    let mut found = Vec::new();
    visit_top_level(tokens, &mut |tokens| {
        if let [TokenTree::Ident(word), TokenTree::Ident(name), ..] = tokens
            && ["struct", "enum", "union", "trait", "type"].contains(&word.to_string().as_str())
        {
            found.push(name.to_string());
        }
    });
    found
}

/// Calls `visit` with the remaining tokens at each position, including those inside groups. Skips attributes and items for tests.
pub fn visit_tokens(tokens: TokenStream, visit: &mut dyn FnMut(&[TokenTree])) {
    visit_top_level(tokens, &mut |tokens| {
        visit(tokens);
        if let TokenTree::Group(group) = &tokens[0] {
            visit_tokens(group.stream(), visit);
        }
    });
}

/// Calls `visit` with the remaining tokens at each position outside groups. Skips attributes and items for tests.
fn visit_top_level(tokens: TokenStream, visit: &mut dyn FnMut(&[TokenTree])) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut at = 0;
    while at < tokens.len() {
        if is_for_tests(&tokens[at..]) {
            at += 2;
            at += item_length(&tokens[at..]);
            continue;
        }
        // `#[…]` or `#![…]`
        if is_punct(&tokens[at], '#') {
            let rest = tokens[at..].iter();
            let marks = rest.take_while(|token| matches!(token, TokenTree::Punct(_)));
            at += marks.count() + 1;
            continue;
        }
        visit(&tokens[at..]);
        at += 1;
    }
}
