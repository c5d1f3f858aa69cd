//! The committed corpus equals the generated corpus byte for byte, and its ids are permanent.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use ptm::Format;
use ptm_generate::{Model, Recipe, write};
use ptm_suite::cases::{Case, Expect, TableSpelling};
use ptm_suite::corpus::{self, ManifestEntry};
use ptm_suite::damages::damage_kinds;
use ptm_suite::kit::{digest::sha256, yaml::from_yaml};
use ptm_suite::test_case::Listed;

use crate::in_process::suite;
use crate::repository::tree;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn digest(case: &Case) -> String {
    sha256(&case.build(TableSpelling::default()).file)
}

#[test]
fn committed_corpus_is_reproducible_with_any_number_of_threads() {
    let committed = tree(&root().join("corpus"));
    for jobs in [1, 7] {
        let scratch = tempfile::tempdir().expect("a scratch directory");
        let limit = corpus::MAX_COMMITTED_SIZE;
        let written = corpus::write(&suite(), scratch.path(), limit, jobs, &|_, _| ());
        written.expect("the corpus is written");
        let written = tree(scratch.path());
        assert!(
            written.keys().eq(committed.keys()),
            "run: ptm-conform generate"
        );
        for (name, bytes) in &written {
            let is_equal = committed[name] == *bytes;
            assert!(
                is_equal,
                "{} differs; run: ptm-conform generate",
                name.display()
            );
        }
    }
    let size: usize = committed.values().map(Vec::len).sum();
    assert!(size <= 3_400_000, "{size} bytes");
}

#[test]
fn the_manifest_lists_every_case() {
    let text = fs::read_to_string(root().join("corpus/MANIFEST.yaml")).expect("the manifest");
    let entries: Vec<ManifestEntry> = from_yaml(&text).expect("the manifest is YAML");
    let suite = suite();
    assert_eq!(entries.len(), suite.cases.len());
    for (entry, case) in entries.iter().zip(&suite.cases) {
        assert_eq!((&entry.id, &entry.sha256), (&case.id, &digest(case)));
    }
    let digests: String = entries.iter().map(|entry| &*entry.sha256).collect();
    let digest = sha256(digests.as_bytes());
    assert_eq!(digest, Case::digest(&suite), "spec-cases/corpus.sha256");
}

#[test]
fn published_ids_and_files_are_permanent() {
    // The ledger contains the digest of each file when its id was first published.
    let text = fs::read_to_string(root().join("spec-cases/ledger.yaml")).expect("the ledger");
    let ledger: BTreeMap<String, (String, String)> = from_yaml(&text).expect("the ledger is YAML");
    let suite = suite();
    for (id, (digest, since)) in &ledger {
        let case = suite
            .case(id)
            .unwrap_or_else(|| panic!("{id}, published in {since}, is missing"));
        assert_eq!(
            self::digest(case),
            *digest,
            "the file of {id} has changed since {since}"
        );
    }
    let cases = suite.cases.iter();
    let unlisted = cases.filter(|case| !ledger.contains_key(&case.id));
    let version = env!("CARGO_PKG_VERSION");
    let line = |case: &Case| format!("{}: [{}, \"{version}\"]\n", case.id, digest(case));
    let missing: String = unlisted.map(line).collect();
    assert!(
        missing.is_empty(),
        "add to spec-cases/ledger.yaml:\n{missing}"
    );
}

#[test]
fn the_decoder_accepts_and_refuses_as_expected() {
    for case in &suite().cases {
        let built = case.build(TableSpelling::default());
        let decoded = ptm::decode(&built.file);
        match case.expect {
            Expect::Reject | Expect::Refuse => assert!(decoded.is_err(), "{}", case.id),
            Expect::Decode => assert!(decoded.is_ok(), "{}: {decoded:?}", case.id),
            // The reference may decode or refuse such a file.
            _ => {}
        }
    }
}

#[test]
fn the_readme_describes_the_generator() {
    let readme = fs::read_to_string(root().join("spec-cases/README.md")).expect("a README");
    let size = "2x2".parse().expect("a size");
    let recipe = Recipe::default_for(Format::Lrgb, size);
    let file = write(&recipe, &Model::paint(&recipe)).bytes;
    let numbers = |texts: Vec<&str>| format!("`{}`", texts.join(" "));
    let words = readme.split_whitespace().collect::<Vec<_>>().join(" ");
    for claim in [
        format!(
            "those over {} KiB are left out",
            corpus::MAX_COMMITTED_SIZE / 1024
        ),
        format!("| `scale` | {} |", numbers(recipe.scale.texts())),
        format!("| `bias` | {} |", numbers(recipe.bias.texts())),
        format!("| `matrix` | {} |", numbers(recipe.matrix.texts())),
        format!("| `entries` | `{}` |", recipe.entries),
        format!(
            "is {} bytes long and has the SHA-256 digest `{}`",
            file.len(),
            sha256(&file)
        ),
    ] {
        assert!(words.contains(&claim), "{claim}");
    }
}

#[test]
fn every_damage_has_a_case() {
    let suite = suite();
    let names = suite.cases.iter().filter_map(Case::damage);
    let names: Vec<&String> = names.map(|damage| &damage.name).collect();
    for damage in damage_kinds().expect("the damages") {
        assert!(names.contains(&&damage.name), "{}", damage.name);
    }
}
