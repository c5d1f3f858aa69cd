//! Public readers of PTMs, with predictions of their results.
//!
//! A reader is a [`ReaderProfile`]: the formats that it reads, its misreadings, and its other limits, each with its evidence;
//! all of it is data (`spec-cases/readers.yaml`). A [`ReaderPrediction`] is made by reading the file as the reader does and
//! comparing the result with the right one.

mod profile;

mod limits;

mod difference;

mod predict;

pub use limits::Limit;
pub use predict::{OpenedFile, ReaderPrediction, Shown};
pub use profile::{Evidence, KnownMisreading, ReaderProfile, profiles, profiles_of};
