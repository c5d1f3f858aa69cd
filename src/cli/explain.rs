//! `ptm-conform explain`: information about a case, a clause, a ruling, a misreading or a code; or about all of them.

#[cfg(unix)]
use std::collections::HashMap;
use std::fmt::Write as _;
#[cfg(unix)]
use std::time::Duration;

use clap::Args;

use super::CommandResult;
use super::links::page_line;
use super::names::nearest;
#[cfg(unix)]
use super::output::{bar, jobs};
use super::rules::{evidence_to_text, rule_to_text};
use super::terminal::show;
use ptm_conform::kit::digest::sha256;
use ptm_conform::misreadings::{self, Misreading, writing};
#[cfg(unix)]
use ptm_conform::session::outcome::Outcome;
#[cfg(unix)]
use ptm_conform::strength::matrix::ask_all;
use ptm_conform::suite::address;
use ptm_conform::suite::cases::{self, Case, Suite};
use ptm_conform::suite::clauses::{self, Clause, Ruling};
use ptm_conform::suite::name::SuiteName;
#[cfg(unix)]
use ptm_conform::suite::test_case::TestCase;
use ptm_conform::tools::lint::codes::{self, Code};

/// Explain a case, a clause, a ruling, a misreading or a lint code.
#[derive(Args)]
pub struct ExplainArgs {
    /// An id such as hand-rgb-blocks, 2.4/8, lut-count, rows-top-down or PTM-W102; without one, all ids are listed.
    id: Option<String>,
}

/// Explains an id, or suggests similar ones.
pub fn run(args: &ExplainArgs) -> CommandResult {
    let Some(id) = &args.id else {
        show(&list(&Suite::load()?)?);
        return Ok(0);
    };
    let Some(text) = explain(id)? else {
        return Err(unknown(id, &Suite::load()?)?.into());
    };
    show(&text);
    Ok(0)
}

/// Describes a request of `check-writer`.
#[cfg(unix)]
fn explain_request(id: &str) -> Result<String, String> {
    let suite = Suite::of_requests()?;
    let Some(case) = suite.case(id) else {
        return Ok(String::new());
    };
    let request = case.request();
    Ok(format!(
        "request {id} to writers ({})\n  {}\n  expected: {}\n{}  planes: {} bytes, the top row first; they begin {}\n",
        case.clauses.join(", "),
        case.because,
        case.expectation(),
        request.header.to_json(),
        request.samples.len(),
        request.samples[..request.samples.len().min(18)]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect::<Vec<_>>()
            .join(" ")
    ))
}

/// Lists all ids except those of cases.
fn list(suite: &Suite) -> Result<String, String> {
    let section = |clause: &str| clause.split('/').next().unwrap_or_default().to_owned();
    let clauses = clauses::clauses()?;
    let mut sections: Vec<String> = clauses.iter().map(|clause| section(&clause.id)).collect();
    sections.dedup();
    let mut text = format!(
        "{} cases: a section below lists those about it\n\n{} clauses, in sections:\n",
        suite.cases.len(),
        clauses.len()
    );
    for of in &sections {
        let count = |ids: &[String]| ids.iter().any(|clause| section(clause) == *of);
        let clauses = clauses.iter().filter(|clause| section(&clause.id) == *of);
        let cases = suite.cases.iter().filter(|case| count(&case.clauses));
        let _ = writeln!(
            text,
            "  {of:<7} {:>3} clauses, {:>4} cases",
            clauses.count(),
            cases.count()
        );
    }
    let rulings = clauses::rulings()?;
    let names: Vec<&str> = rulings.iter().map(|ruling| ruling.id.as_str()).collect();
    let _ = writeln!(text, "\n{} rulings:\n  {}", names.len(), names.join(", "));
    let _ = writeln!(text, "\n{} misreadings:", misreadings::all().count());
    for of in &sections {
        let about = misreadings::all().filter(|misreading| section(misreading.clause) == *of);
        let slugs: Vec<&str> = about.map(|misreading| misreading.slug).collect();
        if !slugs.is_empty() {
            let _ = writeln!(text, "  {of}: {}", slugs.join(", "));
        }
    }
    let codes: Vec<&str> = codes::ALL.iter().map(|code| code.id).collect();
    let _ = writeln!(
        text,
        "\n{} codes of lint:\n  {}",
        codes.len(),
        codes.join(", ")
    );
    Ok(text)
}

/// Describes an id, if it is known.
fn explain(id: &str) -> Result<Option<String>, String> {
    let suite = Suite::load()?;
    let clauses = clauses::clauses()?;
    let mut text = String::new();
    if let Some(case) = suite.case(id) {
        text += &explain_case(case);
        text += &page_line(SuiteName::Ptm.case_page(id));
    }
    #[cfg(unix)]
    text.push_str(&explain_request(id)?);
    let below = |clause: &&Clause| {
        let rest = clause.id.strip_prefix(id);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', '.']))
    };
    for clause in clauses.iter().filter(below) {
        text += &explain_clause(clause, &suite);
        if clause.id == id {
            text += &page_line(SuiteName::Ptm.clause_page(id));
        }
    }
    for ruling in clauses::rulings()?.iter().filter(|ruling| ruling.id == id) {
        text += &explain_ruling(ruling);
        text += &page_line(Some(SuiteName::Ptm.ruling_page(id)));
    }
    if let Some(misreading) = misreadings::named(id) {
        let clause = clauses.iter().find(|clause| clause.id == misreading.clause);
        text += &explain_misreading(misreading, clause);
        if let Some(mistake) = writing::named(id) {
            let _ = writeln!(
                text,
                "  A writer with this mistake {}.\n  Fix: {}.",
                mistake.effect, mistake.fix
            );
        }
        #[cfg(unix)]
        text.push_str(&shown_by(misreading, &suite)?);
        text += &page_line(Some(SuiteName::Ptm.misreading_page(id)));
    }
    if let Some(known) = Code::named(&id.to_uppercase()) {
        text += &explain_code(known, &suite);
        text += &page_line(Some(address::code(known.id)));
    }
    #[cfg(unix)]
    text.push_str(&super::texture::explain(id)?);
    Ok(Some(text).filter(|text| !text.is_empty()))
}

fn explain_clause(clause: &Clause, suite: &Suite) -> String {
    let about = |case: &&Case| case.clauses.contains(&clause.id);
    let cases = abbreviated(suite.cases.iter().filter(about), "cases");
    format!("clause {}  {cases}\n", rule_to_text(clause, "it "))
}

fn explain_ruling(ruling: &Ruling) -> String {
    let text = format!(
        "ruling {} ({:?}), clauses {}\n  open: {}\n  the reference: {}\n",
        ruling.id,
        ruling.kind,
        ruling.clauses.join(", "),
        ruling.question.trim(),
        ruling.reading.trim()
    );
    text + &evidence_to_text(ruling)
}

fn explain_misreading(misreading: &Misreading, clause: Option<&Clause>) -> String {
    let rule = clause.map(|clause| format!("  The clause says: {}\n", clause.rule));
    let readers: Vec<String> = misreading.seen.iter().map(ToString::to_string).collect();
    let seen = (!readers.is_empty()).then(|| format!("  Seen in: {}.\n", readers.join(", ")));
    format!(
        "misreading {} of clause {}: the decoder {}.\n  Fix: {}.\n{}{}",
        misreading.slug,
        misreading.clause,
        misreading.effect,
        misreading.fix,
        rule.unwrap_or_default(),
        seen.unwrap_or_default()
    )
}

/// Lists the cases that a decoder with this mistake fails, and its response to the smallest file among them.
#[cfg(unix)]
fn shown_by(misreading: &Misreading, suite: &Suite) -> Result<String, String> {
    let bar = bar(None, "{spinner} reading every case with this mistake");
    bar.enable_steady_tick(Duration::from_millis(200));
    let (run, _) = ask_all(suite, &[misreading], &[], jobs(None)?, &HashMap::new());
    bar.finish_and_clear();
    let failing: Vec<usize> = run.judgement.with(Outcome::Fail).collect();
    let size = |&place: &usize| {
        let spelling = cases::TableSpelling::default();
        suite.cases[place].build(spelling).file.len()
    };
    let Some((bytes, place)) = failing.iter().map(|place| (size(place), *place)).min() else {
        return Ok(String::new());
    };
    let case = &suite.cases[place];
    let judged = run.judgement.cases[place].as_ref();
    let view = run.observations[place].as_ref();
    Ok(format!(
        "  It fails {}\n  The smallest file that shows it has {bytes} bytes: ptm-conform generate --case {}\n    {}: {}\n    {}\n",
        abbreviated(failing.iter().map(|&place| &suite.cases[place]), "cases"),
        case.id,
        view.map_or_else(String::new, |observation| observation.view.to_string()),
        judged.map_or("", |judged| &judged.says),
        case.because
    ))
}

fn explain_case(case: &Case) -> String {
    let (id, clauses, because) = (&case.id, case.clauses.join(", "), &case.because);
    let views: Vec<String> = case.views.iter().map(ToString::to_string).collect();
    let built = case.build(cases::TableSpelling::default());
    let mut lines = vec![
        format!("case {id} (clauses {clauses}): {because}"),
        format!("  expected: {}", case.expect.name()),
    ];
    if let (Some(twin), Some(damage)) = (&case.twin_of, case.damage()) {
        lines.push(format!("  it is {twin}, in which {}", damage.effect));
    }
    lines.push(format!(
        "  asked in the first of these views that the decoder offers: {}",
        views.join(", ")
    ));
    lines.extend(
        case.ruling
            .iter()
            .map(|ruling| format!("  ruling: {ruling}")),
    );
    let (size, digest) = (built.file.len(), sha256(&built.file));
    lines.push(format!("  file: {size} bytes, sha-256 {digest}"));
    let pieces = case.pieces();
    let pieces = pieces
        .iter()
        .map(|(is, bytes)| format!("    {is:<40} {}", bytes.escape_ascii()));
    lines.extend(pieces);
    lines.extend(built.fields.iter().map(|field| {
        let bytes = &built.file[field.range.clone()];
        let shown = bytes[..bytes.len().min(24)].escape_ascii();
        let more = if bytes.len() > 24 { "…" } else { "" };
        format!(
            "    byte {:>5}  {:<22} {:<8} {shown}{more}",
            field.range.start, field.name, field.clause
        )
    }));
    lines.join("\n") + "\n"
}

/// Returns the message for an unknown id, with similar ids.
fn unknown(id: &str, suite: &Suite) -> Result<String, String> {
    let (clauses, rulings) = (clauses::clauses()?, clauses::rulings()?);
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

/// Describes a lint code, and the cases that provoke it.
fn explain_code(code: &Code, suite: &Suite) -> String {
    let provokes = |case: &&Case| {
        let damage = case.damage().map(|damage| damage.name.as_str());
        code.is_provoked_by(&case.id) || damage.is_some_and(|damage| code.is_provoked_by(damage))
    };
    let fix = match code.fix {
        "" => String::new(),
        fix => format!("  Fix: {fix}\n"),
    };
    format!(
        "code {} ({}, clause {}): {}\n{fix}  {}\n",
        code.id,
        code.severity.name(),
        code.clause,
        code.says,
        abbreviated(suite.cases.iter().filter(provokes), "cases provoke it")
    )
}

/// Returns the number of cases, and the first six.
fn abbreviated<'a>(cases: impl Iterator<Item = &'a Case>, what: &str) -> String {
    let ids: Vec<&str> = cases.map(|case| case.id.as_str()).collect();
    let more = if ids.len() > 6 { ", …" } else { "" };
    let first = ids[..ids.len().min(6)].join(", ");
    format!("{} {what}: {first}{more}", ids.len())
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
