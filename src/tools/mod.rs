//! Tools for single files: the meaning of their bytes, unusual properties, rendering, and conversion.
//!
//! dissection → inspect, lint. decode → render, export, diff. decode → generate → convert. Nothing here judges a decoder, and
//! nothing does I/O; the program does.

use crate::ptm::Size;

pub mod convert;
pub mod convert_for;
pub mod diff;
pub mod dissection;
#[cfg(feature = "cli")]
pub mod export;
pub mod inspect;
pub mod lint;
#[cfg(feature = "cli")]
pub mod profiles;
pub mod render;
pub mod repair;
pub mod segments;

/// Returns the number of the texel, counted from the top left, of a position in the stored raster, whose bottom row is first.
fn texel_at(size: Size, position: u32) -> usize {
    let (column, row) = (position % size.width, position / size.width);
    ((size.height - 1 - row) * size.width + column) as usize
}

/// Joins the texts of `items`.
pub(crate) fn joined<T: ToString>(items: impl IntoIterator<Item = T>, separator: &str) -> String {
    let texts: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
    texts.join(separator)
}

/// Returns the place of a texel, counted from the top left, in words.
fn place_in_words(size: Size, texel: usize) -> String {
    let width = size.width as usize;
    let (column, row) = (texel % width, texel / width);
    format!("column {column}, row {row} from the top")
}
