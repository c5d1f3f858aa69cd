//! A finding on disk: a complete case, its file, expected and received output, and an explanation.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;

use super::finding::{Explanation, Finding};
use ptm_suite::address::slug;
use ptm_suite::cases::{Built, TableSpelling};
use ptm_suite::compare::Expected;
use ptm_suite::protocol::frame::View;

/// Maximum number of bytes that are displayed for a field.
const MAX_BYTES: usize = 24;

/// Writes `NAME.yaml` (the case), `NAME.ptm`, `NAME.expected` and `NAME.received` (frames, if there are any), and `NAME.txt`
/// (cause, difference, annotated bytes) into `directory`. Returns `NAME`.
///
/// # Errors
/// Returns an error if a file cannot be written.
pub fn write(finding: &Finding, table: TableSpelling, directory: &Path) -> io::Result<String> {
    fs::create_dir_all(directory)?;
    let name: String = slug(&finding.cause.name()).chars().take(60).collect();
    let path = |suffix: &str| directory.join(format!("{name}.{suffix}"));
    let id = format!("found-{name}");
    let case = finding.small.cases(&id).map_err(io::Error::other)?.pop();
    let case = case.ok_or_else(|| io::Error::other("the case is empty"))?;
    let built = case.build(table);
    fs::write(path("ptm"), &built.file)?;
    let yaml = finding
        .small
        .to_yaml(&id, &cause_text(finding), misread_clause(finding));
    fs::write(path("yaml"), yaml)?;
    let view = finding.view.as_ref();
    let expected = view.and_then(|view| Expected::new(&built.values, view));
    if let Some(expected) = &expected {
        fs::write(path("expected"), expected.frame().to_bytes())?;
    }
    if let Some(received) = &finding.received {
        fs::write(path("received"), received.to_bytes())?;
    }
    fs::write(path("txt"), explanation(finding, &built, expected.as_ref()))?;
    Ok(name)
}

/// Describes the cause in a sentence.
#[must_use]
pub fn cause_text(finding: &Finding) -> String {
    match &finding.cause {
        Explanation::Misreading(suspects) => {
            let (effect, clause) = (suspects[0].effect, suspects[0].clause);
            format!("A decoder {effect} (clause {clause}).")
        }
        Explanation::Accepts(damage) => {
            format!("A decoder accepts a file with this fault: {damage}.")
        }
        Explanation::TimedOut(limit) => format!("A decoder {limit}."),
        Explanation::Other(symptom) => match &finding.diagnosis {
            Some(cause) => format!("A decoder {}{}.", cause.effect, cause.clause_text()),
            None => format!("A decoder fails: {symptom}."),
        },
    }
}

fn misread_clause(finding: &Finding) -> Option<&str> {
    match &finding.cause {
        Explanation::Misreading(suspects) => Some(suspects[0].clause),
        _ => finding.diagnosis.as_ref()?.misread_clause(),
    }
}

fn explanation(finding: &Finding, built: &Built, expected: Option<&Expected>) -> String {
    let mut out = format!("{}\n", cause_text(finding));
    if let Explanation::Misreading(suspects) = &finding.cause {
        let _ = writeln!(out, "Fix: {}.", suspects[0].fix);
        let others: Vec<&str> = suspects[1..].iter().map(|other| other.slug).collect();
        if !others.is_empty() {
            let others = others.join(", ");
            let _ = writeln!(out, "Indistinguishable causes: {others}.");
        }
    }
    if let Some(cause) = &finding.diagnosis {
        let _ = writeln!(out, "Fix: {}.", cause.fix);
    }
    let view = finding.view.as_ref().map_or(String::new(), View::to_string);
    let (original, small) = (&finding.original, &finding.small);
    let not_reduced =
        "; not reduced: the time limit was reached, or no smaller file failed in the same way";
    let reduced = if original == small {
        not_reduced
    } else {
        ", reduced here"
    };
    let _ = writeln!(
        out,
        "\nRequested view: {view}. First seen in a random file of {}x{}{reduced}.",
        original.width, original.height
    );
    let images = expected.zip(finding.received.as_ref());
    let _ = match images.and_then(|(expected, received)| expected.compare(received)) {
        Some(difference) => writeln!(out, "{difference}"),
        None => writeln!(out, "The decoder: {}", finding.answer),
    };
    out + &annotate_bytes(built)
}

/// Formats the file field by field, or its first bytes if it has no fields.
fn annotate_bytes(built: &Built) -> String {
    let mut out = format!("\nFile, {} bytes:\n", built.file.len());
    for field in &built.fields {
        let bytes = &built.file[field.range.clone()];
        let dots = if bytes.len() > MAX_BYTES { "…" } else { "" };
        let _ = writeln!(
            out,
            "  byte {:>6}  {:<20} {:<8} {}{dots}",
            field.range.start,
            field.name,
            field.clause,
            bytes[..bytes.len().min(MAX_BYTES)].escape_ascii()
        );
    }
    if built.fields.is_empty() {
        let start = &built.file[..built.file.len().min(400)];
        let _ = writeln!(out, "  {}", start.escape_ascii());
    }
    out
}
