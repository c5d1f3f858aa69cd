//! §2.3 Image Size
//!
//! Width, then height, in ASCII (clause 2.3/1); a line end may stand between them (clause 2.3/2).
//!
//! Format notes
//! - HP's own programs write two lines; the text's first form is one line. Both are read.
//! - A size without texels is refused (ruling `dimensions`).

use super::Input;
use crate::error::Result;
use crate::ptm::Size;

pub(super) fn read(input: &mut Input) -> Result<Size> {
    let width = positive(input, "a width of at least 1")?;
    input.gap_or_line_end("2.3/2")?;
    let height = positive(input, "a height of at least 1")?;
    input.line_end("2.0/2")?;
    Ok(Size { width, height })
}

fn positive(input: &mut Input, name: &'static str) -> Result<u32> {
    let refused = input.wrong("2.3/3", name);
    match input.integer("2.3/1", name)? {
        0 => Err(refused),
        value => Ok(value),
    }
}
