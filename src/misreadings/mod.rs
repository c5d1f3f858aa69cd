//! Executable mistakes: each a plausible misreading of one clause, at the one place where it acts.
//!
//! The same catalog names the mistake of a failing decoder, measures the suite (every misreading must be caught, every
//! pair told apart), and proves that each clause is really tested.
//!
//! A [`Misreading`] is data and one function. `spec-cases/misreadings.yaml` says what it is: slug, clause, effect, fix.
//! The files of the sections say where it acts: a line for each slug, in the order of the YAML, with the place ([`At`])
//! and what is done there. Every one is *total*: on any bytes, and on whatever another misreading left of them, it
//! returns, and indexes nothing that it has not measured.

mod misreading;

mod at;

mod anatomy;

/// §2.0–2.3, and the spelling of 2.4's numbers
mod header;

/// §2.0–2.9: strings, buffers and short integers
mod buffers;

/// §2.5 Lookup Table and §2.8 Lookup Table Indices
mod lookup;

/// §2.6 Color Matrix and §2.7.2 `PTM_FORMAT_LUM`
mod luminance;

/// §2.7 Uncompressed Per Texel Data
mod layout;

/// §2.9 and §2.9.1: lines, sizes and the compression parameter
mod lists;

/// §2.9.2: which transform, and what it does
mod transforms;

/// §2.9.3: motion vectors
mod motion;

/// §2.9.4 and §2.9.5: ranks, references, and the sum
mod prediction;

/// §2.9.6–2.9.8/1: sizes, where the planes lie, and which plane is which
mod places;

/// §2.9.8: side information
mod side_information;

/// §2.9.8: the streams of planes
mod codecs;

mod catalog;

/// The texture suite's
pub mod texture;

/// The same mistakes, made by writers
pub mod writing;

mod answer;

pub use crate::formula::Stage;
pub use anatomy::{Anatomy, Seen};
pub use answer::answer;
#[cfg(feature = "tools")]
pub(crate) use answer::edits_of;
#[cfg(feature = "cli")]
pub(crate) use answer::edits_of_planes;
#[cfg(any(unix, feature = "tools"))]
pub(crate) use answer::read;
#[cfg(unix)]
pub(crate) use answer::{colors, misread, show};
pub use at::At;
pub use catalog::{all, named};
pub use misreading::{Misreading, Sighting, Symptom};
