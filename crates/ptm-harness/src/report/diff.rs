//! Exact differences between two reports. Every change is counted, and equal reports produce an empty result.
//!
//! If only a few cases changed, they are described in full. Otherwise, they are grouped by kind of change, cause and clause,
//! unless every case is requested.

use std::collections::{BTreeMap, HashMap};
use std::fmt::{self, Write};

use serde::Serialize;
use similar::DiffTag;
use similar::algorithms::{Capture, Compact, Replace, myers};

use crate::report::document::{CaseResult, FollowedReading, LikelyCause, Report};
use ptm_suite::clauses::section_of;
use ptm_suite::kit::yaml::to_yaml;
use ptm_suite::verdicts::outcome::Outcome;

/// Maximum number of changed cases that are described in full.
const MAX_FULL_DESCRIPTIONS: usize = 12;

impl Report {
    /// Describes the changes from this report to `new`. Returns an empty string if the reports are equal. Groups a large
    /// number of changed cases unless `every_case` is true.
    #[must_use]
    pub fn changes_to(&self, new: &Report, every_case: bool) -> String {
        let mut text = String::new();
        write(self, new, every_case, &mut text).expect("writing to memory does not fail");
        text
    }
}

/// Old and new results of a case. If only one report contains the case, that result appears twice.
type ChangedCase<'a> = (&'a CaseResult, &'a CaseResult);

/// Kinds of change, in the order in which they are described.
const KINDS: [&str; 6] = [
    "began to fail",
    "fixed",
    "changed outcome",
    "same outcome, other details",
    "appeared",
    "vanished",
];

/// Classifies the change of a case that both reports contain. Returns `None` if the results are equal.
fn kind_of_change(old: &CaseResult, new: &CaseResult) -> Option<&'static str> {
    match (old.outcome, new.outcome) {
        _ if old == new => None,
        (before, after) if before == after => Some("same outcome, other details"),
        (_, Outcome::Fail) => Some("began to fail"),
        (Outcome::Fail, Outcome::Pass) => Some("fixed"),
        _ => Some("changed outcome"),
    }
}

/// Groups the cases that differ between two reports by kind of change.
fn groups<'a>(old: &'a Report, new: &'a Report) -> [(&'static str, Vec<ChangedCase<'a>>); 6] {
    // If an id is duplicated, the last case with that id is used.
    let by_id = |report: &'a Report| -> HashMap<&str, &CaseResult> {
        (report.cases.iter().map(|case| (&*case.id, case))).collect()
    };
    let [before, after] = [old, new].map(by_id);
    let mut groups = KINDS.map(|kind| (kind, Vec::new()));
    let mut add = |kind: &str, pair| {
        let group = groups.iter_mut().find(|(name, _)| *name == kind);
        group.expect("every kind is listed").1.push(pair);
    };
    for new in &new.cases {
        let old = before.get(&*new.id).copied();
        let kind = old.map_or(Some("appeared"), |old| kind_of_change(old, new));
        if let Some(kind) = kind {
            add(kind, (old.unwrap_or(new), new));
        }
    }
    for old in old.cases.iter().filter(|old| !after.contains_key(&*old.id)) {
        add("vanished", (old, old));
    }
    groups
}

fn write(old: &Report, new: &Report, every_case: bool, out: &mut String) -> fmt::Result {
    let groups = groups(old, new);
    let changed = groups.iter().map(|(_, pairs)| pairs.len()).sum::<usize>();
    let in_full = every_case || changed <= MAX_FULL_DESCRIPTIONS;
    for (name, of) in HEADER_PARTS {
        write_lines(out, "", name, &of(old), &of(new))?;
    }
    let causes = |report: &Report| describe_causes(report, in_full);
    write_lines(out, "", "diagnoses", &causes(old), &causes(new))?;
    for (kind, pairs) in &groups {
        match pairs.len() {
            0 => continue,
            1 => writeln!(out, "1 case {kind}:")?,
            count => writeln!(out, "{count} cases {kind}:")?,
        }
        match in_full {
            true => pairs.iter().try_for_each(|pair| write_change(out, pair))?,
            false => write_counts(out, pairs, old, new)?,
        }
    }
    if out.is_empty() && old != new {
        *out += "the cases are in a different order, or a case is duplicated\n";
    }
    Ok(())
}

/// Parts of a report that are compared line by line.
const HEADER_PARTS: [(&str, fn(&Report) -> String); 10] = [
    ("suite", |report| yaml(&report.suite)),
    ("tool", |report| yaml(&report.tool)),
    ("decoder", |report| yaml(&report.decoder)),
    ("verdict", |report| report.verdict.to_string()),
    ("reason", |report| yaml(&report.reason)),
    ("remarks", |report| yaml(&report.remarks)),
    ("scores", |report| yaml(&report.scores)),
    ("dialect", |report| {
        let line = |known: &FollowedReading| format!("{}: {}\n", known.ruling, known.reading);
        report.dialect.iter().map(line).collect()
    }),
    ("outside the specification", |report| {
        (report.lenient.iter().map(|one| one.to_summary() + "\n")).collect()
    }),
    ("known failures", |report| yaml(&report.baseline)),
];

/// Returns the grouping key of a changed case: the kind of change, and the cause or the section.
fn group_key(old: &Report, new: &Report, &(before, after): &ChangedCase) -> String {
    if before == after {
        return after.outcome.to_string();
    }
    let fields = differing_fields(before, after).join(", ");
    let change = match before.outcome == after.outcome {
        true => format!("{} ({fields})", after.outcome),
        false => format!("{} → {}", before.outcome, after.outcome),
    };
    let fails = |case: &CaseResult| case.outcome == Outcome::Fail;
    let cause = match fails(after) {
        true => new.cause_of(after),
        false => old.cause_of(before),
    };
    let section = section_of(after.clauses.first().map_or("", String::as_str));
    match cause {
        Some(cause) => format!("{change}: {}{}", cause.title(), cause.clause_text()),
        None if fails(before) || fails(after) => format!("{change}: no cause, section {section}"),
        None => format!("{change}: section {section}"),
    }
}

/// Writes the number of cases and one example for each grouping key, most frequent first.
fn write_counts(out: &mut String, list: &[ChangedCase], old: &Report, new: &Report) -> fmt::Result {
    let mut groups: BTreeMap<String, Vec<&CaseResult>> = BTreeMap::new();
    for pair in list {
        let group = groups.entry(group_key(old, new, pair));
        group.or_default().push(pair.1);
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|(_, list)| std::cmp::Reverse(list.len()));
    groups.iter().try_for_each(|(key, list)| {
        let example = &list[0].id;
        match list.len() {
            1 => writeln!(out, "  {:>5}  {key}: {example}", 1),
            count => writeln!(out, "  {count:>5}  {key}, for example {example}"),
        }
    })
}

fn write_change(out: &mut String, (old, new): &ChangedCase) -> fmt::Result {
    match old.outcome == new.outcome {
        true => writeln!(out, "  {}: {}", new.id, new.outcome)?,
        false => writeln!(out, "  {}: {} → {}", new.id, old.outcome, new.outcome)?,
    }
    // All fields except the id and the outcome.
    let details = |case| -> String { yaml(case).split_inclusive('\n').skip(2).collect() };
    write_lines(out, "    ", "", &details(old), &details(new))
}

/// Describes each cause in one or two lines. If `in_full` is true, lists the cases that the cause explains; otherwise, counts them.
fn describe_causes(report: &Report, in_full: bool) -> String {
    let words = |cause: &LikelyCause| {
        let (effect, fix) = (&cause.effect, &cause.fix);
        let says = format!(
            "{}{}: {effect}; fix: {fix}",
            cause.name(),
            cause.clause_text()
        );
        match in_full {
            true => format!("{says}\nexplains {}\n", cause.explains.join(" ")),
            false => format!("{says} (explains {})\n", cause.explains.len()),
        }
    };
    report.diagnoses.iter().map(words).collect()
}

fn differing_fields(old: &CaseResult, new: &CaseResult) -> Vec<&'static str> {
    let fields = [
        ("view", old.view != new.view),
        ("expect", old.expect != new.expect),
        ("clauses", old.clauses != new.clauses),
        ("says", old.message != new.message),
        ("weak", old.weak != new.weak),
        ("stderr", old.stderr != new.stderr),
    ];
    let differ = fields.into_iter().filter(|&(_, differs)| differs);
    differ.map(|(name, _)| name).collect()
}

/// Writes the lines that differ between two texts.
fn write_lines(out: &mut String, indent: &str, name: &str, old: &str, new: &str) -> fmt::Result {
    if old == new {
        return Ok(());
    }
    if !name.is_empty() {
        writeln!(out, "{indent}{name}:")?;
    }
    let (old, new): (Vec<&str>, Vec<&str>) = (old.lines().collect(), new.lines().collect());
    // Does what `similar::capture_diff_slices` does, without compiling its other algorithms.
    let mut changes = Compact::new(Replace::new(Capture::new()), &*old, &*new);
    let Ok(()) = myers::diff(&mut changes, &*old, 0..old.len(), &*new, 0..new.len());
    for change in changes.into_inner().into_inner().into_ops() {
        if change.tag() != DiffTag::Equal {
            for line in &old[change.old_range()] {
                writeln!(out, "{indent}  - {line}")?;
            }
            for line in &new[change.new_range()] {
                writeln!(out, "{indent}  + {line}")?;
            }
        }
    }
    Ok(())
}

fn yaml(value: &impl Serialize) -> String {
    to_yaml(value).expect("a report can be written")
}
