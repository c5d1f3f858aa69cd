//! Tools for one file: what its bytes are, what is odd about it, how it looks, and the same map written otherwise.
//!
//! dissection → inspect, lint. decode → render, export, diff. decode → generate → convert. Nothing here judges a decoder, and
//! nothing reads or writes a file: that is the program's part.

pub mod segments;

pub mod dissection;

pub mod inspect;

pub mod lint;

pub mod render;

#[cfg(feature = "cli")]
pub mod export;

pub mod convert;

pub mod convert_for;

pub mod repair;

pub mod diff;

#[cfg(feature = "cli")]
pub mod profiles;
