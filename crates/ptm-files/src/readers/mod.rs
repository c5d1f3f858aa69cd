//! Public readers of PTMs, with predictions of their results.
//!
//! A reader is described by a [`ReaderProfile`]: its formats, its misreadings, its other limits, and its behavior on kinds of files
//! that the reference refuses, each with evidence. The profiles are data (`spec-cases/readers.yaml`). To make a
//! [`ReaderPrediction`], a file is read as the reader would read it, and its images under [`LIGHTS`] are compared with the correct
//! ones. Nothing is predicted without evidence.

mod profile;

mod limits;

mod difference;

mod predict;

mod unusual;

pub use difference::{LIGHTS, MAX_INVISIBLE_DIFFERENCE};
pub use limits::Limit;
pub use predict::{OpenedFile, ReaderPrediction, Rendering};
pub use profile::{
    Evidence, KnownMisreading, ReaderProfile, UnusualBehavior, UnusualResult, parse_profiles,
    profiles,
};
pub use unusual::UnusualKind;
