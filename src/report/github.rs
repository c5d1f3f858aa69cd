//! Output for GitHub Actions: annotations and a job summary in Markdown.
//!
//! A runner treats output lines that begin with `::` as commands, so all output of the decoder is escaped.

use std::fmt::{self, Write};

use crate::report::text::not_asked_text;
use ptm_harness::report::document::{CaseResult, LikelyCause, Report, Verdict};
use ptm_suite::address::published_url;
use ptm_suite::verdicts::outcome::Outcome;

/// Maximum number of errors that a runner displays for a step.
const MAX_ANNOTATIONS: usize = 10;

/// Maximum number of failures in the summary. GitHub limits a summary to one mebibyte.
const MAX_LISTED_FAILURES: usize = 100;

/// Returns workflow commands, one per line: an error for each problem with the whole run, each likely mistake and each
/// unexplained failure, up to `MAX_ANNOTATIONS`.
#[must_use]
pub fn annotations(report: &Report) -> String {
    let errors = errors(report);
    let left_out = errors.len().saturating_sub(MAX_ANNOTATIONS);
    let mut text = String::new();
    for (title, message) in errors.iter().take(MAX_ANNOTATIONS) {
        let (title, message) = (escape_property(title), escape_data(message));
        let _ = writeln!(text, "::error title={title}::{message}");
    }
    if left_out > 0 {
        let suite = escape_property(report.suite.short_title());
        let says = format!("see the report for {left_out} more errors");
        let _ = writeln!(text, "::notice title={suite} conformance::{says}");
    }
    text
}

fn errors(report: &Report) -> Vec<(String, String)> {
    let name = report.suite.short_title();
    let mut errors: Vec<(String, String)> = Vec::new();
    if let Some(reason) = &report.reason {
        errors.push((report.verdict.to_string(), reason.clone()));
    }
    let remarks = report.remarks.iter().filter(|remark| remark.failure);
    errors.extend(remarks.map(|remark| (format!("{name} conformance"), remark.message.clone())));
    // Known failures are not reported again.
    let failures = report.with_outcome(Outcome::Fail);
    let new: Vec<&CaseResult> = failures.filter(|case| !report.is_known(case)).collect();
    for cause in &report.diagnoses {
        let has_this_cause = |case: &&&CaseResult| report.cause_of(case) == Some(cause);
        let share = new.iter().filter(has_this_cause).count();
        if share > 0 {
            let clause = cause
                .misread_clause()
                .map(|clause| format!(", clause {clause}"));
            let title = format!("{name}{}: {}", clause.unwrap_or_default(), cause.name());
            let (all, subject) = (new.len(), report.suite.subject());
            let LikelyCause { effect, fix, .. } = cause;
            let says = format!("{share} of {all} failures: the {subject} {effect}. Fix: {fix}.");
            errors.push((title, says));
        }
    }
    let unexplained = new.iter().filter(|case| report.cause_of(case).is_none());
    let title = |case: &CaseResult| format!("{name}, case {}", case.id);
    errors.extend(unexplained.map(|case| (title(case), case.message.clone())));
    errors
}

/// Returns the job summary in Markdown. `suite_size` is the number of cases in the suite.
#[must_use]
pub fn summary(report: &Report, suite_size: usize) -> String {
    let failures: Vec<&CaseResult> = report.with_outcome(Outcome::Fail).collect();
    let mut text = String::new();
    let mut write = || {
        write_head(report, &mut text)?;
        write_diagnoses(report, &failures, &mut text)?;
        write_failures(&failures, &mut text)?;
        let (judged, counts) = (report.cases.len(), report.counts());
        writeln!(text, "\n{judged} of {suite_size} cases: {counts}.")
    };
    write().expect("writing to memory does not fail");
    text
}

/// Writes the verdict, the scores and the remarks.
fn write_head(report: &Report, out: &mut String) -> fmt::Result {
    let suite = report.suite.short_title();
    let command = inline_code(&report.decoder.command);
    let sign = ["❌", "✅"][usize::from(report.verdict == Verdict::Pass)];
    writeln!(out, "## {sign} {suite}: {command}: {}\n", report.verdict)?;
    if let Some(reason) = &report.reason {
        for line in reason.lines() {
            writeln!(out, "> {}  ", escape_markdown(line))?;
        }
        writeln!(out)?;
    }
    let scores = &report.scores;
    let parts = [scores.correctness, scores.breadth, scores.robustness];
    writeln!(out, "| correctness | breadth | robustness |\n|--:|--:|--:|")?;
    writeln!(out, "| {} | {} | {} |\n", parts[0], parts[1], parts[2])?;
    if let Some(text) = not_asked_text(report) {
        writeln!(out, "> {}\n", escape_markdown(&text))?;
    }
    for remark in &report.remarks {
        writeln!(out, "> {}\n", escape_markdown(&remark.message))?;
    }
    Ok(())
}

/// Writes the comparison with the baseline, the causes, and the number of unexplained failures.
fn write_diagnoses(report: &Report, failures: &[&CaseResult], out: &mut String) -> fmt::Result {
    let all = failures.len();
    if let Some(list) = &report.baseline {
        let [known, new, fixed] = [&list.known, &list.new, &list.stale].map(Vec::len);
        writeln!(
            out,
            "Known failures: {known} of {all}; new failures: {new}; fixed: {fixed}.\n"
        )?;
    }
    if !report.diagnoses.is_empty() {
        writeln!(out, "### Diagnosis\n")?;
    }
    for cause in &report.diagnoses {
        write_cause(cause, report, all, out)?;
    }
    let is_unexplained = |case: &&&CaseResult| report.cause_of(case).is_none();
    match failures.iter().filter(is_unexplained).count() {
        0 => Ok(()),
        count => writeln!(out, "\nUnexplained failures: {count} of {all}."),
    }
}

fn write_cause(cause: &LikelyCause, report: &Report, all: usize, out: &mut String) -> fmt::Result {
    let (suite, count) = (report.suite, cause.explains.len());
    let [effect, fix] = [&cause.effect, &cause.fix].map(escape_markdown);
    write!(
        out,
        "- **{count} of {all} failures:** the {} {effect}",
        suite.subject()
    )?;
    if let Some(clause) = cause.misread_clause() {
        write!(
            out,
            " (clause {})",
            link(&escape_markdown(clause), suite.clause_page(clause))
        )?;
    }
    writeln!(out, ".  ")?;
    writeln!(out, "  Fix: {fix}.")?;
    match &cause.misreading {
        Some(slug) => {
            let command = format!("ptm-conform explain {slug}");
            let page = Some(suite.misreading_page(slug));
            writeln!(out, "  More: {}", link(&inline_code(&command), page))
        }
        None => Ok(()),
    }
}

/// Wraps Markdown in a link to a page of the site. Returns the Markdown unchanged if there is no page or the page name contains
/// unexpected characters, since names in a report are untrusted.
fn link(markdown: &str, page: Option<String>) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-./#".contains(c);
    match page.filter(|page| page.chars().all(is_plain)) {
        Some(page) => format!("[{markdown}]({})", published_url(&page)),
        None => markdown.to_owned(),
    }
}

/// Writes a table of the failing cases.
fn write_failures(failures: &[&CaseResult], out: &mut String) -> fmt::Result {
    if failures.is_empty() {
        return Ok(());
    }
    let count = failures.len();
    writeln!(out, "\n<details><summary>{count} failing cases</summary>\n")?;
    writeln!(out, "| case | clauses | result |\n|---|---|---|")?;
    for case in failures.iter().take(MAX_LISTED_FAILURES) {
        let says: String = case.message.chars().take(300).collect();
        let [clauses, says] = [&case.clauses.join(", "), &says].map(escape_markdown);
        writeln!(out, "| {} | {clauses} | {says} |", inline_code(&case.id))?;
    }
    if count > MAX_LISTED_FAILURES {
        writeln!(out, "\n… and {} more.", count - MAX_LISTED_FAILURES)?;
    }
    writeln!(out, "\n</details>")
}

/// Quotes the lines of `text` that a runner would treat as commands.
#[must_use]
pub fn quote_commands(text: &str) -> String {
    let quote = |line: &str| {
        let begins = line.trim_start();
        let is_command = begins.starts_with("::") || begins.starts_with("##[");
        format!("{}{line}", if is_command { "> " } else { "" })
    };
    text.split_inclusive('\n').map(quote).collect()
}

/// Escapes text for use as the message of a workflow command.
fn escape_data(text: &str) -> String {
    (text.replace('%', "%25").replace('\r', "%0D")).replace('\n', "%0A")
}

/// Escapes text for use as a property of a workflow command.
fn escape_property(text: &str) -> String {
    escape_data(text).replace(':', "%3A").replace(',', "%2C")
}

/// Escapes Markdown and HTML in `text` and joins its lines.
fn escape_markdown(text: impl AsRef<str>) -> String {
    escape_with(text.as_ref(), |c| format!("\\{c}"))
}

/// Formats `text` as inline code. The text may contain any characters.
fn inline_code(text: &str) -> String {
    let escaped = escape_with(text, |c| match c {
        '#' | '!' => c.to_string(),
        _ => format!("&#{};", u32::from(c)),
    });
    format!("<code>{escaped}</code>")
}

/// Escapes HTML and replaces line breaks with spaces. Calls `markdown` to escape each Markdown character.
fn escape_with(text: &str, markdown: impl Fn(char) -> String) -> String {
    let escape = |c: char| match c {
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '&' => "&amp;".to_owned(),
        '\n' | '\r' => " ".to_owned(),
        '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '!' | '@' => markdown(c),
        _ => c.to_string(),
    };
    text.chars().map(escape).collect()
}
