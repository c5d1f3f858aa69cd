//! The smoke subset: few cases that still catch every misreading of the catalogue.
//!
//! It is computed, not chosen: the case that catches most goes first, then the one that catches most of what is left. The
//! list stands in `spec-cases/smoke.yaml`; `ptm-conform coverage --write-smoke` writes it anew.

use std::fmt::Write;

use crate::kit::yaml::from_yaml;
use crate::strength::matrix::MatrixRow;
use crate::suite::cases::Suite;

/// The list that is part of the program.
const LIST: &str = include_str!("../../spec-cases/smoke.yaml");

/// The ids of the subset.
///
/// # Errors
/// A sentence that names the line at fault.
pub fn ids() -> Result<Vec<String>, String> {
    from_yaml(LIST).map_err(|error| format!("smoke.yaml: {error}"))
}

/// Which cases of a suite are in the subset.
///
/// # Errors
/// If the list names a case that is not there.
pub fn selection(suite: &Suite) -> Result<Vec<bool>, String> {
    let ids = ids()?;
    if ids.is_empty() {
        return Err(
            "the smoke subset has not been computed: ptm-conform coverage --write-smoke spec-cases/smoke.yaml, then build again"
                .to_owned(),
        );
    }
    if let Some(unknown) = ids.iter().find(|id| suite.case(id).is_none()) {
        return Err(format!("smoke.yaml: no case is called {unknown}"));
    }
    let selected = suite.cases.iter().map(|case| ids.contains(&case.id));
    Ok(selected.collect())
}

/// Few cases that kill all that any case kills; in the order of the suite.
#[must_use]
pub fn choose(suite: &Suite, rows: &[MatrixRow]) -> Vec<usize> {
    let mut left: Vec<&MatrixRow> = rows
        .iter()
        .filter(|row| !row.killed_by.is_empty())
        .collect();
    let mut chosen = Vec::new();
    while !left.is_empty() {
        let mut kills = vec![0_usize; suite.cases.len()];
        for row in &left {
            for &case in &row.killed_by {
                kills[case] += 1;
            }
        }
        // Among equals the first in the suite.
        let most = kills.iter().max().copied().unwrap_or_default();
        let Some(best) = kills.iter().position(|&count| count == most) else {
            break;
        };
        left.retain(|row| !row.killed_by.contains(&best));
        chosen.push(best);
    }
    // What one choice kills, later ones together may kill too.
    for place in (0..chosen.len()).rev() {
        let without: Vec<usize> = chosen
            .iter()
            .copied()
            .filter(|&i| i != chosen[place])
            .collect();
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

/// The list as it is kept.
#[must_use]
pub fn to_yaml(suite: &Suite, chosen: &[usize]) -> String {
    let mut text = String::from(
        "# Few cases that catch every misreading of the catalogue: `ptm-conform check --smoke`.\n\
         # Computed, not chosen: `ptm-conform coverage --write-smoke spec-cases/smoke.yaml` writes it anew.\n",
    );
    for &i in chosen {
        let _ = writeln!(text, "- {}", suite.cases[i].id);
    }
    text
}
