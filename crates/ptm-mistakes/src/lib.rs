#![doc = include_str!("../README.md")]
//!
//! A [`Misreading`] consists of data and a [`Change`]. `spec-cases/misreadings.yaml` contains its slug, clause, effect and fix, and
//! the step that it changes. The modules for the sections have one change per slug, in the order of the YAML file.
//! Every function is *total*: it returns for any bytes, including the output of other misreadings, and checks every index.

pub mod error;
pub mod formula;

mod misreading;

mod change;

mod step;

mod anatomy;

/// §2.0–2.3: the header, and the spelling of numbers in §2.4
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

/// §2.9.2: the choice and effect of transforms
mod transforms;

/// §2.9.3: motion vectors
mod motion;

/// §2.9.4 and §2.9.5: ranks, references, and adding predictors to residuals
mod prediction;

/// §2.9.6–2.9.8/1: sizes, offsets and order of the planes
mod places;

/// §2.9.8: side information
mod side_information;

/// §2.9.8: the streams of planes
mod codecs;

/// §2.9.8: zeros among the preset parameters of JPEG-LS streams
mod literal_presets;

/// §1.0, §2.4, §2.6 and §2.7: arithmetic of low precision
mod precision;

mod catalog;

/// Misreadings of the texture suite
pub mod texture;

/// Mistakes of writers
pub mod writing;

mod answer;

mod half;

pub use crate::error::{Error, Result};
pub use crate::formula::Stage;
pub use anatomy::{Anatomy, EditedFile};
pub use answer::{
    answer, answer_with, apply_to_reading, formula_edits, plane_edits, read, refusal_answer,
    render, stored_values, unrounded_values,
};
pub use catalog::{all, behaviors, find};
pub use change::Change;
pub use misreading::{Misreading, Sighting, Symptom};
pub use step::Step;
