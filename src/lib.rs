//! Reference decoder, generator and conformance harness for Polynomial Texture Maps (PTM 1.2, HP Labs 2001).
#![doc = "placeholder"]

pub mod ptm;

pub mod error;

pub mod reading;

pub mod decode;

pub mod codec;

pub mod evaluate;

#[cfg(feature = "generate")]
pub mod generate;

#[cfg(feature = "harness")]
pub mod harness;

pub use decode::{Limits, Ptm, decode, decode_as};
pub use error::{Error, Result};
pub use reading::Reading;
