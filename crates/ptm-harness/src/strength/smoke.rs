//! The smoke subset: a small set of cases that still catches every misreading.
//!
//! It is computed greedily: the case that catches the most remaining misreadings is added until none remain. Then, cases that
//! have become unnecessary are removed. `spec-cases/smoke.yaml` lists the cases, and `ptm-conform coverage --write-smoke` updates
//! it.

use std::fmt::Write;

use crate::strength::matrix::MatrixRow;
use ptm_suite::cases::Suite;
use ptm_suite::kit::yaml::from_yaml;

/// Embedded list of case ids.
const SMOKE_LIST: &str = ptm_spec_cases::SMOKE;

/// Returns the ids of the cases in the subset.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn ids() -> Result<Vec<String>, String> {
    from_yaml(SMOKE_LIST).map_err(|error| format!("smoke.yaml: {error}"))
}

/// Returns one flag per case: true if the case is in the subset.
///
/// # Errors
/// Returns an error if the list names an unknown case.
pub fn selection(suite: &Suite) -> Result<Vec<bool>, String> {
    let ids = ids()?;
    if ids.is_empty() {
        return Err(
            "the smoke subset has not been computed: run ptm-conform coverage --write-smoke spec-cases/smoke.yaml, then build again"
                .to_owned(),
        );
    }
    if let Some(unknown) = ids.iter().find(|id| suite.case(id).is_none()) {
        return Err(format!("smoke.yaml: unknown case {unknown}"));
    }
    let selected = suite.cases.iter().map(|case| ids.contains(&case.id));
    Ok(selected.collect())
}

/// Returns, in suite order, a small set of cases that kills every misreading that the whole suite kills.
#[must_use]
pub fn choose_cases(suite: &Suite, rows: &[MatrixRow]) -> Vec<usize> {
    let killed = rows.iter().filter(|row| !row.killed_by.is_empty());
    let mut remaining: Vec<&MatrixRow> = killed.collect();
    let mut chosen = Vec::new();
    while !remaining.is_empty() {
        let mut kills = vec![0_usize; suite.cases.len()];
        for row in &remaining {
            for &case in &row.killed_by {
                kills[case] += 1;
            }
        }
        // On ties, choose the first case.
        let max = kills.iter().max().copied().unwrap_or_default();
        let Some(best) = kills.iter().position(|&count| count == max) else {
            break;
        };
        remaining.retain(|row| !row.killed_by.contains(&best));
        chosen.push(best);
    }
    // Later choices may together kill all misreadings that an earlier one kills.
    for i in (0..chosen.len()).rev() {
        let mut others = chosen.clone();
        others.remove(i);
        let kills = |row: &MatrixRow| {
            row.killed_by.is_empty() || row.killed_by.iter().any(|case| others.contains(case))
        };
        if rows.iter().all(kills) {
            chosen.remove(i);
        }
    }
    chosen.sort_unstable();
    chosen
}

/// Formats the list as it is stored in `smoke.yaml`.
#[must_use]
pub fn to_yaml(suite: &Suite, chosen: &[usize]) -> String {
    let mut text = String::from(
        "# A small set of cases that catches every misreading in the catalog: `ptm-conform check --smoke`.\n\
         # Computed, not chosen: `ptm-conform coverage --write-smoke spec-cases/smoke.yaml` regenerates it.\n",
    );
    for &i in chosen {
        let _ = writeln!(text, "- {}", suite.cases[i].id);
    }
    text
}
