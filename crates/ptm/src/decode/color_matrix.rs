//! §2.6 Color Matrix
//!
//! Sixteen floating point numbers (clause 2.6/2) after the biases, in column-major order as in OpenGL (clause 2.6/3).
//!
//! ```text
//! numbers in the file         e0 e1 e2 e3   e4 e5 e6 e7   e8 e9 e10 e11   e12 e13 e14 e15
//! red                         e0 · Y + e4 · Cr + e8 · Cb + e12
//! green                       e1 · Y + e5 · Cr + e9 · Cb + e13
//! blue                        e2 · Y + e6 · Cr + e10 · Cb + e14
//! ```
//!
//! Format notes
//! - The numbers are on one line. Other line breaks are accepted as well (ruling `lum-layout`).
//! - The last row, elements 3, 7, 11 and 15, is 0 0 0 1 in the text and is ignored (ruling `lum-last-row`).
//! - No LUM file by the format's authors is known. The vector that the matrix multiplies, the order of the numbers
//!   and the range of the values are three choices (rulings `lum-vector`, `lum-major`, `lum-range`).

use crate::error::Result;
use crate::input::Input;
use crate::types::ColorMatrix;

/// Reads the sixteen elements in file order (clause 2.6/2).
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn read(input: &mut Input) -> Result<ColorMatrix> {
    let mut elements = [0.0; 16];
    for (i, element) in elements.iter_mut().enumerate() {
        // lum-layout: sixteen numbers on one line, or any other line breaks.
        if i > 0 {
            input.gap_or_line_end("2.6/2")?;
        }
        *element = input.number("2.6/2", "a matrix element")?;
    }
    input.line_end("2.0/2")?;
    Ok(ColorMatrix(elements))
}

/// Returns the rows for red, green and blue of a column-major matrix (clause 2.6/3, ruling `lum-major`).
#[must_use]
pub fn column_major_rows(ColorMatrix(m): &ColorMatrix) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|row| [m[row], m[4 + row], m[8 + row], m[12 + row]])
}

/// Returns the rows for red, green and blue of a row-major matrix (alternative to ruling `lum-major`).
#[must_use]
pub fn row_major_rows(ColorMatrix(m): &ColorMatrix) -> [[f64; 4]; 3] {
    [0, 4, 8].map(|row| [m[row], m[row + 1], m[row + 2], m[row + 3]])
}
