//! §2.5 Lookup Table
//!
//! The number of entries (clause 2.5/2), then the entries without separators (clause 2.5/3): six coefficients each
//! (clause 2.5/4), followed by a color in `PTM_C_LUT` (clause 2.5/5).
//!
//! ```text
//! 32 20 4E 5F 4C 55 54 5F 45 4E 54 52 49 45 53 0A     2 N_LUT_ENTRIES
//! 01 02 03 04 05 06                                   entry 0: a0 … a5
//! 0B 0C 0D 0E 0F 10                                   entry 1
//! 01 00 01 …                                          indices (§2.8): entries 1, 0, 1
//! ```
//!
//! Format notes
//! - The text shows the count as two words and does not specify which of them is literal. `256 N_LUT_ENTRIES`, `256`
//!   and `nentries 256` are unambiguous, so all three are accepted (ruling `lut-count`).
//! - The indices directly follow the table (ruling `lut-newline`).
//! - The table is not padded to 256 entries.
//! - A count of 0 is accepted, and then every index is out of range (ruling `lut-range`). A count above 65,536 is
//!   accepted as well, although two bytes cannot index the last entries (ruling `lut-huge`).

use crate::error::{Error, Kind, Result};
use crate::input::Input;
use crate::parts::LookupTable;
use crate::reading::Reading;
use crate::types::Format;

pub(super) fn read<'a>(
    format: Format,
    input: &mut Input<'a>,
    reading: &Reading,
) -> Result<LookupTable<'a>> {
    let entries = (reading.entry_count)(input)?;
    let entry_size = format.entry_size();
    let bytes = input.take(
        "2.5/3",
        "the table's entries",
        entries as u64 * entry_size as u64,
    )?;
    // lut-newline
    (reading.after_table)(input)?;
    Ok(LookupTable {
        entries,
        entry_size,
        bytes,
    })
}

/// Reads `256 N_LUT_ENTRIES`, `256` or `nentries 256` on a separate line (clause 2.5/2, ruling `lut-count`).
///
/// # Errors
/// Returns the violated clause, the byte offset, and what was found there.
pub fn read_entry_count(input: &mut Input) -> Result<usize> {
    // lut-count: a keyword cannot start with a digit or a sign, so the first bytes distinguish the spellings.
    let keyword_first = input.rest().starts_with(b"nentries ");
    if keyword_first {
        input.word("2.5/2", "nentries")?;
        input.gap("2.5/2")?;
    }
    let entries: u32 = input.integer("2.5/2", "the number of entries")?;
    if !keyword_first && !input.at_line_end() {
        input.gap("2.5/2")?;
        input.word("2.5/2", "N_LUT_ENTRIES")?;
    }
    input.line_end("2.0/2")?;
    Ok(entries as usize)
}

/// Reads nothing between the table and the indices (ruling `lut-newline`).
#[allow(clippy::unnecessary_wraps)] // the alternative can fail
///
/// # Errors
/// Never returns an error.
pub fn read_no_separator(_: &mut Input) -> Result<()> {
    Ok(())
}

/// Reads one line feed between the table and the indices (alternative to ruling `lut-newline`).
///
/// # Errors
/// Returns an error if no line feed follows the table.
pub fn read_newline_separator(input: &mut Input) -> Result<()> {
    match input.take("2.5/3", "a line end after the table", 1)? {
        b"\n" => Ok(()),
        other => Err(Error::new(
            "2.5/3",
            input.at() - 1,
            Kind::Expected {
                what: "a line end after the table",
                found: other.escape_ascii().to_string(),
            },
        )),
    }
}
