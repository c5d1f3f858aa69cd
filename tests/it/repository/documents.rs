//! Counts in documents are up to date, and links lead to files in the packed crate.

use std::fs;
use std::path::{Path, PathBuf};

use ptm_files::profiles::Profile;
use ptm_harness::strength::smoke;
use ptm_suite::cases::Suite;
use ptm_suite::texture::cases as texture;

use crate::common::repository_text;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Reads a document and replaces each run of whitespace with one space.
fn document(path: &str) -> String {
    let text = repository_text(path);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Formats a number with thousands separators, such as `2,114`.
fn with_commas(number: usize) -> String {
    match number {
        0..1000 => number.to_string(),
        _ => format!("{},{:03}", number / 1000, number % 1000),
    }
}

#[test]
fn counts_in_documents_equal_those_of_the_program() {
    let suite = Suite::load().expect("the suite loads");
    let (cases, misreadings) = (with_commas(suite.cases.len()), ptm_mistakes::all().count());
    let smoke = smoke::ids(&ptm::Format::ALL)
        .expect("the smoke subset")
        .len();
    let stages = Suite::load_texture()
        .expect("the texture suite")
        .cases
        .len();
    let [requirements, rulings] = [
        texture::clauses().expect("requirements").len(),
        texture::rulings().expect("rulings").len(),
    ];
    let profile = |profile: Profile| {
        let files = with_commas(profile.cases(&suite).len());
        format!("| `{}` | {files}: ", profile.name())
    };
    for (path, claim) in [
        (
            "README.md",
            format!("The suite has {cases} cases, and its catalog has {misreadings} *misreadings*"),
        ),
        ("README.md", format!("`--smoke` | {smoke} cases")),
        (
            "docs/diagnosis.md",
            format!("`check --smoke` runs {smoke} cases"),
        ),
        ("docs/files.md", profile(Profile::Minimal)),
        ("docs/files.md", profile(Profile::Standard)),
        ("docs/files.md", profile(Profile::Exhaustive)),
        (
            "docs/texture.md",
            format!("the chapter's {requirements} requirements, {rulings} rulings"),
        ),
        (
            "docs/texture.md",
            format!("{stages} cases with their arithmetic"),
        ),
        ("CHANGELOG.md", format!("implementation, {stages} cases")),
    ] {
        assert!(
            document(path).contains(&claim),
            "{path} should say: {claim}"
        );
    }
}

#[test]
fn the_failing_run_in_the_readme_adds_up() {
    let suite = Suite::load().expect("the suite loads");
    let text = document("README.md");
    let number_before = |words: &str| -> usize {
        let (before, _) = text.split_once(words).expect(words);
        let number = before.rsplit(' ').next().expect("a word");
        number.parse().unwrap_or_else(|_| panic!("{number:?}"))
    };
    let [passed, failed, inconclusive] =
        [" pass, ", " fail, ", " inconclusive: the valid twin"].map(number_before);
    assert_eq!(passed + failed + inconclusive, suite.cases.len());
    assert!(text.contains(&format!("{failed} of {failed} failures")));
    assert!(text.contains(&format!("correctness {passed}/{}", passed + failed)));
}

#[test]
fn links_lead_to_files_in_the_packed_crates() {
    let manifest = repository_text("Cargo.toml");
    let mut lines = manifest.lines();
    let include = lines.find(|line| line.starts_with("include = "));
    let patterns = include
        .expect("the packed files")
        .split('"')
        .skip(1)
        .step_by(2);
    let pattern = |pattern: &str| glob::Pattern::new(pattern.trim_start_matches('/'));
    let packed: Vec<glob::Pattern> = patterns
        .map(|text| pattern(text).expect("a pattern"))
        .collect();
    let docs = fs::read_dir(root().join("docs")).expect("docs");
    let docs = docs.map(|entry| Path::new("docs").join(entry.expect("an entry").file_name()));
    let docs = docs.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    let mut links = 0;
    for path in docs.chain(["README.md".into()]) {
        let text = fs::read_to_string(root().join(&path)).expect("a document");
        let targets = text.split("](").skip(1);
        for link in targets.filter_map(|rest| rest.split(')').next()) {
            if link.contains("://") || link.starts_with('#') {
                continue;
            }
            let mut target = path.parent().expect("a directory").to_path_buf();
            let (file, _) = link.split_once('#').unwrap_or((link, ""));
            for step in file.split('/') {
                match step {
                    ".." => _ = target.pop(),
                    step => target.push(step),
                }
            }
            links += 1;
            assert!(root().join(&target).is_file(), "{}: {link}", path.display());
            let is_packed = packed.iter().any(|pattern| pattern.matches_path(&target));
            let is_in_other_crate =
                target.starts_with("crates") || target.starts_with("spec-cases");
            assert!(
                is_packed || is_in_other_crate,
                "{}: {link} is not packed",
                path.display()
            );
        }
    }
    assert!(links > 10, "{links} links");
}

#[test]
fn the_index_of_findings_has_the_head_of_each_script() {
    let index = repository_text("findings/README.md");
    let entries = fs::read_dir(root().join("findings")).expect("findings");
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    let mut findings = 0;
    for name in names.map(|name| name.expect("UTF-8")) {
        let is_script = Path::new(&name)
            .extension()
            .is_some_and(|suffix| suffix == "sh");
        if !is_script || name == "tools.sh" {
            continue;
        }
        let script = repository_text(&format!("findings/{name}"));
        for field in ["finding", "software", "expected", "observed"] {
            let field = format!("# {field}: ");
            let mut values = script.lines().filter_map(|line| line.strip_prefix(&*field));
            let value = values
                .next()
                .unwrap_or_else(|| panic!("{name}: no line {field:?}"));
            assert!(
                index.contains(value),
                "{name}: run findings/index.py ({value})"
            );
        }
        findings += 1;
    }
    assert!(findings > 0);
}
