//! The report on a texture stage: the one on a decoder, with other cases; and every word that its user reads.

use std::fmt::Write;

use crate::harness::corpus;
use crate::harness::report::{CaseResult, Cause, Reading, Report, Scores, Subject, Tool};
use crate::harness::texture::cases::{Basis, Case, Suite};
use crate::harness::texture::check::Run;
use crate::harness::texture::choices::CHOICES;
use crate::harness::texture::diagnose::Diagnosis;
use crate::harness::texture::judge::{Finding, Judged, Outcome};

/// The report of `run`. `command` is shown as it is given.
#[must_use]
pub fn report(
    suite: &Suite,
    run: &Run,
    diagnoses: &[Diagnosis],
    command: String,
    limits: Vec<String>,
) -> Report {
    let verdict = match run.exit_status() {
        0 => "pass",
        1 => "fail",
        _ => "not a decoder",
    };
    let results = suite
        .cases
        .iter()
        .zip(&run.judgement.cases)
        .zip(&run.findings);
    let results = results.filter_map(|((case, judged), finding)| {
        Some(case_result(case, judged.as_ref()?, finding.as_ref()))
    });
    Report {
        tool: Tool {
            name: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            corpus: digest(suite),
            limits,
        },
        decoder: Subject {
            command,
            name: None,
            version: None,
            mode: "one-shot".to_owned(),
            views: vec!["texture".to_owned()],
            decodes: run.judgement.supported.iter().cloned().collect(),
            unsupported: run.judgement.unsupported.iter().cloned().collect(),
        },
        verdict: verdict.to_owned(),
        reason: run.not_a_decoder.clone(),
        remarks: Vec::new(),
        lenient: Vec::new(),
        baseline: None,
        scores: scores(suite, run),
        dialect: dialect(run),
        diagnoses: diagnoses.iter().map(|one| cause(suite, one)).collect(),
        cases: results.collect(),
    }
}

/// As text for a terminal, at most `shown` failures in full.
#[must_use]
pub fn to_text(report: &Report, suite: &Suite, shown: usize) -> String {
    let mut text = String::new();
    write_text(report, suite, shown, &mut text).expect("writing to memory does not fail");
    text
}

fn write_text(report: &Report, suite: &Suite, shown: usize, out: &mut String) -> std::fmt::Result {
    let Subject { command, .. } = &report.decoder;
    if let Some(reason) = &report.reason {
        writeln!(out, "{command} answers no texture question: {reason}")?;
        writeln!(
            out,
            "It is called as: DECODER texture FILE, for example: {command} texture case.json"
        )?;
        return writeln!(
            out,
            "FILE is a question in JSON, the answer on standard output a JSON object; see spec-cases/texture/README.md."
        );
    }
    let failing: Vec<&CaseResult> = report
        .cases
        .iter()
        .filter(|case| case.outcome == Outcome::Fail.name())
        .collect();
    for cause in &report.diagnoses {
        let (count, all) = (cause.explains.len(), failing.len());
        writeln!(
            out,
            "{count} of {all} failures: the decoder {} ({}).",
            cause.effect, cause.clause
        )?;
        writeln!(
            out,
            "  To mend it: {}. More: ptm-conform explain {}",
            cause.mend,
            cause.misreading.as_deref().unwrap_or_default()
        )?;
        let explained = failing
            .iter()
            .filter(|case| cause.explains.contains(&case.id));
        for case in explained.take(2) {
            write_failure(case, suite, out)?;
        }
        writeln!(out)?;
    }
    let explained = |id: &String| {
        report
            .diagnoses
            .iter()
            .any(|cause| cause.explains.contains(id))
    };
    let others: Vec<&&CaseResult> = failing.iter().filter(|case| !explained(&case.id)).collect();
    if !others.is_empty() {
        let (count, all) = (others.len(), failing.len());
        writeln!(
            out,
            "{count} of {all} failures are like no mistake of the catalogue."
        )?;
        for case in others.iter().take(shown) {
            write_failure(case, suite, out)?;
        }
        if count > shown {
            writeln!(
                out,
                "  … and {} more; the report has them all",
                count - shown
            )?;
        }
        writeln!(out)?;
    }
    if !report.dialect.is_empty() {
        let readings: Vec<String> = report
            .dialect
            .iter()
            .map(|known| format!("{}: {}", known.ruling, known.reading))
            .collect();
        writeln!(out, "dialect: {}", readings.join("; "))?;
    }
    if !report.decoder.unsupported.is_empty() {
        let unsupported = report.decoder.unsupported.join(", ");
        writeln!(out, "unsupported, by its own word: {unsupported}")?;
    }
    let counts: Vec<String> = Outcome::ALL
        .iter()
        .map(|outcome| {
            let with = report
                .cases
                .iter()
                .filter(|one| one.outcome == outcome.name());
            (with.count(), outcome.name())
        })
        .filter(|&(count, _)| count > 0)
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    let selection = if report.cases.len() < suite.cases.len() {
        format!(
            " ({} of {} cases selected)",
            report.cases.len(),
            suite.cases.len()
        )
    } else {
        String::new()
    };
    writeln!(out, "{}: {}{selection}", report.verdict, counts.join(", "))?;
    let Scores {
        correctness,
        breadth,
        robustness,
    } = &report.scores;
    writeln!(
        out,
        "correctness {correctness}, breadth {breadth}, robustness {robustness}"
    )
}

fn write_failure(case: &CaseResult, suite: &Suite, out: &mut String) -> std::fmt::Result {
    writeln!(out, "  FAIL {}  ({})", case.id, case.clauses.join(", "))?;
    writeln!(out, "    {}", case.says.as_deref().unwrap_or_default())?;
    if let Some(case) = suite.case(&case.id) {
        writeln!(out, "    {}: {}", case.op, case.because)?;
        if case.basis == Basis::Inferred {
            writeln!(
                out,
                "    The chapter's formula is lost; ruling {} says what stands for it and why.",
                case.ruling.as_deref().unwrap_or_default()
            )?;
        }
    }
    let stderr = case.stderr.as_ref();
    match stderr.and_then(|stderr| stderr.lines().last()) {
        Some(line) => writeln!(out, "    its standard error ends: {line}"),
        None => Ok(()),
    }
}

fn scores(suite: &Suite, run: &Run) -> Scores {
    let with = |outcome: Outcome| {
        let judged = run.judgement.cases.iter().flatten();
        judged.filter(|judged| judged.outcome == outcome).count()
    };
    let (passed, failed) = (with(Outcome::Pass), with(Outcome::Fail));
    let features: std::collections::BTreeSet<String> =
        suite.cases.iter().flat_map(Case::features).collect();
    Scores {
        correctness: format!("{passed}/{}", passed + failed),
        breadth: format!("{}/{}", run.judgement.supported.len(), features.len()),
        robustness: format!("{}/{}", run.asked - run.misconduct, run.asked),
    }
}

fn dialect(run: &Run) -> Vec<Reading> {
    let chosen = CHOICES
        .iter()
        .zip(run.judgement.dialect)
        .zip(run.judgement.shown);
    chosen
        .filter(|(_, shown)| *shown)
        .map(|((choice, reading), _)| Reading {
            ruling: choice.ruling.to_owned(),
            reading: choice.readings[reading].0.to_owned(),
            shown_by: Vec::new(),
        })
        .collect()
}

fn cause(suite: &Suite, diagnosis: &Diagnosis) -> Cause {
    let explains = diagnosis.explains.iter();
    Cause {
        misreading: Some(diagnosis.misreading.slug.to_owned()),
        clause: diagnosis.misreading.clause.to_owned(),
        effect: diagnosis.misreading.effect.to_owned(),
        mend: diagnosis.misreading.mend.to_owned(),
        explains: explains.map(|&i| suite.cases[i].id.clone()).collect(),
        ..Cause::default()
    }
}

fn case_result(case: &Case, judged: &Judged, finding: Option<&Finding>) -> CaseResult {
    let stderr = finding.map(|finding| finding.stderr.clone());
    CaseResult {
        id: case.id.clone(),
        outcome: judged.outcome.name().to_owned(),
        view: finding.map(|_| "texture".to_owned()),
        expect: expectation(case).to_owned(),
        clauses: case.clauses.clone(),
        weak: false,
        says: Some(judged.says.clone()).filter(|says| !says.is_empty()),
        stderr: stderr.filter(|stderr| judged.outcome == Outcome::Fail && !stderr.is_empty()),
    }
}

/// What is owed: a value, a refusal, one of several values, or any.
fn expectation(case: &Case) -> &'static str {
    match case.basis {
        _ if case.expect.get("error").is_some() => "reject",
        Basis::Reading => "choice",
        Basis::Impl => "implementation-defined",
        Basis::Text | Basis::Sibling | Basis::Inferred => "value",
    }
}

/// A digest of all questions and answers, in order.
fn digest(suite: &Suite) -> String {
    let cases = suite.cases.iter();
    let all: String = cases
        .map(|case| format!("{}{}{}", case.id, case.question(), case.expect))
        .collect();
    corpus::sha256(all.as_bytes())
}
