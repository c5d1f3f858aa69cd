//! Tests of the lint findings for the files of the suite.

use std::collections::BTreeSet;

use ptm_files::lint::codes::{ALL, Code, Severity};
use ptm_files::lint::lint;
use ptm_suite::cases::{Case, TableSpelling};

use crate::in_process::suite;

fn lint_codes(case: &Case) -> BTreeSet<&'static str> {
    let findings = lint(&case.build(TableSpelling::default()).file);
    findings.iter().map(|finding| finding.code).collect()
}

#[test]
fn every_damage_that_must_be_refused_has_a_code() {
    let suite = suite();
    let is_refused = |case: &&Case| case.expect.is_refusal();
    let refused: Vec<&Case> = suite.cases.iter().filter(is_refused).collect();
    for case in &refused {
        let name = case.damage().map_or(&*case.id, |damage| &*damage.name);
        assert!(
            Code::for_rejected_file(name).is_some(),
            "no code for {name}"
        );
    }
    assert!(refused.len() > 300);
}

#[test]
fn every_code_is_triggered_by_its_cases() {
    let suite = suite();
    for code in ALL.iter() {
        assert!(!code.provoked_by.is_empty(), "{}", code.id);
        for name in &code.provoked_by {
            let is_named = |case: &&Case| {
                case.id == *name || case.damage().is_some_and(|damage| damage.name == *name)
            };
            let cases: Vec<&Case> = suite.cases.iter().filter(is_named).collect();
            assert!(!cases.is_empty(), "{}: no case {name}", code.id);
            for case in cases {
                let is_found = lint_codes(case).contains(code.id);
                assert!(is_found, "{} is not found in {}", code.id, case.id);
            }
        }
    }
}

#[test]
fn codes_have_one_severity_and_unique_texts() {
    let mut damages = BTreeSet::new();
    let mut ids = BTreeSet::new();
    let mut texts = BTreeSet::new();
    for code in ALL.iter() {
        assert!(ids.insert(code.id), "{}", code.id);
        assert!(texts.insert(code.message), "{}", code.message);
        let letter = match code.severity {
            Severity::Error => 'E',
            Severity::Warning => 'W',
            Severity::Info => 'I',
        };
        assert!(code.id.starts_with(&format!("PTM-{letter}")), "{}", code.id);
        if code.severity == Severity::Error {
            for name in &code.provoked_by {
                assert!(damages.insert(name), "{name}");
            }
        }
    }
}

#[test]
fn every_clause_of_a_code_exists() {
    let clauses = ptm_suite::clauses::clauses().expect("the clauses load");
    for code in ALL.iter() {
        let is_known = clauses.iter().any(|clause| clause.id == code.clause);
        assert!(is_known, "{}: {}", code.id, code.clause);
    }
}

#[test]
fn findings_depend_only_on_choices_of_their_case() {
    let (suite, mut rulings) = (suite(), BTreeSet::new());
    let is_wanted = |case: &&Case| case.compression().is_some() && case.damage().is_none();
    for case in suite.cases.iter().filter(is_wanted) {
        let codes = lint_codes(case);
        let found = ALL.iter().filter(|code| codes.contains(code.id));
        for ruling in found.filter_map(|code| code.ruling.as_deref()) {
            assert!(case.axes().contains(&ruling), "{}: {ruling}", case.id);
            rulings.insert(ruling);
        }
    }
    assert_eq!(rulings.len(), 7, "{rulings:?}");
}
