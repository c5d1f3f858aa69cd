//! §2.3 Image Size
//!
//! Width, then height, in ASCII (clause 2.3/1); a line end may stand between them (clause 2.3/2).
//!
//! ```text
//! 36 34 30 0A 34 38 30 0A        640 and 480, a line each
//! 36 34 30 20 34 38 30 20 0A     the same on one line, with the optional space at its end
//! ```
//!
//! Format notes
//! - HP's own programs write two lines; the text's first form is one line. Both are read.
//! - A size without texels is refused (ruling `dimensions`).
//! - Both numbers may be as large as 2³² − 1, and their product larger than any memory. No room is made for texels here:
//!   what they need is first compared with what is left of the file, then with the limits the caller set.

use crate::error::Result;
use crate::input::Input;
use crate::ptm::Size;

pub(super) fn read(input: &mut Input) -> Result<Size> {
    // size-spelling: one or more spaces separate two numbers, or one line end; `input` reads both.
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
