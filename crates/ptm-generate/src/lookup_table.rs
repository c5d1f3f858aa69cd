//! §2.5 Lookup Table
//!
//! The count in one of its three spellings (ruling `lut-count`), the entries, and optionally a line end (ruling `lut-newline`).

use super::spelling::{Count, Line};
use super::{model::Model, output::Output};

pub fn write(model: &Model, out: &mut Output) {
    if out.spelling.count == Count::WordNumber {
        out.token("2.5/2", "count keyword", "nentries");
        out.gap();
    }
    out.token("2.5/2", "count", &model.entries().to_string());
    if out.spelling.count == Count::NumberWord {
        out.gap();
        out.token("2.5/2", "count keyword", "N_LUT_ENTRIES");
    }
    out.line_end(Line::Count);
    out.put("2.5/3", "table", &model.table);
    if out.spelling.newline_after_table {
        out.put("2.5/3", "newline after the table", b"\n");
    }
}
