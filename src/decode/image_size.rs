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
//! - A token that is not a number in digits breaks clause 2.3/1; a number below 1 or beyond 32 bits breaks clause 2.3/3.
//! - No file needs a number beyond 32 bits; a reader that lets one wrap around reads 4294967297 as 1.
//! - Both numbers may be as large as 2³² − 1, and their product larger than any memory. No memory is allocated for texels
//!   here: the size is first compared with the rest of the file, then with the limits that the caller set.

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
    let too_small = input.wrong("2.3/3", name);
    let too_large = input.wrong("2.3/3", "a number of at most 4294967295");
    let digits = input.rest().iter().take_while(|byte| byte.is_ascii_digit());
    let end = input.at() + digits.count();
    match input.integer("2.3/1", name) {
        Ok(0) => Err(too_small),
        // A token of digits alone was read to its end, and its value does not fit in a `u32`; an empty token begins at its end.
        Err(error) if input.at() == end && error.offset() < end => Err(too_large),
        read => read,
    }
}
