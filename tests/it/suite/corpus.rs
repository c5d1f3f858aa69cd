//! The committed corpus is what the recipes give, byte for byte, and its ids are permanent.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use ptm_conform::generate::{Model, Recipe, write};
use ptm_conform::kit::digest::sha256;
use ptm_conform::ptm::Format;
use ptm_conform::suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_conform::suite::corpus::{self, ManifestEntry};
use ptm_conform::suite::damages::damages;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn suite() -> Suite {
    Suite::load().expect("the suite loads")
}

/// All files below a directory, with their bytes.
fn tree(directory: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(tree(&path).into_iter().map(|(name, bytes)| {
                (
                    Path::new(path.file_name().expect("a name")).join(name),
                    bytes,
                )
            }));
        } else {
            files.insert(
                PathBuf::from(path.file_name().expect("a name")),
                fs::read(&path).expect("a file"),
            );
        }
    }
    files
}

#[test]
fn one_thread_and_many_write_what_is_committed() {
    let committed = tree(&root().join("corpus"));
    for jobs in [1, 7] {
        let scratch = tempfile::tempdir().expect("a scratch directory");
        corpus::write(
            &suite(),
            scratch.path(),
            corpus::COMMITTED,
            jobs,
            &|_, _| (),
        )
        .expect("the corpus is written");
        let written = tree(scratch.path());
        let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(
            names(&written),
            names(&committed),
            "run: ptm-conform generate"
        );
        for (name, bytes) in &written {
            assert!(
                committed[name] == *bytes,
                "{} differs; run: ptm-conform generate",
                name.display()
            );
        }
    }
    let size: usize = committed.values().map(Vec::len).sum();
    println!("{} files, {size} bytes", committed.len());
    assert!(size <= 3_250_000, "{size} bytes");
}

#[test]
fn the_manifest_lists_every_case() {
    let text = fs::read_to_string(root().join("corpus/MANIFEST.yaml")).expect("the manifest");
    let entries: Vec<ManifestEntry> =
        ptm_conform::kit::yaml::from_yaml(&text).expect("the manifest is YAML");
    let suite = suite();
    let ids: Vec<&String> = entries.iter().map(|entry| &entry.id).collect();
    assert_eq!(
        ids,
        suite.cases.iter().map(|case| &case.id).collect::<Vec<_>>()
    );
    for (entry, case) in entries.iter().zip(&suite.cases) {
        assert_eq!(
            entry.sha256,
            sha256(&case.build(TableSpelling::default()).file),
            "{}",
            entry.id
        );
    }
}

#[test]
fn no_id_vanishes_and_no_file_changes_unseen() {
    // The ledger says what each id stood for when it was first published.
    let text = fs::read_to_string(root().join("spec-cases/ledger.yaml")).expect("the ledger");
    let ledger: BTreeMap<String, (String, String)> =
        ptm_conform::kit::yaml::from_yaml(&text).expect("the ledger is YAML");
    let suite = suite();
    for (id, (digest, since)) in &ledger {
        let case = suite
            .case(id)
            .unwrap_or_else(|| panic!("{id}, published in {since}, is gone"));
        assert_eq!(
            &sha256(&case.build(TableSpelling::default()).file),
            digest,
            "{id} means another file than in {since}"
        );
    }
    let unlisted = suite
        .cases
        .iter()
        .filter(|case| !ledger.contains_key(&case.id));
    let line = |case: &Case| {
        let digest = sha256(&case.build(TableSpelling::default()).file);
        format!(
            "{}: [{digest}, \"{}\"]\n",
            case.id,
            env!("CARGO_PKG_VERSION")
        )
    };
    let missing: String = unlisted.map(line).collect();
    assert!(
        missing.is_empty(),
        "add to spec-cases/ledger.yaml:\n{missing}"
    );
}

#[test]
fn the_decoder_finds_what_was_painted() {
    for case in &suite().cases {
        let built = case.build(TableSpelling::default());
        let decoded = ptm_conform::decode(&built.file);
        match case.expect {
            Expect::Reject | Expect::Refuse => assert!(decoded.is_err(), "{}", case.id),
            Expect::Decode => assert!(decoded.is_ok(), "{}: {decoded:?}", case.id),
            // What the reference does with these is its own; another picture than the painted one it never shows.
            Expect::Lenient | Expect::Spelling | Expect::ImplementationDefined => {}
        }
    }
}

#[test]
fn the_readme_says_what_the_generator_does() {
    let readme = fs::read_to_string(root().join("spec-cases/README.md")).expect("a README");
    let size = "2x2".parse().expect("a size");
    let recipe = Recipe::ordinary(Format::Lrgb, size);
    let file = write(&recipe, &Model::paint(&recipe)).bytes;
    let numbers = |texts: Vec<&str>| format!("`{}`", texts.join(" "));
    let words = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    for said in [
        format!("those over {} KiB are left out", corpus::COMMITTED / 1024),
        format!("| `scale` | {} |", numbers(recipe.scale.texts())),
        format!("| `bias` | {} |", numbers(recipe.bias.texts())),
        format!("| `matrix` | {} |", numbers(recipe.matrix.texts())),
        format!("| `entries` | `{}` |", recipe.entries),
        format!(
            "has {} bytes and the sha-256 `{}`",
            file.len(),
            sha256(&file)
        ),
    ] {
        assert!(words.contains(&said), "{said}");
    }
}

#[test]
fn every_damage_is_done_by_a_case() {
    let suite = suite();
    let done: Vec<&str> = suite
        .cases
        .iter()
        .filter_map(|case| Some(case.damage()?.name.as_str()))
        .collect();
    for damage in damages().expect("the damages") {
        assert!(done.contains(&damage.name.as_str()), "{}", damage.name);
    }
}
