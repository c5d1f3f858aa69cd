//! Formats of which no file is read correctly. Their files cannot separate several causes.

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
        diagnoses.push(diagnosis.about(clause(format)));
    }
    diagnoses
}

/// Returns the clause about the layout of a format.
const fn clause(format: Format) -> &'static str {
    match format {
        Format::Rgb => "2.7.1/1",
        Format::Lum => "2.7.2/1",
        Format::Lrgb => "2.7.3/1",
        Format::PtmLut => "2.8.1/1",
        Format::PtmCLut => "2.8.2/1",
        _ => "2.9/1",
    }
}

/// Returns ", in files of RGB" if a mistake that is made everywhere shows in at most `most` formats.
pub(in crate::diagnose) fn formats_of(witnesses: &[Witness], of: &[usize], most: usize) -> String {
    let shown = |format: &Format| {
        let mut of = of.iter();
        of.any(|&w| witnesses[w].case.format() == *format)
    };
    let formats: Vec<Format> = Format::ALL.into_iter().filter(shown).collect();
    let names: Vec<&str> = formats.iter().map(|format| format.short_name()).collect();
    match (1..=most).contains(&names.len()) {
        true => format!(", in files of {}", names.join(", ")),
        false => String::new(),
    }
}
