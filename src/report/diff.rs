//! Exact differences between two reports: every change is counted, and the result is empty for equal reports.
//!
//! A few changed cases are described in full. Many are grouped by kind of change, by cause and by clause, unless every case is
//! requested.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;

use serde::Serialize;
use similar::{ChangeTag, TextDiff};

use crate::kit::yaml::to_yaml;
use crate::report::document::{CaseResult, FollowedReading, LikelyCause, Report, section_of};
use crate::session::outcome::Outcome;

/// Maximum number of changed cases that are described in full.
const MAX_IN_FULL: usize = 12;

impl Report {
    /// Describes the changes from this report to `new`; empty if the two are equal. Many changed cases are grouped unless
    /// `every_case` is true.
    #[must_use]
    pub fn changes_to(&self, new: &Report, every_case: bool) -> String {
        let mut text = String::new();
        let changes = Changes::new(self, new);
        let in_full = every_case || changes.count() <= MAX_IN_FULL;
        changes
            .write(in_full, &mut text)
            .expect("writing to memory does not fail");
        text
    }
}

/// Two reports, and the cases in which they differ.
struct Changes<'a> {
    old: &'a Report,
    new: &'a Report,
    /// Cases of both reports, by kind of change.
    changed: Vec<(&'static str, Vec<Pair<'a>>)>,
    appeared: Vec<&'a CaseResult>,
    vanished: Vec<&'a CaseResult>,
}

impl<'a> Changes<'a> {
    fn new(old: &'a Report, new: &'a Report) -> Changes<'a> {
        let (before, after) = (places(&old.cases), places(&new.cases));
        let pair = |case| Some((*before.get(id_of(case))?, case));
        let both: Vec<Pair> = new.cases.iter().filter_map(pair).collect();
        let of_kind = |(name, is_of): (_, fn(&CaseResult, &CaseResult) -> bool)| {
            let changes = both.iter().copied();
            (name, changes.filter(|(old, new)| is_of(old, new)).collect())
        };
        let only = |cases: &'a [CaseResult], others: &HashMap<&str, &CaseResult>| {
            let cases = cases.iter();
            cases
                .filter(|case| !others.contains_key(id_of(case)))
                .collect()
        };
        Changes {
            old,
            new,
            changed: CHANGES.into_iter().map(of_kind).collect(),
            appeared: only(&new.cases, &before),
            vanished: only(&old.cases, &after),
        }
    }

    fn count(&self) -> usize {
        let changed = self.changed.iter().map(|(_, pairs)| pairs.len());
        changed.sum::<usize>() + self.appeared.len() + self.vanished.len()
    }

    fn write(&self, in_full: bool, out: &mut String) -> std::fmt::Result {
        let (old, new) = (self.old, self.new);
        let heads = [
            ("suite", yaml(&old.suite), yaml(&new.suite)),
            ("tool", yaml(&old.tool), yaml(&new.tool)),
            ("decoder", yaml(&old.decoder), yaml(&new.decoder)),
            ("verdict", old.verdict.clone(), new.verdict.clone()),
            ("reason", yaml(&old.reason), yaml(&new.reason)),
            ("remarks", yaml(&old.remarks), yaml(&new.remarks)),
            ("scores", yaml(&old.scores), yaml(&new.scores)),
            ("dialect", readings(&old.dialect), readings(&new.dialect)),
            (
                "outside the specification",
                leniencies(old),
                leniencies(new),
            ),
            ("known failures", yaml(&old.baseline), yaml(&new.baseline)),
        ];
        for (name, old, new) in heads {
            write_lines(out, "", name, &old, &new)?;
        }
        let causes = |report: &Report| causes_in_words(report, in_full);
        write_lines(out, "", "diagnoses", &causes(old), &causes(new))?;
        for (name, pairs) in &self.changed {
            write_group(out, name, pairs.len())?;
            match in_full {
                true => write_each(out, pairs)?,
                false => self.write_grouped(out, pairs)?,
            }
        }
        for (name, cases) in [("appeared", &self.appeared), ("vanished", &self.vanished)] {
            write_group(out, name, cases.len())?;
            match in_full {
                true => (cases.iter())
                    .try_for_each(|case| writeln!(out, "  {}: {}", case.id, case.outcome))?,
                false => {
                    let keyed = cases.iter().map(|case| (case.outcome.to_string(), *case));
                    write_counts(out, keyed)?;
                }
            }
        }
        if out.is_empty() && old != new {
            writeln!(
                out,
                "the cases are in another order, or a case is duplicated"
            )?;
        }
        Ok(())
    }

    /// Writes changes by kind, by cause and by clause.
    fn write_grouped(&self, out: &mut String, pairs: &[Pair]) -> std::fmt::Result {
        let keyed = pairs.iter().map(|&(old, new)| {
            let how = match old.outcome == new.outcome {
                true => format!("{} ({})", new.outcome, differing(old, new).join(", ")),
                false => format!("{} → {}", old.outcome, new.outcome),
            };
            let cause = match fails(new) {
                true => self.new.cause_of(new),
                false => self.old.cause_of(old),
            };
            let clause = new.clauses.first().map_or("", String::as_str);
            let section = section_of(clause);
            let about = match cause {
                Some(cause) => format!("{} (clause {})", cause.title(), cause.clause),
                None if fails(old) || fails(new) => format!("no cause, section {section}"),
                None => format!("section {section}"),
            };
            (format!("{how}: {about}"), new)
        });
        write_counts(out, keyed)
    }
}

/// Writes the number of cases of each key, and one example; the most frequent first.
fn write_counts<'a>(
    out: &mut String,
    keyed: impl Iterator<Item = (String, &'a CaseResult)>,
) -> std::fmt::Result {
    let mut groups: BTreeMap<String, Vec<&CaseResult>> = BTreeMap::new();
    for (key, case) in keyed {
        groups.entry(key).or_default().push(case);
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|(_, cases)| std::cmp::Reverse(cases.len()));
    groups.iter().try_for_each(|(key, cases)| {
        let example = &cases[0].id;
        match cases.len() {
            1 => writeln!(out, "  {:>5}  {key}: {example}", 1),
            count => writeln!(out, "  {count:>5}  {key}, for example {example}"),
        }
    })
}

/// Writes each change separately.
fn write_each(out: &mut String, pairs: &[Pair]) -> std::fmt::Result {
    pairs.iter().try_for_each(|(old, new)| {
        if old.outcome == new.outcome {
            writeln!(out, "  {}: {}", new.id, new.outcome)?;
        } else {
            writeln!(out, "  {}: {} → {}", new.id, old.outcome, new.outcome)?;
        }
        write_lines(out, "    ", "", &details(old), &details(new))
    })
}

/// Describes the causes of a report in a line or two each, with the cases that each explains, or their number.
fn causes_in_words(report: &Report, in_full: bool) -> String {
    let words = |cause: &LikelyCause| {
        let says = format!(
            "{} (clause {}): {}; fix: {}",
            cause.name(),
            cause.clause,
            cause.effect,
            cause.fix,
        );
        match in_full {
            true => format!("{says}\nexplains {}\n", cause.explains.join(" ")),
            false => format!("{says} (explains {})\n", cause.explains.len()),
        }
    };
    report.diagnoses.iter().map(words).collect()
}

/// Returns the names of the fields in which two results differ.
fn differing(old: &CaseResult, new: &CaseResult) -> Vec<&'static str> {
    let fields = [
        ("view", old.view != new.view),
        ("expect", old.expect != new.expect),
        ("clauses", old.clauses != new.clauses),
        ("says", old.says != new.says),
        ("weak", old.weak != new.weak),
        ("stderr", old.stderr != new.stderr),
    ];
    let differ = fields.into_iter().filter(|&(_, differs)| differs);
    differ.map(|(name, _)| name).collect()
}

/// A case before and after.
type Pair<'a> = (&'a CaseResult, &'a CaseResult);

fn fails(case: &CaseResult) -> bool {
    case.outcome == Outcome::Fail
}

fn is_fixed(old: &CaseResult, new: &CaseResult) -> bool {
    fails(old) && new.outcome == Outcome::Pass
}

/// Kinds of change; each changed case belongs to exactly one.
const CHANGES: [(&str, fn(&CaseResult, &CaseResult) -> bool); 4] = [
    ("began to fail", |old, new| !fails(old) && fails(new)),
    ("fixed", is_fixed),
    ("changed outcome", |old, new| {
        old.outcome != new.outcome && !fails(new) && !is_fixed(old, new)
    }),
    ("same outcome, other details", |old, new| {
        old.outcome == new.outcome && old != new
    }),
];

/// Returns cases by id; for a duplicate id the last one.
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

/// Writes the lines in which one text differs from the other.
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

/// Returns one line for each reading.
fn readings(dialect: &[FollowedReading]) -> String {
    let line = |known: &FollowedReading| format!("{}: {}\n", known.ruling, known.reading);
    dialect.iter().map(line).collect()
}

/// Returns one line for each ruling outside the specification.
fn leniencies(report: &Report) -> String {
    let rulings = report.lenient.iter();
    rulings.map(|one| one.in_words() + "\n").collect()
}

/// Returns the other fields of a case, a line or more each.
fn details(case: &CaseResult) -> String {
    let (id, outcome) = (String::new(), Outcome::Pass);
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
    to_yaml(value).expect("a report can be written")
}

fn id_of(case: &CaseResult) -> &str {
    &case.id
}
