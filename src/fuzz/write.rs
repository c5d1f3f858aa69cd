//! A find on disk: a complete case, its file, expected and received output, and an explanation.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;

use super::find::{Explanation, Find};
use crate::protocol::frame::View;
use crate::suite::address::slug;
use crate::suite::cases::{Built, TableSpelling};
use crate::suite::compare::Expected;

/// Maximum number of bytes of a field that are shown.
const MAX_SHOWN: usize = 24;

/// Writes `NAME.yaml` (the case), `NAME.ptm`, `NAME.expected` and `NAME.received` (frames, if there are any), and `NAME.txt`
/// (cause, difference, annotated bytes) into `directory`. Returns `NAME`.
///
/// # Errors
/// Returns an error if a file cannot be written.
pub fn write(find: &Find, table: TableSpelling, directory: &Path) -> io::Result<String> {
    fs::create_dir_all(directory)?;
    let name: String = slug(&find.cause.name()).chars().take(60).collect();
    let at = |suffix: &str| directory.join(format!("{name}.{suffix}"));
    let id = format!("found-{name}");
    let case = find.small.cases(&id).map_err(io::Error::other)?.pop();
    let case = case.ok_or_else(|| io::Error::other("the case is empty"))?;
    let built = case.build(table);
    fs::write(at("ptm"), &built.file)?;
    fs::write(at("yaml"), find.small.to_yaml(&id, &because(find)))?;
    let view = find.view.as_ref();
    let expected = view.and_then(|view| Expected::new(&built.values, view));
    if let Some(expected) = &expected {
        fs::write(at("expected"), expected.frame().to_bytes())?;
    }
    if let Some(received) = &find.received {
        fs::write(at("received"), received.to_bytes())?;
    }
    fs::write(at("txt"), explanation(find, &built, expected.as_ref()))?;
    Ok(name)
}

/// Describes the cause in a sentence.
#[must_use]
pub fn because(find: &Find) -> String {
    let says = |effect: &str, clause: &str| format!("A decoder {effect} (clause {clause}).");
    match &find.cause {
        Explanation::Misreading(suspects) => says(suspects[0].effect, suspects[0].clause),
        Explanation::Accepts(damage) => {
            format!("A decoder accepts a file with this fault: {damage}.")
        }
        Explanation::Other(symptom) => match &find.diagnosis {
            Some(cause) => says(&cause.effect, &cause.clause),
            None => format!("A decoder fails: {symptom}."),
        },
    }
}

fn explanation(find: &Find, built: &Built, expected: Option<&Expected>) -> String {
    let mut out = format!("{}\n", because(find));
    if let Explanation::Misreading(suspects) = &find.cause {
        let _ = writeln!(out, "Fix: {}.", suspects[0].fix);
        let others: Vec<&str> = suspects[1..].iter().map(|also| also.slug).collect();
        if !others.is_empty() {
            let others = others.join(", ");
            let _ = writeln!(out, "No generated file distinguishes it from: {others}.");
        }
    }
    if let Some(cause) = &find.diagnosis {
        let _ = writeln!(out, "Fix: {}.", cause.fix);
    }
    let view = find.view.as_ref().map(View::to_string).unwrap_or_default();
    let (drawn, small) = (&find.drawn, &find.small);
    let not_reduced =
        "; not reduced: the time limit was reached, or no smaller file failed in the same way";
    let reduced = if drawn == small {
        not_reduced
    } else {
        ", reduced here"
    };
    let _ = writeln!(
        out,
        "\nRequested view: {view}. First seen in a random file of {}x{}{reduced}.",
        drawn.width, drawn.height
    );
    let images = expected.zip(find.received.as_ref());
    let _ = match images.and_then(|(expected, received)| expected.compare(received)) {
        Some(difference) => writeln!(out, "{difference}"),
        None => writeln!(out, "The decoder: {}", find.answer),
    };
    out + &annotated(built)
}

/// Formats the file field by field, or its first bytes if it has no fields.
fn annotated(built: &Built) -> String {
    let mut out = format!("\nThe file, {} bytes:\n", built.file.len());
    for field in &built.fields {
        let bytes = &built.file[field.range.clone()];
        let more = if bytes.len() > MAX_SHOWN { "…" } else { "" };
        let _ = writeln!(
            out,
            "  byte {:>6}  {:<20} {:<8} {}{more}",
            field.range.start,
            field.name,
            field.clause,
            bytes[..bytes.len().min(MAX_SHOWN)].escape_ascii()
        );
    }
    if built.fields.is_empty() {
        let start = &built.file[..built.file.len().min(400)];
        let _ = writeln!(out, "  {}", start.escape_ascii());
    }
    out
}
