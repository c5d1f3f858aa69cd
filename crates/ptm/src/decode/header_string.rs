//! §2.1 Header String
//!
//! The first line is `PTM_1.2` (clause 2.1/1).
//!
//! ```text
//! 50 54 4D 5F 31 2E 32 0A        PTM_1.2, line feed
//! 50 54 4D 5F 31 2E 32 20 0A     the same with the optional space before a line feed (clause 2.0/2)
//! ```
//!
//! Format notes
//! - `PTM_1.1` files exist. They interleave nine bytes per texel and must not be decoded as 1.2 (ruling `version`).
//! - A carriage return before the line feed is rejected (ruling `header-blanks`). A file that was transferred as text also has a
//!   carriage return before every 0x0A in its payload, so its image is destroyed.
//! - Only this line identifies a file as a PTM. The extension of the file name is ignored.

use crate::error::Result;
use crate::input::Input;

/// Reads the first line (clause 2.1/1).
pub(super) fn read(input: &mut Input) -> Result<()> {
    // A token ends at a space or a line feed, so "PTM_1.25" does not match PTM_1.2.
    input.word("2.1/1", "PTM_1.2")?;
    input.line_end("2.0/2")
}
