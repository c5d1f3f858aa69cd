//! Reports as text for a terminal.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fmt::{self, Write};

use ptm_harness::pipeline::FirstVerdicts;
use ptm_harness::report::document::{CaseResult, FollowedReading, LikelyCause, Report, Verdict};
use ptm_harness::report::leniency::Leniency;
use ptm_harness::report::suite_texts::SuiteTexts;
use ptm_harness::report::words::{call_instructions, details};
use ptm_suite::kit::last_message::quote_last_message;
use ptm_suite::verdicts::outcome::Outcome;

/// Maximum number of example failures for a misreading in the catalog.
const MAX_MISREADING_EXAMPLES: usize = 2;

/// Maximum number of example failures for any other cause.
const MAX_OTHER_EXAMPLES: usize = 1;

/// Formats a report for a terminal. At most `max_failures` unexplained failures are described in full.
#[must_use]
pub fn report_to_text(report: &Report, texts: &SuiteTexts, max_failures: usize) -> String {
    let mut text = String::new();
    let page = Page {
        report,
        texts,
        failing: report.with_outcome(Outcome::Fail).collect(),
    };
    let written = page.write(max_failures, &mut text);
    written.expect("writing to memory does not fail");
    text
}

/// Formats the results of the cases whose ids satisfy `is_selected`.
#[must_use]
pub fn cases_to_text(
    report: &Report,
    texts: &SuiteTexts,
    is_selected: impl Fn(&str) -> bool,
) -> String {
    let mut text = String::new();
    for case in report.cases.iter().filter(|case| is_selected(&case.id)) {
        write_case(case, texts, &mut text).expect("writing to memory does not fail");
    }
    text
}

/// Maximum number of failing clauses that are listed during a run.
const MAX_FIRST_CLAUSES: usize = 12;

/// Describes the verdicts on the first cases of a run, which are chosen from all clauses.
#[must_use]
pub fn first_verdicts_to_text(first: &FirstVerdicts) -> String {
    let FirstVerdicts {
        judged,
        failed,
        failing_clauses,
    } = first;
    if *failed == 0 {
        return format!("the first {judged} cases, chosen from all clauses: none failed");
    }
    // The order is that of the number of failing cases, multiplied by their share.
    let mut clauses: Vec<(&String, &(usize, usize))> = failing_clauses.iter().collect();
    clauses.sort_by_key(|(_, (failing, all))| Reverse(1000 * failing * failing / all));
    let listed = clauses.iter().take(MAX_FIRST_CLAUSES);
    let listed: Vec<String> = listed
        .map(|(clause, (failing, all))| format!("{clause} ({failing} of {all})"))
        .collect();
    let more = match clauses.len().saturating_sub(MAX_FIRST_CLAUSES) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    format!(
        "the first {judged} cases, chosen from all clauses: {failed} failed; by clause: {}{more}",
        listed.join(", ")
    )
}

/// Returns a sentence about the files that were not requested because the decoder lacks a feature, if there are any.
#[must_use]
pub fn not_asked_text(report: &Report) -> Option<String> {
    let of_feature = |(feature, count): (&String, &usize)| format!("{count} of {feature}");
    let features: Vec<String> = report.not_asked.iter().map(of_feature).collect();
    let total: usize = report.not_asked.values().sum();
    (total > 0).then(|| {
        format!(
            "not asked, because it exits with 69 for the first files of the kind: {} (--all asks them)",
            features.join(", ")
        )
    })
}

/// Describes the behavior of a decoder with this mistake, and names the misread clause if there is one.
fn behavior(cause: &LikelyCause) -> String {
    cause.effect.clone() + &cause.clause_text()
}

/// Report that is formatted for a terminal.
struct Page<'a> {
    report: &'a Report,
    texts: &'a SuiteTexts,
    failing: Vec<&'a CaseResult>,
}

impl Page<'_> {
    fn write(&self, max_failures: usize, out: &mut String) -> fmt::Result {
        if let Some(reason) = &self.report.reason {
            let command = &self.report.decoder.command;
            let subject = self.report.suite.subject();
            writeln!(out, "{command} is not a {subject}: {reason}")?;
            return writeln!(out, "{}", call_instructions(self.report.suite, command));
        }
        for remark in &self.report.remarks {
            let kind = if remark.failure { "FAIL" } else { "note" };
            writeln!(out, "{kind}: {}", remark.message.replace('\n', "\n  "))?;
        }
        if !self.report.remarks.is_empty() {
            writeln!(out)?;
        }
        for cause in &self.report.diagnoses {
            self.write_cause(cause, out)?;
        }
        self.write_unexplained(max_failures, out)?;
        self.write_summary(out)
    }

    /// Writes a cause, the suggested fix, and a few failures that it explains.
    fn write_cause(&self, cause: &LikelyCause, out: &mut String) -> fmt::Result {
        let (count, all) = (cause.explains.len(), self.failing.len());
        let (subject, behavior) = (self.report.suite.subject(), behavior(cause));
        let result = |id: &String| self.failing.iter().find(|case| case.id == *id);
        let mut explained = cause.explains.iter().filter_map(result);
        if self.report.baseline.is_some() && explained.all(|case| self.report.is_known(case)) {
            return writeln!(out, "{count} known failures: the {subject} {behavior}.\n");
        }
        writeln!(out, "{count} of {all} failures: the {subject} {behavior}.")?;
        for (before, name, after, _) in details(cause, self.report.suite) {
            writeln!(out, "  {before}{name}{after}")?;
        }
        if let Some(example) = &cause.example {
            writeln!(out, "  {}", capitalize(example))?;
        }
        let (more, examples) = match &cause.misreading {
            Some(slug) => (
                format!(" More: ptm-conform explain {slug}"),
                MAX_MISREADING_EXAMPLES,
            ),
            None => (String::new(), MAX_OTHER_EXAMPLES),
        };
        writeln!(out, "  Fix: {}.{more}", cause.fix)?;
        // The example describes the first failure.
        for case in cause.explains.iter().filter_map(result).take(examples) {
            self.write_failure(case, out)?;
        }
        writeln!(out)
    }

    fn write_unexplained(&self, max_failures: usize, out: &mut String) -> fmt::Result {
        let mut unexplained = self.failing.clone();
        unexplained.retain(|case| self.report.cause_of(case).is_none());
        let (known, unexplained): (Vec<_>, Vec<_>) = unexplained
            .into_iter()
            .partition(|case| self.report.is_known(case));
        if !known.is_empty() {
            writeln!(out, "{} known failures without a cause\n", known.len())?;
        }
        if unexplained.is_empty() {
            return Ok(());
        }
        let (count, all) = (unexplained.len(), self.failing.len());
        writeln!(out, "Unexplained failures: {count} of {all}")?;
        let (alike, single) = group_violations(&unexplained);
        for (kind, cases) in &alike {
            writeln!(out, "  {} failures: {kind}; for example", cases.len())?;
            for case in cases.iter().take(2) {
                self.write_failure(case, out)?;
            }
        }
        for case in single.iter().take(max_failures) {
            self.write_failure(case, out)?;
        }
        if single.len() > max_failures {
            let more = single.len() - max_failures;
            writeln!(out, "  … and {more} more; the report lists all of them")?;
        }
        writeln!(out)
    }

    fn write_failure(&self, case: &CaseResult, out: &mut String) -> fmt::Result {
        writeln!(out, "  FAIL {}  ({})", case.id, case.clauses.join(", "))?;
        writeln!(out, "    {}: {}", case.view, case.message)?;
        let purpose = self.texts.purpose(&case.id).unwrap_or_default();
        let last = quote_last_message("", &case.stderr);
        let mut lines = purpose.lines().chain(last.lines());
        lines.try_for_each(|line| writeln!(out, "    {line}"))
    }

    /// Writes the dialect, the counts and the scores.
    fn write_summary(&self, out: &mut String) -> fmt::Result {
        let report = self.report;
        self.write_dialect(out)?;
        let lenient = report.lenient.iter().map(Leniency::to_summary);
        write_list(
            out,
            "files that need not be decoded (see explain NAME)",
            lenient,
        )?;
        if !report.decoder.unsupported.is_empty() {
            let unsupported = report.decoder.unsupported.join(", ");
            writeln!(out, "unsupported (exit status 69): {unsupported}")?;
        }
        if let Some(text) = not_asked_text(report) {
            writeln!(out, "{text}")?;
        }
        let not_asked: usize = report.not_asked.values().sum();
        let (judged, all) = (report.cases.len() + not_asked, self.texts.cases.len());
        let selection = match judged < all {
            true => format!(" ({judged} of {all} cases selected)"),
            false => String::new(),
        };
        // With a baseline, the last line of the output has the verdict.
        let verdict = match &report.baseline {
            Some(_) => "judged".to_owned(),
            None => report.verdict.to_string(),
        };
        writeln!(out, "{verdict}: {}{selection}", report.counts())?;
        if report.verdict == Verdict::Fail && self.failing.is_empty() {
            writeln!(
                out,
                "no case failed, but the run does not pass; see the remarks above"
            )?;
        }
        for ((outcome, says), count) in self.count_open_cases() {
            writeln!(out, "{count} {outcome}: {says}")?;
        }
        let weak = report.cases.iter().filter(|case| case.weak).count();
        if weak > 0 {
            let why = "their exit status may also mean a crash, so they prove less than refusals with status 65";
            writeln!(out, "weak refusals: {weak}; {why}")?;
        }
        writeln!(out, "{}", report.scores)
    }

    /// Writes how many open questions the decoder reads as the reference does, and how it reads the rest.
    fn write_dialect(&self, out: &mut String) -> fmt::Result {
        let of_reference = |known: &&FollowedReading| {
            let reading = (&*known.ruling, &*known.reading);
            self.texts.reference_readings.contains(&reading)
        };
        let (alike, others): (Vec<_>, Vec<_>) = self.report.dialect.iter().partition(of_reference);
        let has_alike = !alike.is_empty();
        let alike = match alike.len() {
            1 => "1 open question is answered as in the reference".to_owned(),
            many => format!("{many} open questions are answered as in the reference"),
        };
        let others = (others.iter()).map(|known| format!("{}: {}", known.ruling, known.reading));
        let items = has_alike.then_some(alike).into_iter().chain(others);
        write_list(out, "dialect", items)
    }

    /// Counts the cases that were inconclusive or not judged, by outcome and reason.
    fn count_open_cases(&self) -> BTreeMap<(Outcome, &str), usize> {
        let mut reasons = BTreeMap::new();
        let twins = match self.failing.is_empty() {
            true => "the valid twin was not decoded",
            false => "the valid twin was not decoded, or was also misread",
        };
        let count = self.report.with_outcome(Outcome::Inconclusive).count();
        if count > 0 {
            reasons.insert((Outcome::Inconclusive, twins), count);
        }
        for case in self.report.with_outcome(Outcome::NotJudged) {
            let key = (Outcome::NotJudged, &*case.message);
            *reasons.entry(key).or_default() += 1;
        }
        reasons
    }
}

fn write_list(out: &mut String, name: &str, items: impl Iterator<Item = String>) -> fmt::Result {
    let items: Vec<String> = items.collect();
    match items.is_empty() {
        true => Ok(()),
        false => writeln!(out, "{name}: {}", items.join("; ")),
    }
}

fn capitalize(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}

fn write_case(case: &CaseResult, texts: &SuiteTexts, out: &mut String) -> fmt::Result {
    let weak = if case.weak { ", weakly" } else { "" };
    let CaseResult { id, outcome, .. } = case;
    writeln!(out, "{id}: {outcome}{weak}  ({})", case.clauses.join(", "))?;
    for line in texts.purpose(id).unwrap_or_default().lines() {
        writeln!(out, "  {line}")?;
    }
    match case.view.as_str() {
        "" => writeln!(out, "  expected: {}", case.expect)?,
        view => writeln!(out, "  expected: {}, requested in {view}", case.expect)?,
    }
    if !case.message.is_empty() {
        writeln!(out, "  {}", case.message)?;
    }
    if !case.stderr.is_empty() {
        writeln!(out, "  its standard error:")?;
    }
    (case.stderr.lines()).try_for_each(|line| writeln!(out, "    {line}"))
}

/// A message, and the failures with that message.
type SimilarFailures<'a> = (&'a str, Vec<&'a CaseResult>);

/// Groups repeated crashes, exceeded limits and other violations by message. The second list contains all other failures.
fn group_violations<'a>(all: &[&'a CaseResult]) -> (Vec<SimilarFailures<'a>>, Vec<&'a CaseResult>) {
    let mut kinds: Vec<SimilarFailures> = Vec::new();
    let mut single = Vec::new();
    for &case in all {
        let says = case.message.as_str();
        let is_start = |prefix| says.starts_with(prefix);
        match kinds.iter_mut().find(|(kind, _)| *kind == says) {
            Some((_, cases)) => cases.push(case),
            None if VIOLATION_PREFIXES.split('|').any(is_start) => {
                kinds.push((says, vec![case]));
            }
            None => single.push(case),
        }
    }
    let (alike, rare): (Vec<_>, Vec<_>) = kinds.into_iter().partition(|(_, cases)| cases.len() > 2);
    single.extend(rare.into_iter().flat_map(|(_, cases)| cases));
    (alike, single)
}

/// Prefixes of messages about answers that are neither an image nor a refusal; see
/// [`Answer::name`](ptm_suite::protocol::frame::Answer::name).
const VIOLATION_PREFIXES: &str = "protocol error: |crash: |exceeds the time limit |flood: |out of memory: |tampering: |not started: ";
