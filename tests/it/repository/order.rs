//! The modules of `src` depend on each other in one direction, and files have no import cycles.
//!
//! All paths in `use` items and in code count as imports, including those in macros but not those in tests.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::{files_below, is_for_tests, is_punct, item_length};
use crate::table::rows;

/// Top-level modules, each after all modules that it may import.
const MODULES: &str = "error codec ptm parts input reading evaluate decode generate texture kit formula protocol suite \
    misreadings readers runner session diagnose strength report fuzz tools writers site cli main";

/// Maps the path of each module in the crate to its file; a path is a list of names such as `["decode", "planes"]`.
type Modules = BTreeMap<Vec<String>, String>;

#[test]
fn modules_depend_in_one_direction() {
    let place = |file: &str| {
        let module = file.split(['/', '.']).next().expect("a first part");
        let place = MODULES.split(' ').position(|name| name == module);
        place.unwrap_or_else(|| panic!("the order does not contain the module of {file}"))
    };
    let violations: Vec<String> = imports()
        .iter()
        .filter(|(file, _)| *file != "lib.rs")
        .flat_map(|(file, to)| to.iter().map(move |to| (file, to)))
        .filter(|(file, to)| *to == "lib.rs" || place(file) < place(to))
        .map(|(file, to)| format!("{file} imports {to}"))
        .collect();
    assert!(violations.is_empty(), "{}", violations.join("\n"));
}

#[test]
fn files_have_no_import_cycles() {
    let imports = imports();
    // Files that import no remaining file are removed repeatedly. The rest is in cycles or imports files in cycles.
    let mut left: BTreeSet<&String> = imports.keys().collect();
    while let Some(&free) = left
        .iter()
        .find(|&&file| imports[file].iter().all(|to| !left.contains(to)))
    {
        left.remove(free);
    }
    // Files that no remaining file imports are not in cycles.
    while let Some(&above) = left
        .iter()
        .find(|&&file| left.iter().all(|&other| !imports[other].contains(file)))
    {
        left.remove(above);
    }
    let cycle = |file: &&String| {
        let to = imports[*file].iter().filter(|to| left.contains(to));
        let to: Vec<&str> = to.map(String::as_str).collect();
        format!("{file} imports {}", to.join(", "))
    };
    let cycles: Vec<String> = left.iter().map(cycle).collect();
    assert!(cycles.is_empty(), "import cycles:\n{}", cycles.join("\n"));
}

/// Every way to write an import is recognized.
#[test]
fn all_import_forms_are_recognized() {
    let module = |file: &str| {
        (
            file.split('/').map(str::to_owned).collect(),
            file.to_owned(),
        )
    };
    let modules: Modules = ["a", "a/b", "a/c", "d"].map(module).into();
    let seen = |code: &str| {
        let tokens: TokenStream = code.parse().expect("Rust");
        let file = File {
            modules: &modules,
            own: vec!["a".to_owned(), "b".to_owned()],
        };
        file.imports(tokens).into_iter().collect::<Vec<_>>()
    };
    for [code, files] in rows(
        r#"
use crate::d::X; | d
use super::c; | a/c
use crate::{a::{c::{X, Y}}, d}; | a/c d
fn f() -> u8 { println!("{}", crate::d::x()); 1 } | d
mod inner { use super::super::c::X; } | a/c
#[cfg(test)] mod tests { use crate::d::X; } use super::c; | a/c
#[cfg(all(unix, test))] use crate::d::X; mod c; |"#,
    ) {
        assert_eq!(seen(&code).join(" "), files, "{code}");
    }
}

/// Returns each file in `src` with the files that it imports from.
fn imports() -> BTreeMap<String, BTreeSet<String>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let modules: Modules = files_below(&source)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .map(|path| {
            let file = path
                .strip_prefix(&source)
                .expect("below src")
                .to_string_lossy()
                .into_owned();
            let parts = file.trim_end_matches(".rs").split('/');
            let own = parts.filter(|&part| part != "mod" && part != "lib");
            (own.map(str::to_owned).collect(), file)
        })
        .collect();
    let imports = modules.iter().map(|(own, file)| {
        let text = fs::read_to_string(source.join(file)).expect("a source file");
        let tokens = text
            .parse()
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        let mut to = File {
            modules: &modules,
            own: own.clone(),
        }
        .imports(tokens);
        to.remove(file);
        (file.clone(), to)
    });
    imports.collect()
}

/// A file, or a module inside a file.
struct File<'a> {
    modules: &'a Modules,
    own: Vec<String>,
}

impl File<'_> {
    fn imports(&self, tokens: TokenStream) -> BTreeSet<String> {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut found = BTreeSet::new();
        let mut at = 0;
        while at < tokens.len() {
            if is_for_tests(&tokens[at..]) {
                at += 2;
                at += item_length(&tokens[at..]);
            } else if is_visibility(&tokens[at..]) {
                // A visibility is not an import.
                at += 2;
            } else if let (Some(name), Some(TokenTree::Group(body))) =
                (module_name(&tokens[at..]), tokens.get(at + 2))
            {
                let own = [self.own.clone(), vec![name]].concat();
                let modules = self.modules;
                found.append(&mut File { modules, own }.imports(body.stream()));
                at += 3;
            } else if let Some(start) = self.start_of_path(&tokens, at) {
                self.follow(start, &tokens[at + 1..], &mut found);
                at += 1;
            } else {
                if let TokenTree::Group(group) = &tokens[at] {
                    found.append(&mut self.imports(group.stream()));
                }
                at += 1;
            }
        }
        found
    }

    /// Returns the first module of the path that starts at this token, if any.
    fn start_of_path(&self, tokens: &[TokenTree], at: usize) -> Option<Vec<String>> {
        if at > 0 && is_punct(&tokens[at - 1], ':') || !path_continues(&tokens[at + 1..]) {
            return None;
        }
        let TokenTree::Ident(word) = &tokens[at] else {
            return None;
        };
        let child = [self.own.clone(), vec![word.to_string()]].concat();
        match word.to_string().as_str() {
            "crate" | "ptm_conform" => Some(Vec::new()),
            "self" => Some(self.own.clone()),
            "super" => Some(self.own[..self.own.len() - 1].to_vec()),
            _ => self.modules.contains_key(&child).then_some(child),
        }
    }

    /// Follows a path and all its branches to the files that they name.
    fn follow(&self, mut module: Vec<String>, tokens: &[TokenTree], found: &mut BTreeSet<String>) {
        if !path_continues(tokens) {
            return self.add_file(&module, found);
        }
        match tokens.get(2) {
            Some(TokenTree::Ident(word)) if word == "super" => {
                module.pop();
                self.follow(module, &tokens[3..], found);
            }
            Some(TokenTree::Ident(word)) => {
                module.push(word.to_string());
                self.follow(module, &tokens[3..], found);
            }
            Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                for branch in inner
                    .split(|token| is_punct(token, ','))
                    .filter(|branch| !branch.is_empty())
                {
                    let mut module = module.clone();
                    if let TokenTree::Ident(word) = &branch[0]
                        && word != "self"
                    {
                        module.push(word.to_string());
                    }
                    self.follow(module, &branch[1..], found);
                }
            }
            _ => self.add_file(&module, found),
        }
    }

    /// Adds the file of the innermost module on a path to `found`.
    fn add_file(&self, path: &[String], found: &mut BTreeSet<String>) {
        let file = (0..=path.len())
            .rev()
            .find_map(|length| self.modules.get(&path[..length]));
        found.extend(file.cloned());
    }
}

/// Returns true if the next tokens are `::`.
fn path_continues(tokens: &[TokenTree]) -> bool {
    matches!(tokens, [a, b, ..] if is_punct(a, ':') && is_punct(b, ':'))
}

/// Returns the name of the module that is declared at this position.
fn module_name(tokens: &[TokenTree]) -> Option<String> {
    match tokens {
        [TokenTree::Ident(word), TokenTree::Ident(name), ..] if word == "mod" => {
            Some(name.to_string())
        }
        _ => None,
    }
}

/// Returns true if the next tokens are `pub(in …)`, `pub(super)` or `pub(crate)`.
fn is_visibility(tokens: &[TokenTree]) -> bool {
    matches!(
        tokens,
        [TokenTree::Ident(word), TokenTree::Group(group), ..]
            if word == "pub" && group.delimiter() == Delimiter::Parenthesis
    )
}
