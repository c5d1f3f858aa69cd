//! `ptm-conform explain`: what is known of a case, a clause, a ruling, a misreading or a code.

use std::fmt::Write as _;

use clap::Args;

use super::Outcome;
use super::output::print;
#[cfg(unix)]
use super::texture;
use ptm_conform::harness::cases::{self, Suite};
use ptm_conform::harness::{corpus, misreadings};
use ptm_conform::tools::lint::codes::{self, Code};

/// Explain a case, a clause, a ruling, a misreading or a code of lint.
#[derive(Args)]
pub struct ExplainArgs {
    /// An id such as hand-rgb-blocks, 2.4/8, lut-count, rows-top-down or PTM-W102.
    id: String,
}

/// Explains it, or says what may have been meant.
pub fn run(args: &ExplainArgs) -> Outcome {
    let Some(text) = explain(&args.id)? else {
        return Err(unknown(&args.id, &Suite::load()?)?);
    };
    print(&text);
    Ok(0)
}

/// What is known under that id.
fn explain(id: &str) -> Result<Option<String>, String> {
    let suite = Suite::load()?;
    let clauses = cases::clauses()?;
    let mut text = String::new();
    if let Some(case) = suite.case(id) {
        explain_case(case, &mut text).map_err(|error| error.to_string())?;
    }
    for clause in clauses.iter().filter(|clause| {
        clause.id == id
            || clause.id.starts_with(&format!("{id}/"))
            || clause.id.starts_with(&format!("{id}."))
    }) {
        let cases: Vec<&str> = suite
            .cases
            .iter()
            .filter(|case| case.clauses.contains(&clause.id))
            .map(|case| case.id.as_str())
            .collect();
        let ruling = clause
            .ruling
            .as_ref()
            .map(|ruling| format!(" Ruling: {ruling}."))
            .unwrap_or_default();
        let why = clause
            .why
            .as_ref()
            .map(|why| format!(" Not tested: it {why}."))
            .unwrap_or_default();
        let _ = writeln!(
            text,
            "clause {}: {}{ruling}{why}\n  {} cases: {}",
            clause.id,
            clause.rule,
            cases.len(),
            abbreviated(&cases)
        );
    }
    for ruling in cases::rulings()?.iter().filter(|ruling| ruling.id == id) {
        let _ = writeln!(
            text,
            "ruling {} ({:?}), clauses {}",
            ruling.id,
            ruling.kind,
            ruling.clauses.join(", ")
        );
        let _ = writeln!(
            text,
            "  open: {}\n  the reference: {}",
            ruling.question.trim(),
            ruling.reading.trim()
        );
        for also in &ruling.also {
            let _ = writeln!(text, "  also right: {also}");
        }
        let _ = writeln!(text, "  evidence: {}", ruling.evidence.trim());
    }
    if let Some(misreading) = misreadings::named(id) {
        let _ = writeln!(
            text,
            "misreading {} of clause {}: the decoder {}.",
            misreading.slug, misreading.clause, misreading.effect
        );
        let _ = writeln!(text, "  To mend it: {}.", misreading.mend);
        if let Some(clause) = clauses.iter().find(|clause| clause.id == misreading.clause) {
            let _ = writeln!(text, "  The clause says: {}", clause.rule);
        }
    }
    if let Some(known) = Code::named(&id.to_uppercase()) {
        text += &code(known, &suite);
    }
    #[cfg(unix)]
    text.push_str(&texture::explain(id)?);
    Ok(Some(text).filter(|text| !text.is_empty()))
}

fn explain_case(case: &cases::Case, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "case {} (clauses {}): {}",
        case.id,
        case.clauses.join(", "),
        case.because
    )?;
    writeln!(out, "  expected: {}", case.expect.name())?;
    if let (Some(twin), Some(damage)) = (&case.twin_of, case.damage()) {
        writeln!(out, "  it is {twin}, in which {}", damage.effect)?;
    }
    let views: Vec<String> = case.views.iter().map(ToString::to_string).collect();
    writeln!(
        out,
        "  asked in the first of these views that the decoder offers: {}",
        views.join(", ")
    )?;
    if let Some(ruling) = &case.ruling {
        writeln!(out, "  ruling: {ruling}")?;
    }
    let built = case.build(cases::TableSpelling::default());
    writeln!(
        out,
        "  file: {} bytes, sha-256 {}",
        built.file.len(),
        corpus::sha256(&built.file)
    )?;
    for (is, bytes) in case.pieces() {
        writeln!(out, "    {is:<40} {}", bytes.escape_ascii())?;
    }
    for field in &built.fields {
        let bytes = &built.file[field.range.clone()];
        let shown = bytes[..bytes.len().min(24)].escape_ascii();
        let more = if bytes.len() > 24 { "…" } else { "" };
        writeln!(
            out,
            "    byte {:>5}  {:<22} {:<8} {shown}{more}",
            field.range.start, field.name, field.clause
        )?;
    }
    Ok(())
}

/// Nothing is called that; what may have been meant.
fn unknown(id: &str, suite: &Suite) -> Result<String, String> {
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
fn code(code: &Code, suite: &Suite) -> String {
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
