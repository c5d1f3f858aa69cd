//! Descriptions of failures that no mistake explains.

pub(super) mod acceptances;
mod arithmetic;
pub(super) mod differences;
pub(super) mod nondeterminism;
pub(super) mod promises;
pub(super) mod refusals;
pub(super) mod uniform;
pub(super) mod violation;

pub use arithmetic::format_steps as arithmetic_steps;

use super::groups::Group;
use super::scope::{
    SharedScope, common_property, has_inconsistent_files, has_unjudged_files, list_formats,
    own_formats,
};
use super::witness::Witness;
use ptm::Format;
use ptm_suite::cases::Expect;

/// Describes the files of a group by what they share or, if that is unknown, by their number and formats.
fn files_of_group(witnesses: &[Witness], group: &Group) -> String {
    if let Some(shared) = &group.shared {
        return files_in_scope(witnesses, shared);
    }
    let share = share_text(witnesses, &group.cases);
    match common_property(witnesses, &group.cases) {
        Some(property) => format!("{share}, all {property}"),
        None => share,
    }
}

/// Describes the files in a scope: "every legal file with predicted planes", or "12 of 14 legal files with predicted planes" if other
/// files in the scope fail in another way. Says "judged legal" if some legal files of these formats were not judged, and "legal files
/// with consistent responses" if some failed with inconsistent ones.
fn files_in_scope(witnesses: &[Witness], shared: &SharedScope) -> String {
    let (count, others) = shared.count_legal(witnesses);
    let files = shared.files_of_formats(witnesses);
    let scope = match has_inconsistent_files(witnesses, &files) {
        true => format!("with consistent responses {}", shared.describe(witnesses)),
        false => shared.describe(witnesses),
    };
    let judged = match has_unjudged_files(witnesses, &files) {
        true => "judged legal",
        false => "legal",
    };
    let files = match others {
        _ if count == 0 => format!(
            "{} files {scope} that need not be decoded",
            shared.cases.len()
        ),
        0 => format!("every {judged} file {scope}"),
        others => {
            let all = count + others;
            format!("{count} of {all} {judged} files {scope} (the others also fail)")
        }
    };
    match shared.cases.len() - count {
        more if more > 0 && count > 0 => format!("{files} (and {more} that need not be decoded)"),
        _ => files,
    }
}

/// Maximum number of formats in a list. Longer lists are omitted.
const MAX_FORMATS: usize = 4;

/// Returns the formats of these files, such as " of RGB, LRGB", or an empty string if there are too many to list.
fn format_names(witnesses: &[Witness], indices: &[usize]) -> String {
    let formats = own_formats(witnesses, indices, &[]);
    match (1..=MAX_FORMATS).contains(&formats.len()) {
        true => format!(" of {}", list_formats(&formats)),
        false => String::new(),
    }
}

/// Returns text such as ", seen in files of RGB" if a mistake that could affect all files shows only in a few formats.
pub(super) fn formats_phrase(witnesses: &[Witness], indices: &[usize]) -> String {
    match format_names(witnesses, indices) {
        names if names.is_empty() => names,
        names => format!(", seen in files{names}"),
    }
}

/// Returns text such as "12 of 160 legal files of LRGB, LUM", followed by the number of files that need not be decoded, if any, and
/// by their formats if the legal files have other formats.
fn share_text(witnesses: &[Witness], indices: &[usize]) -> String {
    let format = |w: usize| witnesses[w].case.format();
    let is_legal = |w: &usize| witnesses[*w].case.expect == Expect::Decode;
    let (legal, others): (Vec<usize>, Vec<usize>) = indices.iter().copied().partition(is_legal);
    let named = if legal.is_empty() { &others } else { &legal };
    let names = format_names(witnesses, named);
    // Without names, the files of all formats count.
    let every: Vec<usize> = (0..witnesses.len()).collect();
    let counted = if names.is_empty() { &every } else { named };
    let of_format = |one: Format| counted.iter().find(|&&w| format(w) == one);
    let counts = Format::ALL
        .into_iter()
        .filter_map(of_format)
        .map(|&w| witnesses[w].legal_files);
    let all: usize = counts.sum();
    match (legal.len(), others.len()) {
        (0, 1) => format!("1 file{names} that need not be decoded"),
        (0, others) => format!("{others} files{names} that need not be decoded"),
        (legal, 0) => format!("{legal} of {all} legal files{names}"),
        (count, more) => {
            let is_named = |w: &usize| legal.iter().any(|&l| format(l) == format(*w));
            let theirs = match names.is_empty() || others.iter().all(is_named) {
                true => String::new(),
                false => match format_names(witnesses, &others) {
                    names if names.is_empty() => " of several formats".to_owned(),
                    names => names,
                },
            };
            format!(
                "{count} of {all} legal files{names} (and {more}{theirs} that need not be decoded)"
            )
        }
    }
}

/// Maximum number of items in a list. Any further items are only counted.
const MAX_LISTED: usize = 6;

/// Lists the first items and counts the rest, as in "a; b; and 1 other fault".
fn list_first(all: &[&str], noun: &str) -> String {
    let (named, more) = all.split_at(all.len().min(MAX_LISTED));
    let named = named.join("; ");
    match more.len() {
        0 => named,
        1 => format!("{named}; and 1 other {noun}"),
        more => format!("{named}; and {more} other {noun}s"),
    }
}
