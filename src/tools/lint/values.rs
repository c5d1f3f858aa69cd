//! Numbers and tables that are read and still odd.

use super::Finding;
use super::codes;
use crate::tools::anatomy::{Anatomy, Role};

pub(super) fn find(anatomy: &Anatomy) -> Vec<Finding> {
    [
        numbers(anatomy),
        matrix(anatomy),
        table(anatomy),
        trailing(anatomy),
    ]
    .concat()
}

/// Scales and biases.
fn numbers(anatomy: &Anatomy) -> Vec<Finding> {
    let mut findings = Vec::new();
    for i in 0..6 {
        let at = |role| anatomy.part(role).map_or(0, |part| part.range.start);
        if anatomy
            .text(Role::Scale(i))
            .and_then(|text| text.parse().ok())
            == Some(0.0)
        {
            findings.push(Finding::new(
                &codes::SCALE_ZERO,
                at(Role::Scale(i)),
                format!("the scale of a{i}"),
            ));
        }
        let Some(bias) = anatomy.text(Role::Bias(i)) else {
            continue;
        };
        let Some(value) = bias
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite() && value.fract() == 0.0)
        else {
            continue;
        };
        let found = format!("the bias of a{i} is {bias}");
        if bias.contains(['.', 'e', 'E']) {
            findings.push(Finding::new(
                &codes::BIAS_AS_FLOAT,
                at(Role::Bias(i)),
                &found,
            ));
        }
        if !(-32768.0..=32767.0).contains(&value) {
            findings.push(Finding::new(
                &codes::BIAS_BEYOND_16_BITS,
                at(Role::Bias(i)),
                found,
            ));
        }
    }
    findings
}

/// The last row of the color matrix.
fn matrix(anatomy: &Anatomy) -> Vec<Finding> {
    let odd = [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)]
        .into_iter()
        .find_map(|(element, usual)| {
            let part = anatomy.part(Role::Matrix(element))?;
            let text = anatomy.text(Role::Matrix(element))?;
            (text.parse::<f64>().ok()? != usual).then(|| {
                Finding::new(
                    &codes::MATRIX_LAST_ROW,
                    part.range.start,
                    format!("element {element} is {text}"),
                )
            })
        });
    odd.into_iter().collect()
}

/// The lookup table: its size, and who uses it.
fn table(anatomy: &Anatomy) -> Vec<Finding> {
    let mut findings = Vec::new();
    let (Some(count), Some(entries)) = (anatomy.part(Role::Count), anatomy.number(Role::Count))
    else {
        return findings;
    };
    if entries > 65_536 {
        findings.push(Finding::new(
            &codes::HUGE_TABLE,
            count.range.start,
            format!("{entries} entries"),
        ));
    }
    let (Ok(_), Some(indices), Ok(entries)) = (
        &anatomy.outcome,
        anatomy.bytes(Role::Indices),
        usize::try_from(entries),
    ) else {
        return findings;
    };
    let mut used = vec![false; entries];
    for index in indices.chunks(if entries <= 256 { 1 } else { 2 }) {
        let index = index
            .iter()
            .rev()
            .fold(0, |index, &byte| index << 8 | usize::from(byte));
        used[index] = true;
    }
    let unused = used.iter().filter(|&&used| !used).count();
    if let Some(first) = used.iter().position(|&used| !used) {
        let found = format!("{unused} of {entries} entries, the first is entry {first}");
        findings.push(Finding::new(
            &codes::ENTRIES_UNUSED,
            count.range.start,
            found,
        ));
    }
    findings
}

/// Bytes behind the last value (ruling `trailing`).
fn trailing(anatomy: &Anatomy) -> Vec<Finding> {
    let (end, length) = (anatomy.end(), anatomy.file.len());
    if anatomy.outcome.is_err() || end == length {
        return Vec::new();
    }
    vec![Finding::new(
        &codes::TRAILING,
        end,
        format!("{} bytes", length - end),
    )]
}
