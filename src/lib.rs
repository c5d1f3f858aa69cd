//! The program `ptm-conform`.
//!
//! The parts that other programs can use are crates of their own: `ptm` (the reference decoder), `ptm-generate`, `ptm-texture`,
//! `ptm-suite`, `ptm-mistakes`, `ptm-harness` and `ptm-files`.

#[cfg(unix)]
pub mod runner;

#[cfg(unix)]
pub mod session;

#[cfg(unix)]
pub mod diagnose;

#[cfg(unix)]
pub mod strength;

#[cfg(unix)]
pub mod report;

#[cfg(unix)]
pub mod pipeline;

#[cfg(unix)]
pub mod fuzz;

pub mod writers;

#[cfg(unix)]
pub mod site;

pub mod cli;
