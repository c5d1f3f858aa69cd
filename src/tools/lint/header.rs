//! How the header is written: what is legal, and what readers stumble over.

use super::Finding;
use super::codes;
use super::errors::planes;
use crate::tools::anatomy::{Anatomy, Role};

pub(super) fn find(anatomy: &Anatomy) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut told = Vec::new();
    // Each thing once, where it shows first.
    let mut tell = |code: &'static codes::Code, at: usize, what: String| {
        if !told.contains(&code.id) {
            told.push(code.id);
            findings.push(Finding::new(code, at, what));
        }
    };
    let count = planes(anatomy.format);
    for (place, part) in anatomy.parts.iter().enumerate() {
        if part.role.is_payload() {
            break;
        }
        let (behind, at) = (anatomy.behind(place), part.range.end);
        let name = part.role.name(anatomy.format);
        let one_line = !behind.contains(&b'\n') && !behind.is_empty();
        if behind == b" \n" {
            match part.role {
                Role::Version | Role::Format => {
                    tell(&codes::SPACE_AFTER_NAME, at, format!("behind the {name}"));
                }
                _ => tell(
                    &codes::SPACE_BEFORE_NEWLINE,
                    at,
                    format!("behind the {name}"),
                ),
            }
        }
        if behind.len() > 1 && behind.iter().all(|&byte| byte == b' ') {
            tell(
                &codes::WIDE_GAP,
                at,
                format!("{} spaces behind the {name}", behind.len()),
            );
        }
        match part.role {
            Role::Width if one_line => tell(&codes::SIZE_ON_ONE_LINE, at, String::new()),
            Role::Scale(5) if one_line => tell(&codes::SCALE_BIAS_ON_ONE_LINE, at, String::new()),
            Role::Matrix(0..15) if behind.contains(&b'\n') => {
                tell(
                    &codes::MATRIX_LAYOUT,
                    at,
                    format!("a line ends behind the {name}"),
                );
            }
            role if role.list().is_some()
                && role
                    .plane()
                    .is_some_and(|plane| (plane + 1 == count) == one_line) =>
            {
                let ends = if one_line {
                    "no line ends"
                } else {
                    "a line ends"
                };
                tell(&codes::LIST_LAYOUT, at, format!("{ends} behind the {name}"));
            }
            Role::Parameter if one_line => tell(
                &codes::LIST_LAYOUT,
                at,
                format!("no line ends behind the {name}"),
            ),
            _ => {}
        }
    }
    findings
}
