//! Cases, their expected results, and open questions with several right answers.

pub mod address;
pub mod cases;
pub mod choices;
pub mod clauses;
pub mod compare;
pub mod corpus;
pub mod damages;
pub mod dialect;
pub mod features;
mod load;
pub mod name;
#[cfg(unix)]
pub(crate) mod origin;
mod ptm;
pub(crate) mod recipes;
mod record;
pub mod test_case;
pub mod texture;
pub mod values;
pub(crate) mod words;
