//! Public readers of PTMs, and what each of them will show of a file.
//!
//! A reader is a [`ReaderProfile`]: the formats that it reads, its misreadings, and what else it does not take, each with its
//! evidence, all of it data (`spec-cases/readers.yaml`). A [`ReaderPrediction`] is made by reading the file as the reader does and
//! holding the result against the truth.

mod profile;

mod limits;

mod difference;

mod predict;

pub use limits::Limit;
pub use predict::{OpenedFile, ReaderPrediction, Shown};
pub use profile::{Evidence, KnownMisreading, ReaderProfile, profiles, profiles_of};
