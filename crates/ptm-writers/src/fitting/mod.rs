//! Conformance of fitters: writers whose input is a set of photographs of an object under known lights.
//!
//! ```text
//! FITTER [ARG…] fit REQUEST OUT
//! ```
//!
//! REQUEST names the format and an `.lp` file, which contains the number of images and the name and light direction of each
//! image. The suite compares the fitted map with the least-squares [`optimum`] for the same images, light by light. It does not
//! compare the bytes of the files ([`judge`]). Mistakes are found by reproducing them: a fitter is assumed to make a mistake if
//! its map is near the optimum that results from this mistake (`mistakes`).

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
pub mod photographs;
pub mod polynomials;
pub mod sets;
