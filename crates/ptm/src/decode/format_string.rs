//! §2.2 Format String
//!
//! The second line is one of nine names (clause 2.2/1). It determines the number of values per texel and what follows the biases:
//!
//! ```text
//! PTM_FORMAT_RGB                              three blocks of coefficients (§2.7.1)                      18
//! PTM_FORMAT_LUM                              a color matrix (§2.6), one block (§2.7.2)                   8
//! PTM_FORMAT_LRGB                             a block of coefficients, a block of colors (§2.7.3)         9
//! PTM_FORMAT_PTM_LUT                          a table (§2.5), indices and a block of colors (§2.8.1)      9
//! PTM_FORMAT_PTM_C_LUT                        a table with the colors in it, indices (§2.8.2)             9
//! PTM_FORMAT_JPEG_RGB, PTM_FORMAT_JPEGLS_RGB        lists and 18 compressed planes (§2.9)                18
//! PTM_FORMAT_JPEG_LRGB, PTM_FORMAT_JPEGLS_LRGB      lists and 9 compressed planes (§2.9)                  9
//! ```
//!
//! Format notes
//! - Several names share prefixes and suffixes (`…_RGB`, `…_LRGB`, `…_JPEG_RGB`), so compare the whole token.
//! - Names are uppercase. Any other spelling is invalid.

use crate::error::Result;
use crate::input::Input;
use crate::types::Format;

pub(super) fn read(input: &mut Input) -> Result<Format> {
    let unknown = input.unexpected("2.2/1", "the name of a format");
    let name = input.token("2.2/1", "the name of a format")?;
    let format = Format::ALL
        .into_iter()
        .find(|format| format.name().as_bytes() == name)
        .ok_or(unknown)?;
    input.line_end("2.0/2")?;
    Ok(format)
}
