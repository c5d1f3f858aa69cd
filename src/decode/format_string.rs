//! §2.2 Format String
//!
//! The second line is one of nine names (clause 2.2/1).

use super::Input;
use crate::error::Result;
use crate::ptm::Format;

pub(super) fn read(input: &mut Input) -> Result<Format> {
    let unknown = input.wrong("2.2/1", "the name of a format");
    let name = input.token("2.2/1", "the name of a format")?;
    let format = Format::ALL
        .into_iter()
        .find(|format| format.name().as_bytes() == name)
        .ok_or(unknown)?;
    input.line_end("2.0/2")?;
    Ok(format)
}
