//! Descriptions of the failures that no mistake explains.

pub(super) mod acceptances;
mod arithmetic;
pub(super) mod formats;
pub(super) mod nondeterminism;
pub(super) mod place;
pub(super) mod promises;
pub(super) mod refusals;
pub(super) mod violation;

pub use arithmetic::steps as arithmetic_steps;

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
