//! Valid but unusual numbers and tables.

use super::{codes::Problem, diagnostic::Findings, fits};
use crate::count_bytes;
use crate::dissection::{Role, index_values};

pub(super) fn diagnose(findings: &mut Findings) {
    (0..6).for_each(|i| check_scale_and_bias(findings, i));
    // Report the first unusual element in the last row of the color matrix.
    for (element, usual) in [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)] {
        let role = Role::Matrix(element);
        let text = findings.dissection.text(role).unwrap_or_default();
        if text.parse::<f64>().is_ok_and(|number| number != usual) {
            let found = format!("element {element} is {text}");
            findings.add(Problem::MatrixLastRow, role, found);
            break;
        }
    }
    check_table(findings);
    // Report bytes after the last value (ruling `trailing`).
    let (end, length) = (findings.dissection.end(), findings.dissection.file.len());
    if findings.dissection.outcome.is_ok() && end < length {
        let mut found = count_bytes(length - end);
        if matches!(&findings.dissection.file[end..], b"\n" | b"\r\n") {
            found += ", a line end, which text editors add";
        }
        let explanation = fits::explanation(findings.dissection);
        let explanation = explanation.map_or_else(String::new, |text| format!("; {text}"));
        findings.add_at(Problem::Trailing, end, found + &explanation);
    }
}

fn check_scale_and_bias(findings: &mut Findings, i: usize) {
    let dissection = findings.dissection;
    let number = |role| dissection.text(role)?.parse::<f64>().ok();
    if number(Role::Scale(i)) == Some(0.0) {
        let found = format!("the scale of a{i}");
        findings.add(Problem::ScaleZero, Role::Scale(i), found);
    }
    let bias = number(Role::Bias(i)).filter(|bias| bias.is_finite() && bias.fract() == 0.0);
    if let (Some(text), Some(bias)) = (dissection.text(Role::Bias(i)), bias) {
        let found = format!("the bias of a{i} is {text}");
        if text.contains(['.', 'e', 'E']) {
            findings.add(Problem::BiasAsFloat, Role::Bias(i), &*found);
        }
        if !(-32768.0..=32767.0).contains(&bias) {
            findings.add(Problem::BiasTooLarge, Role::Bias(i), found);
        }
    }
}

/// Reports a very large lookup table and unused entries.
fn check_table(findings: &mut Findings) {
    let dissection = findings.dissection;
    let entries = dissection.entries();
    let Some(entries) = entries else { return };
    if entries > 65_536 {
        let found = format!("{entries} entries");
        findings.add(Problem::HugeTable, Role::Count, found);
    }
    let (Ok(_), Some(indices)) = (&dissection.outcome, dissection.bytes(Role::Indices)) else {
        return;
    };
    let mut used = vec![false; entries];
    for index in index_values(indices, if entries <= 256 { 1 } else { 2 }) {
        used[index] = true;
    }
    if let Some(first) = used.iter().position(|&used| !used) {
        let unused = used.iter().filter(|&&used| !used).count();
        let found = format!("{unused} of {entries} entries; the first is entry {first}");
        findings.add(Problem::EntriesUnused, Role::Count, found);
    }
}
