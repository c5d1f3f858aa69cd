//! What no mistake explains, put into words.

pub(super) mod acceptances;
mod arithmetic;
pub(super) mod formats;
pub(super) mod nondeterminism;
pub(super) mod place;
pub(super) mod promises;
pub(super) mod refusals;
pub(super) mod violation;

pub use arithmetic::steps as arithmetic_steps;

/// Different faults or kinds that are named, at most.
const NAMED: usize = 6;

/// The first of these, and how many more there are: "a; b; and one other fault".
fn first_of(all: &[&str], noun: &str) -> String {
    let (named, more) = all.split_at(all.len().min(NAMED));
    let named = named.join("; ");
    match more.len() {
        0 => named,
        1 => format!("{named}; and one other {noun}"),
        more => format!("{named}; and {more} other {noun}s"),
    }
}
