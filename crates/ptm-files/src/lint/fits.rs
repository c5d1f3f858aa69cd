//! Misreadings under which a damaged file with a table fits exactly.
//!
//! A writer with such a misreading writes files that a reader with the same misreading reads to the last byte. The description of the
//! format by the Library of Congress, for example, exchanges the names of the two table formats.

use crate::dissection::Dissection;
use ptm::Format;
use ptm::reading::Reading;
use ptm_mistakes::{Misreading, read};

/// Explains a damaged file by the misreadings of tables under which it fits exactly. Returns `None` if there are none, or if more than
/// two explain it.
pub(super) fn explanation(dissection: &Dissection) -> Option<String> {
    if !dissection.format.is_some_and(Format::has_table) {
        return None;
    }
    let fitting = ptm_mistakes::all().filter(|misreading| {
        let is_about_tables = ["2.5", "2.8"].contains(&section(misreading.clause));
        is_about_tables && fits_exactly(dissection.file, misreading)
    });
    let effects: Vec<&str> = fitting
        .take(3)
        .map(|misreading| misreading.effect)
        .collect();
    let is_explained = (1..=2).contains(&effects.len());
    is_explained.then(|| {
        format!(
            "the file fits exactly if a program {}",
            effects.join(", or ")
        )
    })
}

/// Returns the section of a clause, with two numbers.
fn section(clause: &str) -> &str {
    clause.get(..3).unwrap_or(clause)
}

/// Returns true if a decoder with the misreading reads the file, and needs its last byte.
fn fits_exactly(file: &[u8], misreading: &Misreading) -> bool {
    let is_read = |file: &[u8]| read(&[misreading], Reading::SPEC, file).is_ok();
    is_read(file) && !is_read(&file[..file.len() - 1])
}
