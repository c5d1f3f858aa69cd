//! Tests the strength of the suite: it must catch and distinguish all misreadings.

use std::collections::{HashMap, HashSet};
use std::fs;
use std::path::Path;

use ptm_harness::strength::matrix::{MatrixRow, matrix, run_with_mistakes};
use ptm_mistakes::Change;
use ptm_suite::cases::{Case, Suite};
use ptm_suite::clauses::{self, ClauseStatus, RulingKind};
use ptm_suite::protocol::frame::ViewKind;
use ptm_suite::verdicts::outcome::Outcome;

use crate::in_process::{jobs, suite, suite_of_small_files};
use crate::table::rows;

/// Misreadings that affect only files larger than 4×4 texels, each with the reason.
const LARGE_ONLY: &[(&str, &str)] = &[
    ("sizes-of-four-digits", "a size needs five digits"),
    ("texels-counted-in-16-bits", "a map needs 65,536 texels"),
    ("columns-counted-in-8-bits", "a map needs 257 columns"),
    ("rows-counted-in-8-bits", "a map needs 257 rows"),
];

/// Pairs of misreadings that no file can distinguish, each with the reason.
const EQUIVALENT_PAIRS: &str = "
side-sizes-are-records | sizes-include-side-information | both refuse every file with records
sizes-include-side-information | side-information-before-its-plane | both refuse every file with records
table-one-entry-long | table-separated | both find every table too short and refuse all files with a table
";

/// Misreadings that cannot be detected from the colors that a decoder computes, each with the reason.
const HIDDEN_IN_COLORS: &str = "
tables-of-16-bits-cut
  | the files that reveal it are outside the range in which lossy planes are requested in colors
scale-with-three-decimals | the loss in an ordinary scale is less than the tolerance of a color
byte-order-mark-skipped | its files are assembled by hand and requested only in stored values
";

fn is_small(case: &Case) -> bool {
    case.recipe()
        .is_none_or(|recipe| recipe.size.width <= 4 && recipe.size.height <= 4)
}

/// Returns the slugs of the functions in these files of `crates/ptm-mistakes/src`, in source order.
fn slugs_with_functions(files: &[&str]) -> Vec<String> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/ptm-mistakes/src");
    let text = |file: &&str| fs::read_to_string(directory.join(file)).expect("a source file");
    let lines = files.iter().map(text).collect::<String>();
    let arms = lines.lines().filter_map(|line| {
        let (slug, _) = line.strip_prefix("        \"")?.split_once("\" =>")?;
        Some(slug.to_owned())
    });
    arms.collect()
}

#[test]
fn functions_are_in_the_order_of_the_catalog() {
    let functions = ptm_mistakes::behaviors().filter(|one| !matches!(one.change, Change::Edits(_)));
    let slugs: Vec<&str> = functions.map(|one| one.slug).collect();
    let sections = [
        "header.rs",
        "buffers.rs",
        "lookup.rs",
        "luminance.rs",
        "layout.rs",
        "lists.rs",
        "transforms.rs",
        "motion.rs",
        "prediction.rs",
        "places.rs",
        "side_information.rs",
        "codecs.rs",
        "precision.rs",
    ];
    assert_eq!(slugs_with_functions(&sections), slugs);
    let texture: Vec<&str> = ptm_mistakes::texture::all().map(|one| one.slug).collect();
    assert_eq!(slugs_with_functions(&["texture.rs"]), texture);
}

#[test]
fn every_misreading_is_caught_by_two_cases_and_differs_from_every_other() {
    let suite = suite_of_small_files();
    let matrix = matrix(&suite, jobs(), &|_, _| ());
    assert!(matrix.len() >= 60);
    let weak = matrix.iter().filter_map(|row| weakness(&suite, row));
    let weak: Vec<String> = weak.collect();
    assert!(weak.is_empty(), "{weak:#?}");
    let mut known: HashMap<&[u64], &str> = HashMap::new();
    let mut alike = Vec::new();
    for row in &matrix {
        if let Some(other) = known.insert(&row.answers, row.misreading.slug) {
            alike.push((other, row.misreading.slug));
        }
    }
    let equivalent = rows(EQUIVALENT_PAIRS);
    alike.retain(|&(a, b)| !equivalent.iter().any(|[c, d, _]| (a, b) == (c, d)));
    assert!(alike.is_empty(), "equal answers to every case: {alike:?}");
    let hidden = matrix.iter().filter(|row| !is_seen_in_colors(&suite, row));
    let hidden: HashSet<&str> = hidden.map(|row| row.misreading.slug).collect();
    let known = rows(HIDDEN_IN_COLORS);
    let known: HashSet<&str> = known.iter().map(|[slug, _]| slug.as_str()).collect();
    assert_eq!(hidden, known, "not caught in colors");
}

/// Returns true if some case that catches the misreading in stored values also catches it in colors.
fn is_seen_in_colors(suite: &Suite, row: &MatrixRow) -> bool {
    row.killed_by.chunks(20).any(|some| {
        // A damaged file is requested together with its twin.
        let wanted: HashSet<&String> = (some.iter().map(|&i| &suite.cases[i]))
            .flat_map(|case| [Some(&case.id), case.twin_of.as_ref()])
            .flatten()
            .collect();
        let cases = (suite.cases.iter())
            .filter(|case| wanted.contains(&case.id))
            .cloned()
            .collect();
        let some = Suite { cases };
        let (run, _) = run_with_mistakes(
            &some,
            &[row.misreading],
            &[ViewKind::Rgb],
            jobs(),
            &HashMap::new(),
        );
        run.judgment.with_outcome(Outcome::Fail).next().is_some()
    })
}

/// Returns the reason why a misreading is not caught well enough, if any.
fn weakness(suite: &Suite, row: &MatrixRow) -> Option<String> {
    let slug = row.misreading.slug;
    let large = LARGE_ONLY.iter().any(|&(known, _)| known == slug);
    let small = row.killed_by.iter().any(|&i| is_small(&suite.cases[i]));
    let mut killers = row.killed_by.iter().map(|&i| &suite.cases[i]);
    let is_cited = killers.any(|case| case.clauses.iter().any(|id| id == row.misreading.clause));
    // Sections 1.0 to 2.8 need a small case. In 2.9, the size of a stream differs from that of its image.
    let needs_small_case = !row.misreading.clause.starts_with("2.9");
    match row.killed_by.len() {
        count @ 0..2 => Some(format!("{slug} is caught by {count} cases")),
        _ if needs_small_case && small == large => {
            Some(format!("{slug}: caught by a small case: {small}"))
        }
        _ if !is_cited => Some(format!(
            "{slug} is caught by no case about {}",
            row.misreading.clause
        )),
        _ => None,
    }
}

#[test]
fn every_clause_is_tested_or_has_a_reason() {
    let suite = suite().with_prepared_files();
    let clauses = clauses::clauses().expect("the clauses load");
    let rulings = clauses::rulings().expect("the rulings load");
    for clause in &clauses {
        let id = &clause.id;
        let has_case = suite.cases.iter().any(|case| case.clauses.contains(id));
        let has_misreading = ptm_mistakes::all().any(|misreading| misreading.clause == id);
        let is_covered = match clause.status {
            ClauseStatus::Tested => has_case && has_misreading,
            ClauseStatus::Ruled => {
                let ruling = clause.ruling.as_ref().expect("a ruled clause has a ruling");
                let ruling = rulings.iter().find(|one| one.id == *ruling).expect(id);
                // Every listed reading of a choice is correct, so there is no misreading.
                has_case && (has_misreading || ruling.kind == RulingKind::Choice)
            }
            ClauseStatus::Informative | ClauseStatus::Untestable => clause.why.is_some(),
        };
        assert!(
            is_covered,
            "{id}: case {has_case}, misreading {has_misreading}"
        );
    }
}

#[test]
fn every_referenced_id_exists() {
    let clauses = clauses::clauses().expect("the clauses load");
    let rulings = clauses::rulings().expect("the rulings load");
    let ids: HashSet<&String> = clauses.iter().map(|clause| &clause.id).collect();
    let are_known = |clauses: &[String]| clauses.iter().all(|id| ids.contains(id));
    let ruling = |id: &String| rulings.iter().find(|ruling| ruling.id == *id);
    for case in &suite().cases {
        let has_clauses = !case.clauses.is_empty() && are_known(&case.clauses);
        let has_ruling = case.ruling.as_ref().is_none_or(|id| ruling(id).is_some());
        assert!(has_clauses && has_ruling, "{}: {:?}", case.id, case.ruling);
    }
    for clause in &clauses {
        let ruling = clause.ruling.as_ref().and_then(ruling);
        let is_named = ruling.is_none_or(|ruling| ruling.clauses.contains(&clause.id));
        assert!(is_named, "{}: its ruling does not name it", clause.id);
    }
    for ruling in &rulings {
        assert!(are_known(&ruling.clauses), "{}", ruling.id);
    }
    let mut slugs = HashSet::new();
    for misreading in ptm_mistakes::all() {
        assert!(
            slugs.insert(misreading.slug),
            "duplicate {}",
            misreading.slug
        );
        assert!(
            ids.contains(&misreading.clause.to_owned()),
            "{}",
            misreading.slug
        );
    }
}
