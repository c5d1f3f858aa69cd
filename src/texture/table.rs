//! The table: which entry an index names.
//!
//! Valid indices are 1 to 65535; the fallback entry is entry 1 (R-RST-02, R-RST-03).
//!
//! Format notes
//! - An index without an entry means entry 1; if that is not there either, the fallback values (ruling `undefined-entry`).

use super::entry::{Entry, Table};
use super::no_value::NoValue;
use super::rules::Rules;

/// The entry that `index` names in `table`.
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

/// 1 to 65535 (R-RST-02).
pub(crate) fn valid_index(index: i64) -> bool {
    (1..=65535).contains(&index)
}

/// Entry 1 (R-RST-03); without one, the fallback values (ruling `undefined-entry`).
pub(crate) fn entry_one(table: &Table, rules: &Rules) -> Entry {
    table.get(&1).cloned().unwrap_or_else(rules.fallback_values)
}
