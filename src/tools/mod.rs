//! Tools for single files: the meaning of their bytes, unusual properties, rendering, and conversion.
//!
//! dissection → inspect, lint. decode → render, export, diff. decode → generate → convert. Nothing here judges a decoder, and
//! nothing does I/O; the program does.

use crate::ptm::Size;

pub mod segments;

pub mod dissection;

pub mod inspect;

pub mod lint;

pub mod render;

#[cfg(feature = "cli")]
pub mod export;

pub mod convert;

pub mod convert_for;

pub mod repair;

pub mod diff;

#[cfg(feature = "cli")]
pub mod profiles;

/// Returns the place of a texel, counted from the top left, in words.
fn place_in_words(size: Size, texel: usize) -> String {
    let width = size.width as usize;
    let (column, row) = (texel % width, texel / width);
    format!("column {column}, row {row} from the top")
}
