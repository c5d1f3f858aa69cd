//! Descriptions of the failures that no mistake explains.

pub(super) mod acceptances;
mod arithmetic;
pub(super) mod formats;
pub(super) mod nondeterminism;
pub(super) mod place;
pub(super) mod promises;
pub(super) mod refusals;
pub(super) mod uniform;
pub(super) mod violation;

pub use arithmetic::steps as arithmetic_steps;

use super::scope::Shared;
use super::witness::Witness;
use crate::ptm::Format;
use crate::suite::cases::Expect;

/// Returns "every legal file with predicted planes", "12 of 14 legal files with predicted planes" if some of them are treated
/// differently, or `None` if most are. The files are those of one format, or of all.
fn files_in(witnesses: &[Witness], shared: &Shared, format: Option<Format>) -> Option<String> {
    let is_other = |w: &usize| {
        let witness = &witnesses[*w];
        witness.case.expect == Expect::Decode
            && format.is_none_or(|format| witness.case.format() == format)
            && shared.scope.holds(witness)
            && !shared.of.contains(w)
    };
    let of_format = format.map_or(String::new(), |format| {
        format!("of {} ", format.short_name())
    });
    let scope = of_format + &shared.scope.describe();
    let count = shared.of.len();
    match (0..witnesses.len()).filter(is_other).count() {
        0 => Some(format!("every legal file {scope}")),
        others if others >= count => None,
        others => Some(format!("{count} of {} legal files {scope}", count + others)),
    }
}

/// Faults or kinds that are listed; the others are counted.
const MAX_LISTED: usize = 6;

/// Lists the first of these and counts the others: "a; b; and 1 other fault".
fn first_of(all: &[&str], noun: &str) -> String {
    let (named, more) = all.split_at(all.len().min(MAX_LISTED));
    let named = named.join("; ");
    match more.len() {
        0 => named,
        1 => format!("{named}; and 1 other {noun}"),
        more => format!("{named}; and {more} other {noun}s"),
    }
}
