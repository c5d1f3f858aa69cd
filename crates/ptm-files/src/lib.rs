#![doc = include_str!("../README.md")]

pub use error::{Error, Result};
use ptm::Size;

pub mod contact_sheet;
pub mod convert;
pub mod convert_for;
pub mod diff;
pub mod dissection;
pub mod error;
pub mod export;
pub mod inspect;
pub mod lint;
pub mod profiles;
pub mod readers;
pub mod render;
pub mod repair;
pub mod segments;

/// Converts a position in the stored raster, whose first row is the bottom row, to a texel index counted from the top left.
fn texel_index(size: Size, position: u32) -> usize {
    let (column, row) = (position % size.width, position / size.width);
    ((size.height - 1 - row) * size.width + column) as usize
}

/// Formats a number of bytes.
fn count_bytes(count: usize) -> String {
    match count {
        1 => "1 byte".to_owned(),
        count => format!("{count} bytes"),
    }
}

/// Joins the string representations of `items` with `separator`.
pub fn join_texts(items: impl IntoIterator<Item: ToString>, separator: &str) -> String {
    let texts: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
    texts.join(separator)
}

/// Formats the column and row of a texel index that is counted from the top left.
fn describe_position(size: Size, texel: usize) -> String {
    let width = size.width as usize;
    let (column, row) = (texel % width, texel / width);
    format!("column {column}, row {row} from the top")
}
