//! Public readers of PTMs, with predictions of their results.
//!
//! A reader is described by a [`ReaderProfile`]: its formats, its misreadings and its other limits, each with evidence. The
//! profiles are data (`spec-cases/readers.yaml`). To make a [`ReaderPrediction`], a file is read as the reader would read it, and
//! the result is compared with the correct one.

mod profile;

mod limits;

mod difference;

mod predict;

pub use limits::Limit;
pub use predict::{OpenedFile, ReaderPrediction, Rendering};
pub use profile::{Evidence, KnownMisreading, ReaderProfile, parse_profiles, profiles};
