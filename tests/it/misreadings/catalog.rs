//! The suite is as strong as the mistakes it catches and tells apart.

use std::collections::{HashMap, HashSet};

use ptm_conform::misreadings;
use ptm_conform::session::outcome::Outcome;
use ptm_conform::strength::matrix::{MatrixRow, ask_all, matrix};
use ptm_conform::suite::cases::{Case, Suite};
use ptm_conform::suite::clauses::{self, ClauseStatus, RulingKind};

/// Mistakes that show only in files larger than 4×4 texels, and why.
const LARGE_BY_NATURE: &[(&str, &str)] = &[
    ("sizes-of-four-digits", "a size needs five digits"),
    ("texels-counted-in-16-bits", "a map needs 65,536 texels"),
    ("columns-counted-in-8-bits", "a map needs 257 columns"),
    ("rows-counted-in-8-bits", "a map needs 257 rows"),
];

/// Pairs that no file tells apart, and why.
const EQUIVALENT: &[(&str, &str, &str)] = &[
    (
        "side-sizes-are-records",
        "sizes-include-side-information",
        "both refuse every file with records",
    ),
    (
        "sizes-include-side-information",
        "side-information-before-its-plane",
        "both refuse every file with records",
    ),
    (
        "sof1-refused",
        "tables-of-16-bits-refused",
        "an encoder that writes one writes the other",
    ),
    (
        "table-one-entry-long",
        "table-separated",
        "both find every table too short and refuse all files with one",
    ),
];

/// Mistakes that hide from a decoder that shows colors only, and why.
const HIDDEN_IN_COLORS: &[(&str, &str)] = &[
    (
        "tables-of-16-bits-cut",
        "the files that show it leave the range in which lossy planes are asked for in colors",
    ),
    (
        "scale-with-three-decimals",
        "what it loses of an ordinary scale is less than the tolerance of a color",
    ),
    (
        "byte-order-mark-skipped",
        "its files are hand-assembled and have stored values only",
    ),
];

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
    let rows = matrix(&suite, jobs(), &|_, _| ());
    println!("{} misreadings, {} cases", rows.len(), suite.cases.len());
    assert!(rows.len() >= 60);
    let weak: Vec<String> = rows
        .iter()
        .filter_map(|row| weakness(&suite, row))
        .collect();
    assert!(weak.is_empty(), "{weak:#?}");
    let mut known: HashMap<&[u64], &str> = HashMap::new();
    let mut alike = Vec::new();
    for row in &rows {
        if let Some(other) = known.insert(&row.answers, row.misreading.slug) {
            alike.push((other, row.misreading.slug));
        }
    }
    alike.retain(|&(a, b)| !EQUIVALENT.iter().any(|&(c, d, _)| (a, b) == (c, d)));
    assert!(alike.is_empty(), "these answer every case alike: {alike:?}");
    let hidden = rows.iter().filter(|row| !is_seen_in_colors(&suite, row));
    let hidden: HashSet<&str> = hidden.map(|row| row.misreading.slug).collect();
    let known: HashSet<&str> = HIDDEN_IN_COLORS.iter().map(|&(slug, _)| slug).collect();
    assert_eq!(hidden, known, "not seen in colors");
}

/// Whether a decoder that shows colors only is caught too, by a case that catches it where stored values are shown.
fn is_seen_in_colors(suite: &Suite, row: &MatrixRow) -> bool {
    row.killed_by.chunks(20).any(|some| {
        // A damaged file is asked beside its twin.
        let wanted: HashSet<&String> = (some.iter().map(|&i| &suite.cases[i]))
            .flat_map(|case| [Some(&case.id), case.twin_of.as_ref()])
            .flatten()
            .collect();
        let cases = (suite.cases.iter())
            .filter(|case| wanted.contains(&case.id))
            .cloned()
            .collect();
        let some = Suite { cases };
        let (run, _) = ask_all(&some, &[row.misreading], &["rgb"], jobs(), &HashMap::new());
        run.judgement.with(Outcome::Fail).next().is_some()
    })
}

/// Why a mistake is not caught well enough.
fn weakness(suite: &Suite, row: &MatrixRow) -> Option<String> {
    let slug = row.misreading.slug;
    let large = LARGE_BY_NATURE.iter().any(|&(known, _)| known == slug);
    let small = row.killed_by.iter().any(|&i| is_small(&suite.cases[i]));
    let own = row.killed_by.iter().any(|&i| {
        suite.cases[i]
            .clauses
            .iter()
            .any(|clause| clause == row.misreading.clause)
    });
    // The smallness of a case is asked of sections 1.0 to 2.8; a stream has a size of its own.
    let smallness_counts = !row.misreading.clause.starts_with("2.9");
    match row.killed_by.len() {
        count @ 0..2 => Some(format!("{slug} is caught by {count} cases")),
        _ if smallness_counts && small == large => {
            Some(format!("{slug}: caught by a small case: {small}"))
        }
        _ if !own => Some(format!(
            "{slug} is caught by no case about {}",
            row.misreading.clause
        )),
        _ => None,
    }
}

#[test]
fn every_clause_is_tested_or_says_why_not() {
    let suite = suite();
    let clauses = clauses::clauses().expect("the clauses load");
    let rulings = clauses::rulings().expect("the rulings load");
    for clause in &clauses {
        let id = &clause.id;
        let has_case = suite.cases.iter().any(|case| case.clauses.contains(id));
        let has_misreading = misreadings::all().any(|misreading| misreading.clause == id);
        match clause.status {
            ClauseStatus::Tested => assert!(
                has_case && has_misreading,
                "{id}: case {has_case}, misreading {has_misreading}"
            ),
            ClauseStatus::Ruled => {
                let ruling = rulings
                    .iter()
                    .find(|ruling| Some(&ruling.id) == clause.ruling.as_ref());
                let ruling =
                    ruling.unwrap_or_else(|| panic!("{id}: {:?} is no ruling", clause.ruling));
                // Every listed reading of a choice is right, and none of them is a misreading.
                let enough = has_misreading || ruling.kind == RulingKind::Choice;
                assert!(
                    has_case && enough,
                    "{id}: case {has_case}, misreading {has_misreading}"
                );
            }
            ClauseStatus::Informative | ClauseStatus::Untestable => {
                assert!(clause.why.is_some(), "{id} does not say why");
            }
        }
    }
}

#[test]
fn every_link_leads_somewhere() {
    let clauses: HashSet<String> = clauses::clauses()
        .expect("the clauses load")
        .into_iter()
        .map(|clause| clause.id)
        .collect();
    let rulings = clauses::rulings().expect("the rulings load");
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
    for clause in clauses::clauses().expect("the clauses load") {
        let ruling = clause.ruling.as_ref();
        let ruling = ruling.and_then(|id| rulings.iter().find(|ruling| ruling.id == *id));
        assert!(
            ruling.is_none_or(|ruling| ruling.clauses.contains(&clause.id)),
            "{}: its ruling does not name it",
            clause.id
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
