#![doc = include_str!("../README.md")]

pub mod address;
pub mod cases;
pub mod choices;
pub mod clauses;
pub mod compare;
pub mod corpus;
pub mod damages;
pub mod dialect;
pub mod error;
pub mod features;
pub mod kit;
mod load;
pub mod name;
pub mod origin;
pub mod protocol;
mod ptm_case;
pub mod recipes;
mod record;
pub mod test_case;
pub mod texture;
pub mod values;
pub mod verdicts;
pub mod words;

pub use error::{Error, Result};
