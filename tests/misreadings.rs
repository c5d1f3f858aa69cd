//! The suite is as strong as the mistakes it catches and tells apart.
#![cfg(feature = "harness")]

use std::collections::{HashMap, HashSet};

use ptm_conform::harness::cases::{self, Case, Status, Suite};
use ptm_conform::harness::matrix::{Row, matrix};
use ptm_conform::harness::misreadings;

/// Mistakes that show only in files larger than 4×4 texels, and why.
const LARGE_BY_NATURE: &[(&str, &str)] = &[
    ("sizes-of-four-digits", "a size needs five digits"),
    ("texels-counted-in-16-bits", "a map needs 65,536 texels"),
    ("columns-counted-in-8-bits", "a map needs 257 columns"),
    ("rows-counted-in-8-bits", "a map needs 257 rows"),
];

/// Pairs that no file tells apart, and why.
const EQUIVALENT: &[(&str, &str, &str)] = &[(
    "table-one-entry-long",
    "table-separated",
    "both find every table too short and refuse all files with one",
)];

/// Mistakes that hide from a decoder that shows colors only, and why.
const HIDDEN_IN_COLORS: &[(&str, &str)] = &[(
    "scale-with-three-decimals",
    "what it loses of an ordinary scale is less than the tolerance of a color",
)];

fn suite() -> Suite {
    Suite::load().expect("the suite loads").prepared()
}

fn jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn is_small(case: &Case) -> bool {
    case.recipe()
        .is_none_or(|recipe| recipe.size.width <= 4 && recipe.size.height <= 4)
}

#[test]
fn every_misreading_is_caught_by_two_cases_and_told_from_every_other() {
    let suite = suite();
    let rows = matrix(&suite, &[], jobs());
    println!("{} misreadings, {} cases", rows.len(), suite.cases.len());
    assert!(rows.len() >= 60);
    for row in &rows {
        is_caught(&suite, row);
    }
    let mut known: HashMap<&[u64], &str> = HashMap::new();
    for row in &rows {
        let Some(other) = known.insert(&row.answers, row.misreading.slug) else {
            continue;
        };
        let noted = EQUIVALENT
            .iter()
            .any(|&(a, b, _)| (a, b) == (other, row.misreading.slug));
        assert!(
            noted,
            "{other} and {} answer every case alike",
            row.misreading.slug
        );
    }
}

fn is_caught(suite: &Suite, row: &Row) {
    let slug = row.misreading.slug;
    assert!(
        row.killed_by.len() >= 2,
        "{slug} is caught by {} cases",
        row.killed_by.len()
    );
    let large = LARGE_BY_NATURE.iter().any(|&(known, _)| known == slug);
    let small = row.killed_by.iter().any(|&i| is_small(&suite.cases[i]));
    assert!(small != large, "{slug}: caught by a small case: {small}");
    let own = row.killed_by.iter().any(|&i| {
        suite.cases[i]
            .clauses
            .iter()
            .any(|clause| clause == row.misreading.clause)
    });
    assert!(
        own,
        "{slug} is caught by no case about {}",
        row.misreading.clause
    );
}

#[test]
fn a_decoder_that_shows_colors_only_is_caught_too() {
    for row in matrix(&suite(), &["rgb"], jobs()) {
        let hidden = HIDDEN_IN_COLORS
            .iter()
            .any(|&(slug, _)| slug == row.misreading.slug);
        assert_eq!(row.killed_by.is_empty(), hidden, "{}", row.misreading.slug);
    }
}

#[test]
fn every_clause_is_tested_or_says_why_not() {
    let suite = suite();
    let clauses = cases::clauses().expect("the clauses load");
    let rulings: HashSet<String> = cases::rulings()
        .expect("the rulings load")
        .into_iter()
        .map(|ruling| ruling.id)
        .collect();
    for clause in &clauses {
        let id = &clause.id;
        let has_case = suite.cases.iter().any(|case| case.clauses.contains(id));
        let has_misreading = misreadings::all().any(|misreading| misreading.clause == id);
        match clause.status {
            Status::Tested => assert!(
                has_case && has_misreading,
                "{id}: case {has_case}, misreading {has_misreading}"
            ),
            Status::Ruled => {
                assert!(
                    has_case && has_misreading,
                    "{id}: case {has_case}, misreading {has_misreading}"
                );
                assert!(
                    clause
                        .ruling
                        .as_ref()
                        .is_some_and(|ruling| rulings.contains(ruling)),
                    "{id}: {:?}",
                    clause.ruling
                );
            }
            Status::Informative | Status::Untestable => {
                assert!(clause.why.is_some(), "{id} does not say why");
            }
        }
    }
}

#[test]
fn every_link_leads_somewhere() {
    let clauses: HashSet<String> = cases::clauses()
        .expect("the clauses load")
        .into_iter()
        .map(|clause| clause.id)
        .collect();
    let rulings = cases::rulings().expect("the rulings load");
    for case in &suite().cases {
        assert!(
            !case.clauses.is_empty() && case.clauses.iter().all(|clause| clauses.contains(clause)),
            "{}: {:?}",
            case.id,
            case.clauses
        );
        assert!(
            case.ruling
                .as_ref()
                .is_none_or(|id| rulings.iter().any(|ruling| ruling.id == *id)),
            "{}: {:?}",
            case.id,
            case.ruling
        );
    }
    for ruling in &rulings {
        assert!(
            ruling.clauses.iter().all(|clause| clauses.contains(clause)),
            "{}: {:?}",
            ruling.id,
            ruling.clauses
        );
    }
    let mut slugs = HashSet::new();
    for misreading in misreadings::all() {
        assert!(
            slugs.insert(misreading.slug),
            "{} is there twice",
            misreading.slug
        );
        assert!(
            clauses.contains(misreading.clause),
            "{}: {}",
            misreading.slug,
            misreading.clause
        );
    }
}
