//! §2.1 Header String
//!
//! The first line is `PTM_1.2` (clause 2.1/1).
//!
//! Format notes
//! - `PTM_1.1` files exist; they interleave nine bytes for each texel and must not be read as 1.2 (ruling `version`).

use super::Input;
use crate::error::Result;

pub(super) fn read(input: &mut Input) -> Result<()> {
    input.word("2.1/1", "PTM_1.2")?;
    input.line_end("2.0/2")
}
