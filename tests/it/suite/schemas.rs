//! The YAML files of the repository conform to their published schemas.

use std::fs;
use std::path::PathBuf;

use ptm_suite::kit::yaml::from_yaml;

use crate::common::{assert_conforms, repository, rows};

/// Schemas and the files that must conform to them. A directory stands for all files in it.
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
writer-mistakes | spec-cases/writers/mistakes.yaml spec-cases/writers/fitting-mistakes.yaml
manifest | corpus/MANIFEST.yaml
report | reports/reference.yaml reports/texture.yaml
";

#[test]
fn each_file_conforms_to_its_schema() {
    for [schema, places] in rows(SCHEMAS) {
        for file in places.split(' ').flat_map(files) {
            println!("{}", file.display());
            let text = fs::read_to_string(&file).expect("a file");
            assert_conforms(&from_yaml(&text).expect("YAML"), &schema);
        }
    }
}

/// Returns the files at a path in the repository, except the list of example files, which has no schema.
fn files(path: &str) -> Vec<PathBuf> {
    let path = PathBuf::from(repository(path));
    if path.is_file() {
        return vec![path];
    }
    let entries = fs::read_dir(&path).expect("a directory");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| !path.ends_with("annotated/files.yaml"))
        .collect()
}
