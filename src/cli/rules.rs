//! Clauses and rulings as text, for every suite.

use std::fmt::Write;

use ptm_conform::suite::clauses::{Clause, Ruling};

/// Returns a clause with its ruling, and why it is not tested if it is not; `untested` begins that reason.
pub fn rule_to_text(clause: &Clause, untested: &str) -> String {
    let mut text = format!("{}: {}", clause.id, clause.rule);
    if let Some(ruling) = &clause.ruling {
        let _ = write!(text, " Ruling: {ruling}.");
    }
    if let Some(why) = &clause.why {
        let _ = write!(text, " Not tested: {untested}{why}.");
    }
    text + "\n"
}

/// Returns the other correct readings of a ruling, and its evidence.
pub fn evidence_to_text(ruling: &Ruling) -> String {
    let also = ruling.also.iter();
    let also: String = also.map(|also| format!("  also right: {also}\n")).collect();
    format!("{also}  evidence: {}\n", ruling.evidence.trim())
}
