//! Fitters: writers whose input is photographs of one object under known lights.
//!
//! ```text
//! FITTER [ARG…] fit REQUEST OUT
//! ```
//!
//! REQUEST names the format and an `.lp` file: the number of pictures, and for each its name and the direction of its light.
//! The map of a fitter is compared with the least-squares [`optimum`] of the same pictures, light by light, never with its
//! bytes ([`judge`]). A mistake is found by making it: a fitter makes the mistake whose optimum looks like its map
//! (`mistakes`).

mod algebra;
#[cfg(unix)]
pub mod cases;
pub mod judge;
#[cfg_attr(
    not(unix),
    allow(dead_code, reason = "fitters are run on Unix systems")
)]
mod mistakes;
pub mod optimum;
pub mod pictures;
pub mod polynomials;
pub mod sets;
