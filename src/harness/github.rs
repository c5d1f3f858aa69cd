//! What GitHub shows of a run: annotations, and a summary of the job in Markdown.
//!
//! A runner takes lines of output that begin with `::` as commands. Everything that a decoder may have said is escaped,
//! so that it stays text.

use std::fmt::Write;

use crate::harness::cases::Suite;
use crate::harness::judge::Outcome;
use crate::harness::report::{CaseResult, Report};

/// A runner shows ten errors of a step.
const ANNOTATIONS: usize = 10;

/// Failures that the summary lists; it may have one mebibyte.
const LISTED: usize = 100;

/// Workflow commands, a line each: an error for each likely mistake, then one for each failure that is like none.
#[must_use]
pub fn annotations(report: &Report) -> String {
    let mut errors: Vec<(String, String)> = Vec::new();
    if let Some(reason) = &report.reason {
        errors.push(("not a decoder".to_owned(), reason.clone()));
    }
    for remark in report.remarks.iter().filter(|remark| remark.failure) {
        errors.push(("PTM conformance".to_owned(), remark.says.clone()));
    }
    let failures = failures(report);
    // What is known is no news.
    let news: Vec<&CaseResult> = failures
        .iter()
        .copied()
        .filter(|case| !report.is_known(case))
        .collect();
    for cause in &report.diagnoses {
        let stands = |case: &&&CaseResult| report.cause_of(case) == Some(cause);
        let share = news.iter().filter(stands).count();
        if share > 0 {
            errors.push((
                format!("PTM clause {}: {}", cause.clause, cause.name()),
                format!(
                    "{share} of {} failures: the decoder {}. To mend it: {}.",
                    news.len(),
                    cause.effect,
                    cause.mend
                ),
            ));
        }
    }
    for case in news.iter().filter(|case| report.cause_of(case).is_none()) {
        errors.push((
            format!("PTM case {}", case.id),
            case.says.clone().unwrap_or_default(),
        ));
    }
    let left_out = errors.len().saturating_sub(ANNOTATIONS);
    let mut text = String::new();
    for (title, message) in errors.iter().take(ANNOTATIONS) {
        let _ = writeln!(text, "::error title={}::{}", property(title), data(message));
    }
    if left_out > 0 {
        let _ = writeln!(
            text,
            "::notice title=PTM conformance::{left_out} more errors stand in the report"
        );
    }
    text
}

/// The job's summary in Markdown.
#[must_use]
pub fn summary(suite: &Suite, report: &Report) -> String {
    let mut text = String::new();
    write_summary(suite, report, &mut text).expect("writing to memory does not fail");
    text
}

fn write_summary(suite: &Suite, report: &Report, out: &mut String) -> std::fmt::Result {
    let sign = if report.verdict == "pass" {
        "✅"
    } else {
        "❌"
    };
    let command = code(&report.decoder.command);
    writeln!(out, "## {sign} PTM 1.2: {command}: {}\n", report.verdict)?;
    if let Some(reason) = &report.reason {
        for line in reason.lines() {
            writeln!(out, "> {}  ", plain(line))?;
        }
        writeln!(out)?;
    }
    let scores = &report.scores;
    writeln!(
        out,
        "| correctness | breadth | robustness |\n|--:|--:|--:|\n| {} | {} | {} |\n",
        plain(&scores.correctness),
        plain(&scores.breadth),
        plain(&scores.robustness)
    )?;
    for remark in &report.remarks {
        writeln!(out, "> {}\n", plain(&remark.says))?;
    }
    let failures = failures(report);
    if let Some(news) = &report.baseline {
        writeln!(
            out,
            "Of {} failures {} were known and {} are new; {} known ones were mended.\n",
            failures.len(),
            news.known.len(),
            news.new.len(),
            news.stale.len()
        )?;
    }
    if !report.diagnoses.is_empty() {
        writeln!(out, "### Diagnosis\n")?;
    }
    for cause in &report.diagnoses {
        writeln!(
            out,
            "- **{} of {} failures:** the decoder {} (clause {}).  \n  To mend it: {}.",
            cause.explains.len(),
            failures.len(),
            plain(&cause.effect),
            plain(&cause.clause),
            plain(&cause.mend),
        )?;
        if let Some(slug) = &cause.misreading {
            let command = format!("ptm-conform explain {slug}");
            writeln!(out, "  More: {}", code(&command))?;
        }
    }
    let unexplained: Vec<_> = failures
        .iter()
        .filter(|case| report.cause_of(case).is_none())
        .collect();
    if !unexplained.is_empty() {
        writeln!(
            out,
            "\n{} of {} failures are like no mistake of the catalogue.",
            unexplained.len(),
            failures.len()
        )?;
    }
    if !failures.is_empty() {
        writeln!(
            out,
            "\n<details><summary>{} failing cases</summary>\n\n| case | clauses | found |\n|---|---|---|",
            failures.len()
        )?;
        for case in failures.iter().take(LISTED) {
            let says: String = case
                .says
                .iter()
                .flat_map(|says| says.chars())
                .take(300)
                .collect();
            writeln!(
                out,
                "| {} | {} | {} |",
                code(&case.id),
                plain(&case.clauses.join(", ")),
                plain(&says)
            )?;
        }
        if failures.len() > LISTED {
            writeln!(out, "\n… and {} more.", failures.len() - LISTED)?;
        }
        writeln!(out, "\n</details>")?;
    }
    let counts = Outcome::ALL.iter().filter_map(|outcome| {
        let cases = report.cases.iter();
        let count = cases.filter(|case| case.outcome == outcome.name()).count();
        (count > 0).then(|| format!("{count} {}", outcome.name()))
    });
    let counts: Vec<String> = counts.collect();
    writeln!(
        out,
        "\n{} of {} cases: {}.",
        report.cases.len(),
        suite.cases.len(),
        counts.join(", ")
    )
}

/// `text` with nothing in it that a runner takes for a command: lines that begin like one are quoted.
#[must_use]
pub fn without_commands(text: &str) -> String {
    text.split_inclusive('\n')
        .map(|line| {
            let begins = line.trim_start();
            if begins.starts_with("::") || begins.starts_with("##[") {
                format!("> {line}")
            } else {
                line.to_owned()
            }
        })
        .collect()
}

fn failures(report: &Report) -> Vec<&CaseResult> {
    let cases = report.cases.iter();
    cases
        .filter(|case| case.outcome == Outcome::Fail.name())
        .collect()
}

/// The message of a workflow command.
fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

/// A property of a workflow command.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

/// Words that are no Markdown and no HTML, on one line.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    for c in text.chars() {
        match c {
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '&' => plain.push_str("&amp;"),
            '\n' | '\r' => plain.push(' '),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' | '#' | '!' | '@' => {
                plain.push('\\');
                plain.push(c);
            }
            _ => plain.push(c),
        }
    }
    plain
}

/// Words as code, whatever is in them.
fn code(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '&' => escaped.push_str("&amp;"),
            '|' => escaped.push_str("&#124;"),
            '`' | '*' | '_' | '[' | ']' | '\\' | '~' | '@' => {
                let _ = write!(escaped, "&#{};", u32::from(c));
            }
            '\n' | '\r' => escaped.push(' '),
            _ => escaped.push(c),
        }
    }
    format!("<code>{escaped}</code>")
}
