//! The committed corpus is what the recipes give, byte for byte, and its ids are permanent.
#![cfg(feature = "harness")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use ptm_conform::harness::cases::{Case, Expect, Suite, TableSpelling};
use ptm_conform::harness::corpus::{self, Entry};

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
    assert!(size <= 3_000_000, "{size} bytes");
}

#[test]
fn the_manifest_lists_every_case() {
    let text = fs::read_to_string(root().join("corpus/MANIFEST.yaml")).expect("the manifest");
    let entries: Vec<Entry> = serde_saphyr::from_str(&text).expect("the manifest is YAML");
    let suite = suite();
    let ids: Vec<&String> = entries.iter().map(|entry| &entry.id).collect();
    assert_eq!(
        ids,
        suite.cases.iter().map(|case| &case.id).collect::<Vec<_>>()
    );
    for (entry, case) in entries.iter().zip(&suite.cases) {
        assert_eq!(
            entry.sha256,
            corpus::sha256(&case.build(TableSpelling::default()).file),
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
        serde_saphyr::from_str(&text).expect("the ledger is YAML");
    let suite = suite();
    for (id, (digest, since)) in &ledger {
        let case = suite
            .case(id)
            .unwrap_or_else(|| panic!("{id}, published in {since}, is gone"));
        assert_eq!(
            &corpus::sha256(&case.build(TableSpelling::default()).file),
            digest,
            "{id} means another file than in {since}"
        );
    }
    let unlisted = suite
        .cases
        .iter()
        .filter(|case| !ledger.contains_key(&case.id));
    let line = |case: &Case| {
        let digest = corpus::sha256(&case.build(TableSpelling::default()).file);
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
            Expect::Lenient | Expect::Spelling => {}
        }
    }
}
