//! Formats of which no file is read correctly. Their files cannot separate several causes.

use super::layout_clause;
use super::refusals::example;
use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::witness::Witness;
use crate::ptm::Format;
use crate::suite::cases::Expect;

/// Describes each format whose files all fail, in more than one way. Removes its failures from `left`.
pub(in crate::diagnose) fn describe(
    witnesses: &[Witness],
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let mut diagnoses = Vec::new();
    for format in Format::ALL {
        let of_format = |w: &usize| witnesses[*w].case.format() == format;
        let is_read = |w: &usize| {
            of_format(w) && witnesses[*w].case.expect == Expect::Decode && !left.contains(w)
        };
        let of: Vec<usize> = left.iter().copied().filter(of_format).collect();
        let mut ways: Vec<String> = FailureMode::among(witnesses, &of)
            .into_iter()
            .map(|mode| format!("{mode} {}", mode.select(witnesses, &of).len()))
            .collect();
        let refuses = !ways.is_empty();
        let is_wrong = |w: &&usize| FailureMode::of(&witnesses[**w]).is_none();
        let wrong = of.iter().filter(is_wrong).count();
        if wrong > 0 {
            ways.push(format!("shows wrong images for {wrong}"));
        }
        // If most of them are wrong images, these are described one by one.
        let mostly_wrong = wrong * 2 > of.len();
        if !refuses || mostly_wrong || ways.len() < 2 || (0..witnesses.len()).any(|w| is_read(&w)) {
            continue;
        }
        left.retain(|w| !of.contains(w));
        let words = Words {
            effect: format!(
                "reads no file of format {} correctly: it {}",
                format.short_name(),
                ways.join(", ")
            ),
            fix: "start with the example, the smallest of these files".to_owned(),
            example: example(witnesses, &of),
        };
        let diagnosis = Diagnosis::described(Category::Difference, witnesses, &of, words);
        diagnoses.push(diagnosis.about(layout_clause(format)));
    }
    diagnoses
}
