#![doc = include_str!("../README.md")]
#![cfg_attr(
    not(feature = "readings"),
    allow(
        dead_code,
        reason = "other readings of the open questions are used only through the feature"
    )
)]

// The types, and the glossary.
pub mod types;

// The fault, the violated clause and the byte offset.
pub mod error;

// JPEG and JPEG-LS, the standards that PTM uses for planes.
pub mod codec;

// The decoder: the decisions that the text leaves to it (`reading`), the arguments of these decisions (`parts`, `input`), bytes →
// header → planes with one file per section of the text (`decode`), and planes → coefficients → color (`evaluate`).
#[cfg(not(feature = "readings"))]
mod decode;
#[cfg(not(feature = "readings"))]
pub mod evaluate;
#[cfg(not(feature = "readings"))]
mod input;
#[cfg(not(feature = "readings"))]
mod parts;
#[cfg(not(feature = "readings"))]
mod reading;

#[cfg(feature = "readings")]
pub mod decode;
#[cfg(feature = "readings")]
pub mod evaluate;
#[cfg(feature = "readings")]
pub mod input;
#[cfg(feature = "readings")]
pub mod parts;
#[cfg(feature = "readings")]
pub mod reading;

pub use decode::{StoredMap, decode, decode_with_limits, examine, fields, open};
#[cfg(feature = "readings")]
pub use decode::{decode_as, open_as};
pub use error::{Error, Result};
pub use evaluate::{Coefficients, RelitImage};
#[cfg(feature = "readings")]
pub use reading::Reading;
pub use types::*;
