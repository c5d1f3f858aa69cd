//! The YAML files of the repository conform to their published schemas.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::table::rows;

/// The files of each schema. A directory stands for its files.
const SCHEMAS: &str = "
cases | spec-cases/cases
damages | spec-cases/damages.yaml
clauses | spec-cases/clauses.yaml spec-cases/texture/clauses.yaml
rulings | spec-cases/rulings.yaml spec-cases/texture/rulings.yaml
misreadings | spec-cases/misreadings.yaml spec-cases/texture/misreadings.yaml
readers | spec-cases/readers.yaml
annotated | spec-cases/annotated
texture-cases | spec-cases/texture/cases
writer-requests | spec-cases/writers/requests.yaml
writer-mistakes | spec-cases/writers/mistakes.yaml
manifest | corpus/MANIFEST.yaml
report | reports/reference.yaml reports/texture.yaml
";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn each_file_conforms_to_its_schema() {
    for [schema, places] in rows(SCHEMAS) {
        let schema = root().join(format!("spec-cases/schema/{schema}.schema.json"));
        let schema: Value = serde_json::from_str(&read(&schema)).expect("a schema is JSON");
        let validator = jsonschema::validator_for(&schema).expect("a schema is a schema");
        for file in places.split(' ').flat_map(files) {
            let value: Value = ptm_conform::kit::yaml::from_yaml(&read(&file))
                .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            let errors = validator.iter_errors(&value).take(5);
            let errors: Vec<String> = errors
                .map(|error| format!("{}: {error}", error.instance_path()))
                .collect();
            assert!(errors.is_empty(), "{}: {errors:#?}", file.display());
        }
    }
}

/// Returns the files of a place in the repository; the list of example files has no schema.
fn files(place: &str) -> Vec<PathBuf> {
    let place = root().join(place);
    if place.is_file() {
        return vec![place];
    }
    let entries = fs::read_dir(&place).expect("a directory");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| !path.ends_with("annotated/files.yaml"))
        .collect()
}
