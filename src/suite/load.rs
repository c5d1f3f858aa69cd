//! Reads `spec-cases/cases/`.
//!
//! The files are embedded in the program, so that an installed one needs no checkout.

use std::collections::HashMap;

use super::cases::{Case, Suite};
use super::record::CaseRecord;
use super::words::Words;
use crate::kit::yaml::records;

/// Returns the name and the text of a file of a folder of `spec-cases/`.
macro_rules! spec_file {
    ($folder:literal, $name:literal) => {
        (
            $name,
            include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/spec-cases/",
                $folder,
                $name
            )),
        )
    };
}
pub(super) use spec_file;

/// The files of `spec-cases/cases/`, in the order of the text.
const FILES: &[(&str, &str)] = &[
    spec_file!("cases/", "first.yaml"),
    spec_file!("cases/", "header.yaml"),
    spec_file!("cases/", "scale-bias.yaml"),
    spec_file!("cases/", "lookup-table.yaml"),
    spec_file!("cases/", "color-matrix.yaml"),
    spec_file!("cases/", "texels.yaml"),
    spec_file!("cases/", "compressed.yaml"),
    spec_file!("cases/", "prediction.yaml"),
    spec_file!("cases/", "side-information.yaml"),
    spec_file!("cases/", "streams.yaml"),
    spec_file!("cases/", "evaluate.yaml"),
    spec_file!("cases/", "sweeps.yaml"),
];

impl Suite {
    /// Loads the suite that is embedded in the program.
    ///
    /// # Errors
    /// A sentence that names the file and the line or case at fault.
    pub fn load() -> Result<Suite, String> {
        Suite::from_files(FILES)
    }

    /// Makes a suite from case files: name and text of each.
    ///
    /// # Errors
    /// A sentence that names the file and the line or case at fault.
    pub fn from_files(files: &[(&str, &str)]) -> Result<Suite, String> {
        let mut cases: Vec<Case> = Vec::new();
        let mut places: HashMap<String, usize> = HashMap::new();
        for (name, text) in files {
            let records = records(text).map_err(|error| format!("{name}: {error}"))?;
            for (line, record) in records {
                let record: CaseRecord = record;
                for words in Words::combinations(&record.for_each) {
                    let id = words.id(&record.id);
                    let twin = |id: &str| places.get(id).map(|&at| &cases[at]);
                    let case = record.case(&words, twin);
                    let case =
                        case.map_err(|error| format!("{name}: line {line}: case {id}: {error}"))?;
                    if places.insert(id.clone(), cases.len()).is_some() {
                        return Err(format!("{name}: line {line}: case {id} is there twice"));
                    }
                    cases.push(case);
                }
            }
        }
        Ok(Suite { cases })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn rejects(text: &str, error: &str) {
        let text = format!("- id: a\n  clauses: [2.1/1]\n  because: It is.\n{text}");
        let said = Suite::from_files(&[("x.yaml", &text)]).expect_err("it is no case");
        assert!(said.starts_with(&format!("x.yaml: {error}")), "{said}");
    }

    #[test]
    fn what_means_nothing_is_refused_with_file_and_line() {
        rejects("  expect: decoded\n", "line 4: unknown variant `decoded`");
        rejects("  expcet: decode\n", "line 4: unknown field `expcet`");
        rejects("  expect: decode\n  first: yes\n", "line 5: invalid type");
        let make = |fields: &str| {
            format!("  expect: decode\n  make:\n    format: RGB\n    size: 3x2\n    {fields}\n")
        };
        rejects(&make("sede: 1"), "line 8: unknown field `sede`");
        rejects(
            &make("spelling: { size_lines: one }"),
            "line 1: case a: expected 2 or 1 for size_lines, found \"one\"",
        );
        rejects(
            &make("compression: { baseline: yes }"),
            "line 1: case a: expected true or false for baseline, found \"yes\"",
        );
        rejects(&make("scene: nose"), "line 1: case a: unknown scene");
        rejects(
            "  expect: decode\n  make: { format: RGB, size: 3x2 }\n  views: [coefs]\n",
            "line 1: case a: ",
        );
        rejects(
            "  expect: decode\n  bytes: [{ is: format, text: \"PTM_FORMAT_LRGB\\n\" }]\n  values: { size: 1x1, raw: [1 2 3 4 5 6 7 8 9] }\n  views: [coef]\n",
            "line 1: case a: its values lack the view coef",
        );
        rejects(
            "  expect: reject\n  twin_of: b\n  damage: width-zero\n",
            "line 1: case a: its twin b does not stand before it",
        );
    }
}
