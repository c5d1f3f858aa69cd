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
        diagnoses.push(diagnosis.about(layout_clause(format)));
    }
    diagnoses
}

/// Returns the clause about the layout of a format.
pub(super) const fn layout_clause(format: Format) -> &'static str {
    match format {
        Format::Rgb => "2.7.1/1",
        Format::Lum => "2.7.2/1",
        Format::Lrgb => "2.7.3/1",
        Format::PtmLut => "2.8.1/1",
        Format::PtmCLut => "2.8.2/1",
        _ => "2.9/1",
    }
}

/// Formats that are listed; more are not mentioned.
const MAX_LISTED: usize = 4;

/// Returns " of RGB, LRGB", the formats of these files, or nothing if there are more than can be listed.
fn names_of(witnesses: &[Witness], of: &[usize]) -> String {
    let is_shown = |format: &Format| of.iter().any(|&w| witnesses[w].case.format() == *format);
    let formats = Format::ALL.into_iter().filter(is_shown);
    let names: Vec<&str> = formats.map(Format::short_name).collect();
    match (1..=MAX_LISTED).contains(&names.len()) {
        true => format!(" of {}", names.join(", ")),
        false => String::new(),
    }
}

/// Returns ", in files of RGB" if a mistake that is made everywhere shows in few formats.
pub(in crate::diagnose) fn formats_of(witnesses: &[Witness], of: &[usize]) -> String {
    match names_of(witnesses, of) {
        names if names.is_empty() => names,
        names => format!(", in files{names}"),
    }
}

/// Returns "12 of 160 legal files of LRGB, LUM".
pub(super) fn share_of_formats(witnesses: &[Witness], of: &[usize]) -> String {
    let format = |w: usize| witnesses[w].case.format();
    let is_akin = |w: &usize| {
        witnesses[*w].case.expect == Expect::Decode
            && of.iter().any(|&one| format(one) == format(*w))
    };
    let all = (0..witnesses.len()).filter(is_akin).count().max(of.len());
    let names = names_of(witnesses, of);
    format!("{} of {all} legal files{names}", of.len())
}
