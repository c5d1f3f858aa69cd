//! Reference decoder, generator and conformance harness for Polynomial Texture Maps (PTM 1.2, HP Labs 2001).
//!
//! A PTM stores six coefficients of a polynomial for each texel, so that a picture can be lit anew. Reading one is
//! four steps, each a public function and a place where two decoders can be compared:
//!
//! ```text
//! &[u8] ──decode──→ Header, Planes ──coefficients──→ Coefficients ──evaluate──→ Picture
//!         2.1–2.9                    2.4's formula                   1.0
//! ```
//!
//! ```
//! let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1 1\n1 1 1 1 1 1 0 0 0 0 0 0\n\x00\x00\x00\x00\x00\x80\xff\x80\x00";
//! let ptm = ptm_conform::decode(file)?;
//! let picture = ptm.coefficients().evaluate(0.25, -0.5);
//! assert_eq!(picture.to_bytes(), [128, 64, 0]);
//! # Ok::<(), ptm_conform::Error>(())
//! ```
//!
//! # The map, in reading order
//!
//! - [`ptm`]: the nouns and the glossary. [`error`]: what × which clause × which byte.
//! - [`decode`](mod@decode): bytes → header → planes, a file for each section of the text. [`evaluate`]: planes → coefficients → color.
//! - [`reading`]: the decisions that the text asks of its reader, each a function that can be exchanged.
//! - [`texture`]: what the `PEXlib` texture mapping table makes of a picture, such as a PTM under a light.
//! - `generate` (feature `generate`): the mirror of `decode`, values → bytes; recipes, spellings, damage.
//! - `harness` (feature `harness`): cases → run → compare → judge → diagnose → report.
//! - `tools` (feature `cli`): what a file is made of, what is odd about it, how it looks; the same map written otherwise.
//!
//! # What is never there
//!
//! `decode` does no I/O and never looks at a file name. `generate` never mentions `decode`. Nothing is `unsafe`. The
//! same recipe gives the same bytes everywhere. The harness judges output, never speed.

pub mod ptm;

pub mod error;

pub mod decode;

pub mod codec;

pub mod evaluate;

pub mod reading;

pub mod texture;

#[cfg(feature = "generate")]
pub mod generate;

#[cfg(feature = "harness")]
pub mod harness;

#[cfg(feature = "cli")]
pub mod tools;

pub use decode::{Limits, Ptm, decode, decode_as};
pub use error::{Error, Result};
pub use reading::Reading;
