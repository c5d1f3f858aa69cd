//! §2.3 Image Size
//!
//! Width, then height, in ASCII (clause 2.3/1), separated by spaces or a line end (clause 2.3/2).
//!
//! ```text
//! 36 34 30 0A 34 38 30 0A        640 and 480, on separate lines
//! 36 34 30 20 34 38 30 20 0A     the same on one line, with an optional space before the line feed
//! ```
//!
//! Format notes
//! - HP's programs write the two numbers on separate lines. The text first shows them on one line. Both are accepted.
//! - A size without texels is rejected (ruling `dimensions`).
//! - A token that is not a decimal number violates clause 2.3/1. A number below 1 or above 2³² − 1 violates clause 2.3/3.
//! - No file needs a number above 2³² − 1. A decoder that lets it wrap around reads 4294967297 as 1.
//! - Both numbers may be as large as 2³² − 1, and their product may exceed the available memory. Do not allocate
//!   memory for texels here: compare the size first with the rest of the file, then with the limits of the caller.

use crate::error::Result;
use crate::input::Input;
use crate::types::Size;

pub(super) fn read(input: &mut Input) -> Result<Size> {
    // size-spelling: two numbers are separated by one or more spaces, or by one line end.
    let width = read_positive(input, "a width of at least 1")?;
    input.gap_or_line_end("2.3/2")?;
    let height = read_positive(input, "a height of at least 1")?;
    input.line_end("2.0/2")?;
    Ok(Size { width, height })
}

/// Reads one of the two numbers, each of which must be at least 1 (ruling `dimensions`).
fn read_positive(input: &mut Input, name: &'static str) -> Result<u32> {
    let too_small = input.unexpected("2.3/3", name);
    let too_large = input.unexpected("2.3/3", "a number of at most 4294967295");
    let rest = input.rest();
    let is_negative = rest.starts_with(b"-");
    let unsigned = rest.strip_prefix(b"+").or(rest.strip_prefix(b"-"));
    let number = unsigned.unwrap_or(rest);
    let digits = number
        .iter()
        .take_while(|byte| byte.is_ascii_digit())
        .count();
    let end = input.at() + rest.len() - number.len() + digits;
    match input.integer("2.3/1", name) {
        Ok(0) => Err(too_small),
        // The token is a decimal number, and its value does not fit in a `u32`.
        Err(_) if input.at() == end && digits > 0 => match is_negative {
            true => Err(too_small),
            false => Err(too_large),
        },
        read => read,
    }
}
