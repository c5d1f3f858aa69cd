//! What lint says of the suite's own files.

use std::collections::BTreeSet;

use ptm_conform::suite::cases::{Case, Expect, Suite, TableSpelling};
use ptm_conform::tools::lint::codes::{ALL, Code, Severity};
use ptm_conform::tools::lint::lint;

fn suite() -> Suite {
    Suite::load().unwrap_or_else(|why| panic!("{why}"))
}

fn codes_of(case: &Case) -> BTreeSet<&'static str> {
    lint(&case.build(TableSpelling::default()).file)
        .iter()
        .map(|diagnostic| diagnostic.code)
        .collect()
}

fn errors_of(case: &Case) -> BTreeSet<&'static str> {
    codes_of(case)
        .into_iter()
        .filter(|id| id.starts_with("PTM-E"))
        .collect()
}

#[test]
fn files_that_must_be_accepted_have_no_errors() {
    let mut asked = 0;
    for case in suite()
        .cases
        .iter()
        .filter(|case| case.expect == Expect::Decode)
    {
        assert_eq!(errors_of(case), BTreeSet::new(), "{}", case.id);
        asked += 1;
    }
    println!("{asked} files that must be accepted");
    assert!(asked > 500);
}

#[test]
fn files_that_must_be_refused_have_the_code_of_their_damage() {
    let mut wrong = Vec::new();
    let mut asked = 0;
    for case in suite()
        .cases
        .iter()
        .filter(|case| matches!(case.expect, Expect::Reject | Expect::Refuse))
    {
        let name = case
            .damage()
            .map_or(case.id.as_str(), |damage| damage.name.as_str());
        asked += 1;
        let found = errors_of(case);
        match Code::of_refused(name) {
            None => wrong.push(format!(
                "{}: no code stands for {name}; found {found:?}",
                case.id
            )),
            Some(code) if !found.contains(code.id) => wrong.push(format!(
                "{}: expected {}, found {found:?}",
                case.id, code.id
            )),
            Some(_) => {}
        }
    }
    println!("{asked} files that must be refused");
    assert!(asked > 300);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_code_is_provoked_by_all_that_it_names() {
    let suite = suite();
    let mut wrong = Vec::new();
    for code in ALL.iter() {
        if code.provoked_by.is_empty() {
            wrong.push(format!("{} is provoked by nothing", code.id));
        }
        for name in &code.provoked_by {
            let concerned: Vec<&Case> = suite
                .cases
                .iter()
                .filter(|case| {
                    case.id == *name || case.damage().is_some_and(|damage| damage.name == *name)
                })
                .collect();
            if concerned.is_empty() {
                wrong.push(format!(
                    "{}: no case is called {name} or made by it",
                    code.id
                ));
            }
            let missing = concerned
                .iter()
                .filter(|case| !codes_of(case).contains(code.id));
            wrong.extend(missing.map(|case| format!("{} is not found in {}", code.id, case.id)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_damage_stands_at_one_error_an_id_says_its_severity_and_each_has_its_own_text() {
    let mut damages = BTreeSet::new();
    let mut ids = BTreeSet::new();
    let mut texts = BTreeSet::new();
    for code in ALL.iter() {
        assert!(ids.insert(code.id), "{}", code.id);
        assert!(texts.insert(code.says), "{}", code.says);
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
fn every_clause_of_a_code_is_a_clause() {
    let clauses = ptm_conform::suite::clauses::clauses().unwrap_or_else(|why| panic!("{why}"));
    for code in ALL.iter() {
        assert!(
            clauses.iter().any(|clause| clause.id == code.clause),
            "{}: {}",
            code.id,
            code.clause
        );
    }
}

#[test]
fn files_depend_on_no_choice_that_their_case_does_not_show() {
    let mut shown = BTreeSet::new();
    for case in suite()
        .cases
        .iter()
        .filter(|case| case.compression().is_some() && case.damage().is_none())
    {
        let codes = codes_of(case);
        let found = ALL.iter().filter(|code| codes.contains(code.id));
        for ruling in found.filter_map(|code| code.ruling.as_deref()) {
            assert!(case.axes().contains(&ruling), "{}: {ruling}", case.id);
            shown.insert(ruling);
        }
    }
    assert_eq!(shown.len(), 7, "{shown:?}");
}
