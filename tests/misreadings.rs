//! The suite is as strong as the mistakes it catches and tells apart.
#![cfg(feature = "harness")]

use std::collections::HashMap;

use ptm_conform::harness::cases::{self, Suite};
use ptm_conform::harness::matrix::{Row, matrix};
use ptm_conform::harness::misreadings;

fn suite() -> Suite {
    Suite::load().expect("the suite loads").prepared()
}

fn rows(suite: &Suite) -> Vec<Row> {
    matrix(suite, &[], 2)
}

#[test]
fn print() {
    let suite = suite();
    let rows = rows(&suite);
    println!("{} misreadings", rows.len());
    for row in &rows {
        let small = row.killed_by.iter().filter(|&&i| suite.cases[i].recipe().is_none_or(|r| r.size.width <= 4 && r.size.height <= 4)).count();
        if row.killed_by.len() < 2 || small == 0 { println!("WEAK {} {} small {}", row.misreading.slug, row.killed_by.len(), small); }
        let about = row.killed_by.iter().filter(|&&i| suite.cases[i].clauses.iter().any(|c| c == row.misreading.clause)).count();
        if about == 0 { println!("NOCLAUSE {} {} {:?}", row.misreading.slug, row.misreading.clause, row.killed_by.iter().take(3).map(|&i| &suite.cases[i].id).collect::<Vec<_>>()); }
    }
    let mut seen: HashMap<&[u64], &str> = HashMap::new();
    for row in &rows {
        if let Some(other) = seen.insert(&row.answers, row.misreading.slug) { println!("SAME {} {}", other, row.misreading.slug); }
    }
    for view in ["raw", "coef", "rgb"] {
        let weak: Vec<_> = matrix(&suite, &[view], 2).into_iter().filter(|row| row.killed_by.is_empty()).map(|row| row.misreading.slug).collect();
        println!("{view}-only survivors: {weak:?}");
    }
    let clauses = cases::clauses().unwrap();
    for c in &clauses {
        let n = suite.cases.iter().filter(|k| k.clauses.contains(&c.id)).count();
        let m = misreadings::all().filter(|m| m.clause == c.id).count();
        if n == 0 || m == 0 { println!("CLAUSE {} cases {} misreadings {} {:?}", c.id, n, m, c.status); }
    }
}
