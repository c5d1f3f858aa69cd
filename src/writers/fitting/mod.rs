//! Fitters: writers whose input is photographs of one object under known lights.
//!
//! ```text
//! FITTER [ARG…] fit REQUEST OUT
//! ```
//!
//! REQUEST names the format and an `.lp` file: the number of pictures, and for each its name and the direction of its light.
//! A fitter is held against the least-squares [`optimum`] of the same pictures, light by light, never against bytes
//! ([`judge`]). Where it loses is told by repeating its mistake: whose optimum under a mistake looks the same, makes it
//! (`mistakes`).

pub mod pictures;

mod algebra;

pub mod polynomials;

pub mod optimum;

pub mod sets;

pub mod judge;

#[cfg_attr(
    not(unix),
    allow(dead_code, reason = "fitters are run on Unix systems")
)]
mod mistakes;

#[cfg(unix)]
pub mod cases;

#[cfg(unix)]
mod reported;
