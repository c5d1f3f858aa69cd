//! The YAML files of the repository are what their published schemas say.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

#[track_caller]
fn conforms(file: &Path, schema: &str) {
    let schema =
        fs::read_to_string(root().join("spec-cases/schema").join(schema)).expect("a schema");
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    let validator = jsonschema::validator_for(&schema).expect("a schema is a schema");
    let text =
        fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let value: Value = ptm_conform::kit::yaml::from_yaml(&text)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let errors: Vec<String> = validator
        .iter_errors(&value)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .take(5)
        .collect();
    assert!(errors.is_empty(), "{}: {errors:#?}", file.display());
}

#[test]
fn cases_damages_clauses_rulings_and_misreadings_conform() {
    for entry in fs::read_dir(root().join("spec-cases/cases")).expect("the cases") {
        conforms(&entry.expect("an entry").path(), "cases.schema.json");
    }
    conforms(
        &root().join("spec-cases/damages.yaml"),
        "damages.schema.json",
    );
    conforms(
        &root().join("spec-cases/clauses.yaml"),
        "clauses.schema.json",
    );
    conforms(
        &root().join("spec-cases/rulings.yaml"),
        "rulings.schema.json",
    );
    conforms(
        &root().join("spec-cases/misreadings.yaml"),
        "misreadings.schema.json",
    );
    conforms(
        &root().join("spec-cases/readers.yaml"),
        "readers.schema.json",
    );
}

#[test]
fn chapters_of_the_annotated_format_conform() {
    for entry in fs::read_dir(root().join("spec-cases/annotated")).expect("the chapters") {
        let path = entry.expect("an entry").path();
        if !path.ends_with("files.yaml") {
            conforms(&path, "annotated.schema.json");
        }
    }
}

#[test]
fn texture_cases_requirements_rulings_and_misreadings_conform() {
    let texture = root().join("spec-cases/texture");
    for entry in fs::read_dir(texture.join("cases")).expect("the cases") {
        conforms(
            &entry.expect("an entry").path(),
            "texture-cases.schema.json",
        );
    }
    conforms(&texture.join("clauses.yaml"), "clauses.schema.json");
    conforms(&texture.join("rulings.yaml"), "rulings.schema.json");
    conforms(&texture.join("misreadings.yaml"), "misreadings.schema.json");
}

#[test]
fn requests_to_writers_conform() {
    let writers = root().join("spec-cases/writers");
    conforms(
        &writers.join("requests.yaml"),
        "writer-requests.schema.json",
    );
    conforms(
        &writers.join("mistakes.yaml"),
        "writer-mistakes.schema.json",
    );
}

#[test]
fn the_manifest_and_the_published_report_conform() {
    conforms(&root().join("corpus/MANIFEST.yaml"), "manifest.schema.json");
    conforms(&root().join("reports/reference.yaml"), "report.schema.json");
    conforms(&root().join("reports/texture.yaml"), "report.schema.json");
}
