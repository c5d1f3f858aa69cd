//! The smoke subset: few cases that still catch every misreading of the catalog.
//!
//! It is computed greedily: the case that catches most comes first, then the one that catches most of the rest. The list is in
//! `spec-cases/smoke.yaml`; `ptm-conform coverage --write-smoke` writes it again.

use std::fmt::Write;

use crate::kit::yaml::from_yaml;
use crate::strength::matrix::MatrixRow;
use crate::suite::cases::Suite;

/// The embedded list.
const SMOKE_LIST: &str = include_str!("../../spec-cases/smoke.yaml");

/// Returns the ids of the subset.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn ids() -> Result<Vec<String>, String> {
    from_yaml(SMOKE_LIST).map_err(|error| format!("smoke.yaml: {error}"))
}

/// Returns true for each case of a suite that is in the subset.
///
/// # Errors
/// If the list names an unknown case.
pub fn selection(suite: &Suite) -> Result<Vec<bool>, String> {
    let ids = ids()?;
    if ids.is_empty() {
        return Err(
            "the smoke subset has not been computed: ptm-conform coverage --write-smoke spec-cases/smoke.yaml, then build again"
                .to_owned(),
        );
    }
    if let Some(unknown) = ids.iter().find(|id| suite.case(id).is_none()) {
        return Err(format!("smoke.yaml: unknown case {unknown}"));
    }
    let selected = suite.cases.iter().map(|case| ids.contains(&case.id));
    Ok(selected.collect())
}

/// Returns few cases that kill all misreadings that any case kills, in the order of the suite.
#[must_use]
pub fn choose(suite: &Suite, rows: &[MatrixRow]) -> Vec<usize> {
    let killed = rows.iter().filter(|row| !row.killed_by.is_empty());
    let mut left: Vec<&MatrixRow> = killed.collect();
    let mut chosen = Vec::new();
    while !left.is_empty() {
        let mut kills = vec![0_usize; suite.cases.len()];
        for row in &left {
            for &case in &row.killed_by {
                kills[case] += 1;
            }
        }
        // The first among equals.
        let most = kills.iter().max().copied().unwrap_or_default();
        let Some(best) = kills.iter().position(|&count| count == most) else {
            break;
        };
        left.retain(|row| !row.killed_by.contains(&best));
        chosen.push(best);
    }
    // Misreadings that one choice kills may also be killed by later ones together.
    for place in (0..chosen.len()).rev() {
        let mut without = chosen.clone();
        without.remove(place);
        let kills = |row: &MatrixRow| {
            row.killed_by.is_empty() || row.killed_by.iter().any(|case| without.contains(case))
        };
        if rows.iter().all(kills) {
            chosen.remove(place);
        }
    }
    chosen.sort_unstable();
    chosen
}

/// Returns the list as it is stored.
#[must_use]
pub fn to_yaml(suite: &Suite, chosen: &[usize]) -> String {
    let mut text = String::from(
        "# A small set of cases that catches every misreading of the catalog: `ptm-conform check --smoke`.\n\
         # Computed, not chosen: `ptm-conform coverage --write-smoke spec-cases/smoke.yaml` writes it anew.\n",
    );
    for &i in chosen {
        let _ = writeln!(text, "- {}", suite.cases[i].id);
    }
    text
}
