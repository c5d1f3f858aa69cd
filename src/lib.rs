//! Reference decoder, generator and conformance harness for Polynomial Texture Maps (PTM 1.2, HP Labs 2001).
//!
//! A PTM stores six coefficients of a polynomial for each texel, so that an image can be relit. Decoding takes a few steps. Each
//! step is a public function, and the results of two decoders can be compared after each step:
//!
//! ```text
//! &[u8] ──decode──→ Header, Planes ──coefficients──→ Coefficients ──evaluate──→ RelitImage
//!         2.1–2.9                    formula of 2.4                  1.0
//! ```
//!
//! ```
//! let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1 1\n1 1 1 1 1 1 0 0 0 0 0 0\n\x00\x00\x00\x00\x00\x80\xff\x80\x00";
//! let ptm = ptm_conform::decode(file)?;
//! let image = ptm.coefficients().evaluate(0.25, -0.5);
//! assert_eq!(image.to_bytes(), [128, 64, 0]);
//! # Ok::<(), ptm_conform::Error>(())
//! ```
//!
//! # Modules, in reading order
//!
//! - [`ptm`]: the types and the glossary. [`error`]: the fault, the violated clause and the byte offset.
//! - [`reading`]: the decisions that the text leaves to a decoder, each a replaceable function. `parts` and `input`
//!   contain the arguments of these functions.
//! - [`evaluate`]: planes → coefficients → color.
//! - [`decode`](mod@decode): bytes → header → planes, with one file per section of the text. `decode/spec.rs`
//!   defines the reading of the reference.
//! - [`codec`]: JPEG and JPEG-LS, the standards that PTM uses for planes.
//! - [`texture`]: the `PEXlib` texture mapping table, applied to an image, such as a PTM under a light.
//! - `generate` (feature `generate`): the mirror image of `decode`, values → bytes, with recipes, spellings and damages.
//! - `suite`, `runner`, `session`, `diagnose`, `report` (feature `harness`): cases → run → judge → diagnose → report.
//! - `readers` (feature `tools`): predicts the results of public decoders for a file.
//! - `tools` (feature `tools`): inspects, checks, renders and converts files.
//! - `writers` (feature `cli`): the suite for programs that write files.
//! - `site` (feature `cli`): the website, which explains the format clause by clause.
//! - `cli` (feature `cli`): the subcommands of the program.
//!
//! The modules of the harness and of the program are hidden here. They are public only for the program, tests and benchmarks,
//! and may change without notice. Use `protocol` and `misreadings` (feature `harness`) to write a decoder that makes
//! mistakes on purpose, as in `examples/misread.rs`.
//!
//! # Guarantees
//!
//! `decode` does no I/O and never uses a file name. `generate` never uses `decode`. There is no `unsafe` code. A
//! recipe produces the same bytes on every platform. The harness judges output, never speed.

pub mod ptm;

pub mod error;

mod input;

mod parts;

pub mod reading;

pub mod decode;

pub mod codec;

pub mod evaluate;

pub mod texture;

#[cfg(feature = "generate")]
pub mod generate;

#[cfg(feature = "harness")]
#[doc(hidden)]
pub mod kit;

#[cfg(feature = "harness")]
#[doc(hidden)]
pub mod formula;

#[cfg(feature = "harness")]
pub mod protocol;

#[cfg(feature = "harness")]
#[doc(hidden)]
pub mod suite;

#[cfg(feature = "harness")]
pub mod misreadings;

#[cfg(feature = "tools")]
#[doc(hidden)]
pub mod readers;

#[cfg(all(feature = "harness", unix))]
#[doc(hidden)]
pub mod runner;

#[cfg(all(feature = "harness", unix))]
#[doc(hidden)]
pub mod session;

#[cfg(all(feature = "harness", unix))]
#[doc(hidden)]
pub mod diagnose;

#[cfg(all(feature = "harness", unix))]
#[doc(hidden)]
pub mod strength;

#[cfg(all(feature = "harness", unix))]
#[doc(hidden)]
pub mod report;

#[cfg(all(feature = "harness", unix))]
#[doc(hidden)]
pub mod fuzz;

#[cfg(feature = "tools")]
#[doc(hidden)]
pub mod tools;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod writers;

#[cfg(all(feature = "cli", unix))]
#[doc(hidden)]
pub mod site;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;

pub use decode::{decode, decode_as};
pub use error::{Error, Result};
pub use ptm::{Limits, Ptm};
pub use reading::Reading;
