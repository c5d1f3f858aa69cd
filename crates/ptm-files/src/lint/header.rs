//! Legal header spellings that some readers do not accept.

use std::collections::HashSet;

use super::{codes::Problem, diagnostic::Findings};
use crate::dissection::{FilePart, Role};

/// Reports each problem once, at its first occurrence.
pub(super) fn diagnose(findings: &mut Findings) {
    let dissection = findings.dissection;
    let count = dissection.compressed_planes();
    let header = dissection.parts.iter().enumerate();
    let mut seen = HashSet::new();
    for (i, part) in header.take_while(|(_, part)| !part.role.is_payload()) {
        for (problem, found) in gap_problems(part, count, dissection.gap_after(i)) {
            if seen.insert(problem) {
                findings.add_at(problem, part.range().end, found);
            }
        }
    }
}

/// Returns the problems with the whitespace after a part of the header.
fn gap_problems(part: &FilePart, planes: usize, gap: &[u8]) -> Vec<(Problem, String)> {
    let place = || format!("after the {}", part.name);
    let mut problems = Vec::new();
    match (gap, part.role) {
        (b" \n", Role::Version | Role::Format) => problems.push((Problem::SpaceAfterName, place())),
        (b" \n", _) => problems.push((Problem::SpaceBeforeNewline, place())),
        _ if gap.len() > 1 && gap.iter().all(|&byte| byte == b' ') => {
            let found = format!("{} spaces {}", gap.len(), place());
            problems.push((Problem::WideGap, found));
        }
        _ => {}
    }
    let has_newline = gap.contains(&b'\n');
    let one_line = !has_newline && !gap.is_empty();
    let newline = || match one_line {
        true => format!("no line feed {}", place()),
        false => format!("a line feed {}", place()),
    };
    match part.role {
        Role::Width if one_line => problems.push((Problem::SizeOnOneLine, String::new())),
        Role::Scale(5) if one_line => problems.push((Problem::ScaleBiasOnOneLine, String::new())),
        Role::Matrix(0..15) if has_newline => problems.push((Problem::MatrixLayout, newline())),
        Role::Parameter if one_line => problems.push((Problem::ListLayout, newline())),
        Role::Transform(plane)
        | Role::MotionX(plane)
        | Role::MotionY(plane)
        | Role::Rank(plane)
        | Role::Reference(plane)
        | Role::StreamSize(plane)
        | Role::SideSize(plane)
            if (plane + 1 == planes) == one_line =>
        {
            problems.push((Problem::ListLayout, newline()));
        }
        _ => {}
    }
    problems
}
