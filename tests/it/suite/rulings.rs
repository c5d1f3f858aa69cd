//! What rulings rest on, and what misreadings violate.

use ptm_files::readers::profiles;
use ptm_suite::cases::Expect;
use ptm_suite::clauses::{self, Basis, Ruling, RulingKind};

use crate::in_process::suite;

fn rulings() -> Vec<Ruling> {
    clauses::rulings().expect("the rulings load")
}

#[test]
fn every_must_rests_on_something() {
    let names: Vec<&str> = profiles()
        .iter()
        .map(|profile| profile.reader.as_str())
        .collect();
    for ruling in rulings() {
        let id = &ruling.id;
        let is_must = ruling.kind == RulingKind::Must;
        assert_eq!(ruling.rests_on.is_some(), is_must, "{id}");
        assert_eq!(
            ruling.alternatives.is_empty(),
            ruling.kind != RulingKind::Choice,
            "{id}"
        );
        let evidence = ruling.evidence.as_str();
        match ruling.rests_on {
            // A measurement has a number.
            Some(Basis::File) => assert!(evidence.contains(|c: char| c.is_ascii_digit()), "{id}"),
            Some(Basis::Readers) => {
                let named = names
                    .iter()
                    .filter(|name| evidence.contains(**name))
                    .count();
                let short = ["HP-Java", "CNR RTIViewer"]
                    .iter()
                    .filter(|name| evidence.contains(**name));
                assert!(named + short.count() >= 2, "{id}");
            }
            Some(Basis::Text | Basis::Undefined) | None => {}
        }
    }
}

/// The text gives such files no value, so a refusal and "unsupported" are both correct.
#[test]
fn files_without_a_value_may_be_refused_in_either_way() {
    let rulings = rulings();
    for case in &suite().cases {
        let ruling = rulings
            .iter()
            .find(|ruling| Some(&ruling.id) == case.ruling.as_ref());
        let Some(ruling) = ruling else { continue };
        match (ruling.kind, ruling.rests_on) {
            (_, Some(Basis::Undefined)) => assert_eq!(case.expect, Expect::Refuse, "{}", case.id),
            // Another version is refused; its own layout is lenient for one version only.
            (RulingKind::Lenient, _) if ruling.id == "version" => {}
            (RulingKind::Lenient, _) => {
                let is_lenient = matches!(case.expect, Expect::Lenient | Expect::Robust);
                assert!(is_lenient, "{}: {:?}", case.id, case.expect);
            }
            _ => {}
        }
    }
}

#[test]
fn every_misreading_states_what_it_violates() {
    let rulings = rulings();
    for behavior in ptm_mistakes::behaviors() {
        let slug = behavior.slug;
        let find = |id: &str| rulings.iter().find(|ruling| ruling.id == id);
        let Some(violated) = behavior.violates else {
            // A behavior that violates nothing is a reading.
            let ruling = behavior.reading_of.and_then(find).expect(slug);
            assert_ne!(ruling.kind, RulingKind::Must, "{slug}");
            continue;
        };
        assert!(behavior.reading_of.is_none(), "{slug}");
        let names_clause = |ruling: &Ruling| ruling.clauses.iter().any(|id| id == behavior.clause);
        assert!(
            violated == behavior.clause || find(violated).is_some_and(names_clause),
            "{slug}: {violated}"
        );
    }
}
