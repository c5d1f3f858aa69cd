//! What changed between two reports, exactly: no change goes unsaid, and equal reports say nothing.

use std::collections::HashMap;
use std::fmt::Write;

use serde::Serialize;
use similar::{ChangeTag, TextDiff};

use super::{CaseResult, Cause, Reading, Report};
use crate::harness::judge::Outcome;

impl Report {
    /// The changes from this report to `new`, in words; empty where the two are equal.
    #[must_use]
    pub fn changes_to(&self, new: &Report) -> String {
        let mut text = String::new();
        self.write_changes(new, &mut text)
            .expect("writing to memory does not fail");
        text
    }

    fn write_changes(&self, new: &Report, out: &mut String) -> std::fmt::Result {
        let heads = [
            ("tool", yaml(&self.tool), yaml(&new.tool)),
            ("decoder", yaml(&self.decoder), yaml(&new.decoder)),
            ("verdict", self.verdict.clone(), new.verdict.clone()),
            ("reason", yaml(&self.reason), yaml(&new.reason)),
            ("scores", yaml(&self.scores), yaml(&new.scores)),
            ("dialect", listed(&self.dialect), listed(&new.dialect)),
            ("known failures", yaml(&self.baseline), yaml(&new.baseline)),
        ];
        for (name, old, new) in heads {
            write_lines(out, "", name, &old, &new)?;
        }
        self.write_diagnoses(new, out)?;
        self.write_cases(new, out)?;
        if out.is_empty() && self != new {
            writeln!(
                out,
                "the cases stand in another order, or one of them is there twice"
            )?;
        }
        Ok(())
    }

    fn write_diagnoses(&self, new: &Report, out: &mut String) -> std::fmt::Result {
        let said = |cause: &Cause| {
            format!(
                "{} (clause {}): {}; to mend it: {}\nexplains {}",
                cause
                    .misreading
                    .as_ref()
                    .or(cause.kind.as_ref())
                    .map_or("", String::as_str),
                cause.clause,
                cause.effect,
                cause.mend,
                cause.explains.join(" ")
            )
        };
        let of = |report: &Report| {
            report
                .diagnoses
                .iter()
                .map(said)
                .collect::<Vec<_>>()
                .join("\n")
        };
        write_lines(out, "", "diagnoses", &of(self), &of(new))
    }

    fn write_cases(&self, new: &Report, out: &mut String) -> std::fmt::Result {
        let (before, after) = (places(&self.cases), places(&new.cases));
        let both = || {
            let pair = |case| Some((*before.get(id_of(case))?, case));
            new.cases.iter().filter_map(pair)
        };
        let is = |case: &CaseResult, outcome: Outcome| case.outcome == outcome.name();
        let fails = |case: &CaseResult| is(case, Outcome::Fail);
        let groups: [(&str, Vec<(&CaseResult, &CaseResult)>); 4] = [
            (
                "began to fail",
                both()
                    .filter(|(old, new)| !fails(old) && fails(new))
                    .collect(),
            ),
            (
                "mended",
                both()
                    .filter(|(old, new)| fails(old) && is(new, Outcome::Pass))
                    .collect(),
            ),
            (
                "changed outcome",
                both()
                    .filter(|(old, new)| old.outcome != new.outcome && !fails(new))
                    .filter(|(old, new)| !(fails(old) && is(new, Outcome::Pass)))
                    .collect(),
            ),
            (
                "same outcome, said otherwise",
                both()
                    .filter(|(old, new)| old.outcome == new.outcome && old != new)
                    .collect(),
            ),
        ];
        for (name, changes) in groups {
            write_group(out, name, changes.len())?;
            for (old, new) in changes {
                if old.outcome == new.outcome {
                    writeln!(out, "  {}: {}", new.id, new.outcome)?;
                } else {
                    writeln!(out, "  {}: {} → {}", new.id, old.outcome, new.outcome)?;
                }
                write_lines(out, "    ", "", &details(old), &details(new))?;
            }
        }
        let only = |cases: &[CaseResult], others: &HashMap<&str, &CaseResult>| -> Vec<String> {
            cases
                .iter()
                .filter(|case| !others.contains_key(id_of(case)))
                .map(|case| format!("  {}: {}", case.id, case.outcome))
                .collect()
        };
        for (name, ids) in [
            ("appeared", only(&new.cases, &before)),
            ("vanished", only(&self.cases, &after)),
        ] {
            write_group(out, name, ids.len())?;
            for id in ids {
                writeln!(out, "{id}")?;
            }
        }
        Ok(())
    }
}

/// Cases by id; of two with the same id the last.
fn places(cases: &[CaseResult]) -> HashMap<&str, &CaseResult> {
    cases.iter().map(|case| (id_of(case), case)).collect()
}

fn write_group(out: &mut String, name: &str, count: usize) -> std::fmt::Result {
    match count {
        0 => Ok(()),
        1 => writeln!(out, "1 case {name}:"),
        _ => writeln!(out, "{count} cases {name}:"),
    }
}

/// The lines of which one text differs from the other.
fn write_lines(
    out: &mut String,
    indent: &str,
    name: &str,
    old: &str,
    new: &str,
) -> std::fmt::Result {
    if old == new {
        return Ok(());
    }
    if !name.is_empty() {
        writeln!(out, "{indent}{name}:")?;
    }
    for change in TextDiff::from_lines(old, new).iter_all_changes() {
        let sign = match change.tag() {
            ChangeTag::Equal => continue,
            ChangeTag::Delete => '-',
            ChangeTag::Insert => '+',
        };
        writeln!(
            out,
            "{indent}  {sign} {}",
            change.value().trim_end_matches('\n')
        )?;
    }
    Ok(())
}

/// A line for each reading.
fn listed(dialect: &[Reading]) -> String {
    let line = |known: &Reading| format!("{}: {}\n", known.ruling, known.reading);
    dialect.iter().map(line).collect()
}

/// What is said of a case besides its name and outcome, a line or more for each field.
fn details(case: &CaseResult) -> String {
    let (id, outcome) = (String::new(), String::new());
    let text = yaml(&CaseResult {
        id,
        outcome,
        ..case.clone()
    });
    text.lines()
        .skip(2)
        .map(|line| format!("{line}\n"))
        .collect()
}

fn yaml(value: &impl Serialize) -> String {
    serde_saphyr::to_string(value).expect("a report can be written")
}

fn id_of(case: &CaseResult) -> &str {
    &case.id
}
