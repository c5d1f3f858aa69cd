//! How the header is written: what is legal, and where readers fail all the same.

use std::collections::HashSet;

use super::codes::Problem;
use super::diagnostic::Diagnostic;
use crate::tools::dissection::{Dissection, FilePart, Role};

/// Each code once, where it shows first.
pub(super) fn diagnose(dissection: &Dissection) -> Vec<Diagnostic> {
    let header = dissection.parts.iter().enumerate();
    let header = header.take_while(|(_, part)| !part.role.is_payload());
    let mut seen = HashSet::new();
    header
        .flat_map(|(place, part)| gap(dissection, part, dissection.gap_after(place)))
        .filter(|diagnostic| seen.insert(diagnostic.code))
        .collect()
}

/// What is odd about the white space after a part of the header.
fn gap(dissection: &Dissection, part: &FilePart, gap: &[u8]) -> Vec<Diagnostic> {
    // Words for what is odd, and mostly nothing is.
    let after = || format!("after the {}", part.role.name(dissection.format));
    let mut odd: Vec<(Problem, String)> = Vec::new();
    if gap == b" \n" {
        let code = match part.role {
            Role::Version | Role::Format => Problem::SpaceAfterName,
            _ => Problem::SpaceBeforeNewline,
        };
        odd.push((code, after()));
    }
    if gap.len() > 1 && gap.iter().all(|&byte| byte == b' ') {
        odd.push((
            Problem::WideGap,
            format!("{} spaces {}", gap.len(), after()),
        ));
    }
    let ends = gap.contains(&b'\n');
    let one_line = !ends && !gap.is_empty();
    let ending = || match one_line {
        true => format!("no line ends {}", after()),
        false => format!("a line ends {}", after()),
    };
    let last = |plane| plane + 1 == dissection.compressed_planes();
    match part.role {
        Role::Width if one_line => odd.push((Problem::SizeOnOneLine, String::new())),
        Role::Scale(5) if one_line => odd.push((Problem::ScaleBiasOnOneLine, String::new())),
        Role::Matrix(0..15) if ends => odd.push((Problem::MatrixLayout, ending())),
        Role::Parameter if one_line => odd.push((Problem::ListLayout, ending())),
        role if role.list().is_some() && role.plane().map(last) == Some(one_line) => {
            odd.push((Problem::ListLayout, ending()));
        }
        _ => {}
    }
    let at = part.range.end;
    odd.into_iter()
        .map(|(code, found)| Diagnostic::new(code, at, found))
        .collect()
}
