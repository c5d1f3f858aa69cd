//! The program `ptm-conform`: its commands, the forms of a report, and the website.
//!
//! The parts that other programs can use are crates of their own: `ptm` (the reference decoder), `ptm-generate`, `ptm-texture`,
//! `ptm-suite`, `ptm-mistakes`, `ptm-harness`, `ptm-files`, `ptm-writers` and `ptm-spec-cases`.

mod lint_page;
pub mod relight;
pub mod report;

#[cfg(unix)]
pub mod site;

pub mod cli;
