//! The table: lookup of an entry by its index.
//!
//! Valid indices are 1 to 65535; the fallback entry is entry 1 (R-RST-02, R-RST-03).
//!
//! Format notes
//! - An index without an entry selects entry 1; without entry 1, the fallback values (ruling `undefined-entry`).

use super::entry::{Entry, Table};
use super::no_value::NoValue;
use super::rules::Rules;

/// Returns the entry for `index` in `table`.
///
/// # Errors
/// [`NoValue::OutOfRange`] outside 1 … 65535 (R-RST-02).
pub fn resolve(table: &Table, index: i64, rules: &Rules) -> Result<Entry, NoValue> {
    if !(rules.valid_index)(index) {
        return Err(NoValue::OutOfRange("index-out-of-range"));
    }
    let entry = table.get(&index).cloned();
    Ok(entry.unwrap_or_else(|| (rules.undefined_entry)(table, rules)))
}

/// Returns true for 1 to 65535 (R-RST-02).
pub(crate) fn valid_index(index: i64) -> bool {
    (1..=65535).contains(&index)
}

/// Returns entry 1 (R-RST-03); without one, the fallback values (ruling `undefined-entry`).
pub(crate) fn entry_one(table: &Table, rules: &Rules) -> Entry {
    table.get(&1).cloned().unwrap_or_else(rules.fallback_values)
}
