//! The smoke subset: a small set of cases that still catches every misreading.
//!
//! It is computed greedily: the case that catches the most remaining misreadings is added until none remain. Then, cases that
//! have become unnecessary are removed. `spec-cases/smoke.yaml` lists the cases for decoders that read all formats, and for each
//! format the cases that catch every misreading which any case of this format catches. `ptm-conform coverage --write-smoke` updates
//! it.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::strength::matrix::MatrixRow;
use ptm::Format;
use ptm_suite::cases::Suite;
use ptm_suite::kit::yaml::from_yaml;

/// Embedded lists of case ids.
const SMOKE_LISTS: &str = ptm_spec_cases::SMOKE;

/// Name of the list for decoders that read all formats.
const ALL: &str = "all";

/// Returns the ids of the cases for a decoder that reads these formats, or all formats if none is named.
///
/// # Errors
/// Returns a message that names the offending line.
pub fn ids(formats: &[Format]) -> Result<Vec<String>, String> {
    let mut lists: BTreeMap<String, Vec<String>> =
        from_yaml(SMOKE_LISTS).map_err(|error| format!("smoke.yaml: {error}"))?;
    let is_read = |format| formats.contains(format);
    let names: Vec<&str> = match formats.is_empty() || Format::ALL.iter().all(is_read) {
        true => vec![ALL],
        false => formats.iter().map(|format| format.short_name()).collect(),
    };
    let lists = names.iter().filter_map(|&name| lists.remove(name));
    Ok(lists.flatten().collect())
}

/// Returns one flag per case: true if the case is in the subset for a decoder that reads these formats, or all formats if none is
/// named.
///
/// # Errors
/// Returns an error if the list names an unknown case.
pub fn selection(suite: &Suite, formats: &[Format]) -> Result<Vec<bool>, String> {
    let ids = ids(formats)?;
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

/// Returns the smallest sets that were found, as they are stored in `smoke.yaml`: for all formats, and for each format.
#[must_use]
pub fn to_yaml(suite: &Suite, rows: &[MatrixRow]) -> String {
    let mut text = String::from(
        "# Small sets of cases for `ptm-conform check --smoke`. The first one catches every misreading in the catalog; the one of a format\n\
         # catches every misreading that a case of this format catches.\n\
         # Computed, not chosen: `ptm-conform coverage --write-smoke spec-cases/smoke.yaml` regenerates it.\n",
    );
    let mut write_list = |name: &str, rows: &[MatrixRow]| {
        let _ = writeln!(text, "{name}:");
        for i in choose_cases(suite, rows) {
            let _ = writeln!(text, "- {}", suite.cases[i].id);
        }
    };
    write_list(ALL, rows);
    for format in Format::ALL {
        let is_of_format = |i: &usize| suite.cases[*i].format() == format;
        let mut of_format = rows.to_vec();
        for row in &mut of_format {
            row.killed_by.retain(is_of_format);
        }
        write_list(format.short_name(), &of_format);
    }
    text
}
