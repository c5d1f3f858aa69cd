//! Numbers and tables that are read and still odd.

use super::codes::Problem;
use super::diagnostic::Diagnostic;
use crate::tools::dissection::{Dissection, Role};

pub(super) fn diagnose(dissection: &Dissection) -> Vec<Diagnostic> {
    [
        (0..6).flat_map(|i| scale_and_bias(dissection, i)).collect(),
        matrix(dissection),
        table(dissection),
        trailing(dissection),
    ]
    .concat()
}

/// The scale and the bias of coefficient `i`.
fn scale_and_bias(dissection: &Dissection, i: usize) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let number = |role| dissection.text(role)?.parse::<f64>().ok();
    if number(Role::Scale(i)) == Some(0.0) {
        let (at, found) = (
            dissection.start(Role::Scale(i)),
            format!("the scale of a{i}"),
        );
        diagnostics.push(Diagnostic::new(Problem::ScaleZero, at, found));
    }
    let whole = number(Role::Bias(i)).filter(|bias| bias.is_finite() && bias.fract() == 0.0);
    if let (Some(text), Some(bias)) = (dissection.text(Role::Bias(i)), whole) {
        let as_float = text.contains(['.', 'e', 'E']);
        let beyond = !(-32768.0..=32767.0).contains(&bias);
        let odd = [
            (as_float, Problem::BiasAsFloat),
            (beyond, Problem::BiasBeyond16Bits),
        ];
        let at = dissection.start(Role::Bias(i));
        diagnostics.extend(
            odd.into_iter()
                .filter(|(is_so, _)| *is_so)
                .map(|(_, code)| Diagnostic::new(code, at, format!("the bias of a{i} is {text}"))),
        );
    }
    diagnostics
}

/// The last row of the color matrix.
fn matrix(dissection: &Dissection) -> Vec<Diagnostic> {
    let odd = |(element, usual): (usize, f64)| {
        let text = dissection.text(Role::Matrix(element))?;
        let at = dissection.start(Role::Matrix(element));
        (text.parse::<f64>().ok()? != usual).then(|| {
            let found = format!("element {element} is {text}");
            Diagnostic::new(Problem::MatrixLastRow, at, found)
        })
    };
    let row = [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)];
    row.into_iter().find_map(odd).into_iter().collect()
}

/// The lookup table: its size, and whether all of it is used.
fn table(dissection: &Dissection) -> Vec<Diagnostic> {
    let at = dissection.start(Role::Count);
    let entries = dissection.number(Role::Count);
    let Some(entries) = entries.and_then(|entries| usize::try_from(entries).ok()) else {
        return Vec::new();
    };
    let mut diagnostics = Vec::new();
    if entries > 65_536 {
        let found = format!("{entries} entries");
        diagnostics.push(Diagnostic::new(Problem::HugeTable, at, found));
    }
    let (Ok(_), Some(indices)) = (&dissection.outcome, dissection.bytes(Role::Indices)) else {
        return diagnostics;
    };
    let mut used = vec![false; entries];
    for index in indices.chunks(if entries <= 256 { 1 } else { 2 }) {
        let bytes = index.iter().rev();
        used[bytes.fold(0, |index, &byte| index << 8 | usize::from(byte))] = true;
    }
    if let Some(first) = used.iter().position(|&used| !used) {
        let unused = used.iter().filter(|&&used| !used).count();
        let found = format!("{unused} of {entries} entries, the first is entry {first}");
        diagnostics.push(Diagnostic::new(Problem::EntriesUnused, at, found));
    }
    diagnostics
}

/// Bytes after the last value (ruling `trailing`).
fn trailing(dissection: &Dissection) -> Vec<Diagnostic> {
    let (end, length) = (dissection.end(), dissection.file.len());
    if dissection.outcome.is_err() || end == length {
        return Vec::new();
    }
    let found = format!("{} bytes", length - end);
    vec![Diagnostic::new(Problem::Trailing, end, found)]
}
