//! Looks up table entries by index.
//!
//! Valid indices are 1 to 65535. The fallback entry is entry 1 (R-RST-02, R-RST-03).
//!
//! Format notes
//! - An index without an entry selects entry 1. If entry 1 is undefined, the fallback values are used (ruling `undefined-entry`).

use super::entry::{Entry, Table};
use super::{no_value::NoValue, rules::Rules};

/// Looks up the entry for `index` in `table`.
///
/// # Errors
/// Returns [`NoValue::OutOfRange`] if the index is not in 1 … 65535 (R-RST-02).
pub fn resolve(table: &Table, index: i64, rules: &Rules) -> Result<Entry, NoValue> {
    if !(rules.is_valid_index)(index) {
        return Err(NoValue::OutOfRange("index-out-of-range"));
    }
    let entry = table.get(&index).cloned();
    Ok(entry.unwrap_or_else(|| (rules.undefined_entry)(table, rules)))
}

/// Returns true if the index is from 1 to 65535 (R-RST-02).
pub fn is_valid_index(index: i64) -> bool {
    (1..=65535).contains(&index)
}

/// Returns entry 1 (R-RST-03), or the fallback values if entry 1 is undefined (ruling `undefined-entry`).
pub fn entry_one_or_fallback(table: &Table, rules: &Rules) -> Entry {
    table.get(&1).cloned().unwrap_or_else(rules.fallback_values)
}
