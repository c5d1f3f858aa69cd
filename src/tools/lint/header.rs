//! Legal spellings of the header that some readers do not accept.

use std::collections::HashSet;

use super::codes::Problem;
use super::diagnostic::Findings;
use crate::tools::dissection::{FilePart, Role};

/// Reports each problem once, at its first occurrence.
pub(super) fn diagnose(findings: &mut Findings) {
    let dissection = findings.dissection;
    let count = dissection.compressed_planes();
    let header = dissection.parts.iter().enumerate();
    let mut seen = HashSet::new();
    for (place, part) in header.take_while(|(_, part)| !part.role.is_payload()) {
        for (problem, found) in gap_problems(part, count, dissection.gap_after(place)) {
            if seen.insert(problem) {
                findings.add_at(problem, part.range().end, found);
            }
        }
    }
}

/// Returns the problems of the whitespace after a part of the header.
fn gap_problems(part: &FilePart, planes: usize, gap: &[u8]) -> Vec<(Problem, String)> {
    let after = || format!("after the {}", part.name);
    let mut problems = Vec::new();
    match (gap, part.role) {
        (b" \n", Role::Version | Role::Format) => problems.push((Problem::SpaceAfterName, after())),
        (b" \n", _) => problems.push((Problem::SpaceBeforeNewline, after())),
        _ if gap.len() > 1 && gap.iter().all(|&byte| byte == b' ') => {
            let found = format!("{} spaces {}", gap.len(), after());
            problems.push((Problem::WideGap, found));
        }
        _ => {}
    }
    let ends = gap.contains(&b'\n');
    let one_line = !ends && !gap.is_empty();
    let ending = || match one_line {
        true => format!("no line ends {}", after()),
        false => format!("a line ends {}", after()),
    };
    match part.role {
        Role::Width if one_line => problems.push((Problem::SizeOnOneLine, String::new())),
        Role::Scale(5) if one_line => problems.push((Problem::ScaleBiasOnOneLine, String::new())),
        Role::Matrix(0..15) if ends => problems.push((Problem::MatrixLayout, ending())),
        Role::Parameter if one_line => problems.push((Problem::ListLayout, ending())),
        Role::Transform(plane)
        | Role::MotionX(plane)
        | Role::MotionY(plane)
        | Role::Rank(plane)
        | Role::Reference(plane)
        | Role::StreamSize(plane)
        | Role::SideSize(plane)
            if (plane + 1 == planes) == one_line =>
        {
            problems.push((Problem::ListLayout, ending()));
        }
        _ => {}
    }
    problems
}
