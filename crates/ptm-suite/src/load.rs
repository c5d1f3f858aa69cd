//! Loads the cases in `spec-cases/cases/`.
//!
//! The files are embedded, so an installed program needs no checkout.

use std::collections::HashMap;

use super::cases::{Case, Suite};
use super::{record::CaseRecord, words::Words};
use crate::error::{Error, Result};
use crate::kit::yaml::records;

impl Suite {
    /// Loads the suite that is embedded in the program.
    ///
    /// # Errors
    /// Returns a message that names the file and the offending line or case.
    pub fn load() -> Result<Suite> {
        Suite::from_files(ptm_spec_cases::CASES)
    }

    /// Builds a suite from case files, given as pairs of file name and text.
    ///
    /// # Errors
    /// Returns a message that names the file and the offending line or case.
    pub fn from_files(files: &[(&str, &str)]) -> Result<Suite> {
        let mut cases: Vec<Case> = Vec::new();
        let mut case_indices: HashMap<String, usize> = HashMap::new();
        for (name, text) in files {
            let records = records(text).map_err(|error| error.in_place(name))?;
            for (line, record) in records {
                let record: CaseRecord = record;
                for words in Words::combinations(&record.for_each) {
                    let id = words.id(&record.id);
                    let twin = record.twin_of.as_ref().map(|twin| words.id(twin));
                    let twin = twin.and_then(|twin| case_indices.get(&twin));
                    let case = record.case(&words, twin.map(|&at| &cases[at]));
                    let case = case.map_err(|error| {
                        error.in_place(format!("{name}: line {line}: case {id}"))
                    })?;
                    if case_indices.insert(id.clone(), cases.len()).is_some() {
                        return Error::invalid(format!("{name}: line {line}: duplicate case {id}"));
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

    /// Invalid cases, each with the beginning of the expected message. `MAKE` stands for the beginning of a recipe, and `↵`
    /// stands for a line feed.
    const INVALID_CASES: &str = r#"
  expect: decoded => line 4: unknown variant `decoded`
  expcet: decode => line 4: unknown field `expcet`
  expect: decode↵  first: yes => line 5: invalid type
MAKE    sede: 1 => line 8: unknown field `sede`
MAKE    spelling: { size_lines: one } => line 1: case a: expected 2 or 1 for size_lines, found "one"
MAKE    compression: { baseline: yes } => line 1: case a: expected true or false for baseline, found "yes"
MAKE    scene: nose => line 1: case a: unknown scene
MAKE  views: [coefs] => line 1: case a:
  expect: decode↵  bytes: [{ is: format, text: "PTM_FORMAT_LRGB\n" }]↵  values: { size: 1x1, raw: [1 2 3 4 5 6 7 8 9] }↵  views: [coef] => line 1: case a: the case has no values for the view coef
  expect: reject↵  twin_of: b↵  damage: width-zero => line 1: case a: the twin b must precede the case
"#;

    #[test]
    fn meaningless_cases_are_refused_with_file_and_line() {
        const MAKE: &str = "  expect: decode↵  make:↵    format: RGB↵    size: 3x2↵";
        for row in INVALID_CASES.trim_matches('\n').lines() {
            let (text, error) = row.split_once(" => ").expect("a text and its error");
            let text = text.replace("MAKE", MAKE).replace('↵', "\n");
            let text = format!("- id: a\n  clauses: [2.1/1]\n  because: It is.\n{text}\n");
            let found = Suite::from_files(&[("x.yaml", &text)])
                .expect_err("not a case")
                .to_string();
            assert!(found.starts_with(&format!("x.yaml: {error}")), "{found}");
        }
    }
}
