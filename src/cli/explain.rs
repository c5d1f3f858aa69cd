//! What `ptm-conform explain` says of codes of lint, and of ids that nobody knows.

use std::fmt::Write as _;

use ptm_conform::harness::cases::{self, Suite};
use ptm_conform::harness::misreadings;
use ptm_conform::tools::lint::codes::{self, Code};

/// Nothing is called that; what may have been meant.
pub fn unknown(id: &str, suite: &Suite) -> Result<String, String> {
    let (clauses, rulings) = (cases::clauses()?, cases::rulings()?);
    let known = suite
        .cases
        .iter()
        .map(|case| case.id.as_str())
        .chain(clauses.iter().map(|clause| clause.id.as_str()))
        .chain(rulings.iter().map(|ruling| ruling.id.as_str()))
        .chain(misreadings::all().map(|misreading| misreading.slug))
        .chain(codes::ALL.iter().map(|code| code.id));
    let near = nearest(id, known);
    let hint = match near.is_empty() {
        true => "a section such as 2.8 lists its clauses, and its clauses their cases".to_owned(),
        false => format!("did you mean {}?", near.join(" or ")),
    };
    Ok(format!(
        "no case, clause, ruling, misreading or code is called {id:?}; {hint}"
    ))
}

/// At most three names that are nearly `id`, or go on where it ends, the nearest first.
fn nearest<'a>(id: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let asked = id.to_lowercase();
    let mut near: Vec<(f64, &str)> = known
        .map(|name| {
            let likeness = strsim::jaro_winkler(&asked, &name.to_lowercase());
            let within = asked.len() >= 4 && name.to_lowercase().contains(&asked);
            (if within { likeness.max(0.9) } else { likeness }, name)
        })
        .filter(|(likeness, _)| *likeness >= 0.88)
        .collect();
    near.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
    near.dedup_by_key(|(_, name)| *name);
    near.into_iter().take(3).map(|(_, name)| name).collect()
}

/// What a code of lint means, and which cases provoke it.
pub fn code(code: &Code, suite: &Suite) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "code {} ({}, clause {}): {}",
        code.id,
        code.severity.name(),
        code.clause,
        code.says
    );
    if !code.mend.is_empty() {
        let _ = writeln!(out, "  To mend it: {}", code.mend);
    }
    let provokes = |case: &&cases::Case| {
        let damage = case.damage().map(|damage| damage.name);
        code.provoked_by.contains(&case.id.as_str())
            || damage.is_some_and(|damage| code.provoked_by.contains(&damage))
    };
    let ids: Vec<&str> = suite
        .cases
        .iter()
        .filter(provokes)
        .map(|case| case.id.as_str())
        .collect();
    let _ = writeln!(
        out,
        "  {} cases provoke it: {}",
        ids.len(),
        abbreviated(&ids)
    );
    out
}

fn abbreviated(ids: &[&str]) -> String {
    let more = if ids.len() > 6 { ", …" } else { "" };
    ids[..ids.len().min(6)].join(", ") + more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_nearly_right_are_suggested() {
        let suite = Suite::load().expect("the suite loads");
        for (asked, meant) in [
            ("hand-rgb-block", "hand-rgb-blocks"),
            ("lut-cuont", "lut-count"),
            ("row-top-down", "rows-top-down"),
            ("ptm-e07", "PTM-E070"),
        ] {
            let said = unknown(asked, &suite).expect("the clauses load");
            assert!(said.contains(meant), "{asked}: {said}");
        }
        let said = unknown("zzz", &suite).expect("the clauses load");
        assert!(said.contains("a section such as 2.8"), "{said}");
    }
}
