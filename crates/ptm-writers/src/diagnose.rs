//! Finds mistakes that explain why files from a writer are wrong.
//!
//! A mistake explains a wrong file if only a reader with this mistake sees the right values in the file, or if the file contains
//! the values that this reader sees in the reference's file. A correct file contradicts the mistake if this reader misreads the
//! reference's file. Single mistakes are tried first, then pairs of mistakes. Other failures are only described.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use crate::fault::{FaultKind, WriterFault};
use crate::misread_file::{MisreadFile, explains, is_right_only_with};
use crate::test_case::{FileCase, RequestValues, wrong_file};
use crate::{reference::write_requested_file, request::WriteRequest};
use ptm::Format;
use ptm_generate::Recipe;
use ptm_harness::diagnose::cover::{CoverCandidate, cover};
use ptm_harness::diagnose::{Accompanying, Category, Cause, Diagnosis, can_combine};
use ptm_harness::session::run::RunOf;
use ptm_mistakes::Misreading;
use ptm_mistakes::writing::{self, WriterMistake};
use ptm_suite::cases::Suite;
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::verdicts::outcome::Outcome;

/// Maximum size in bytes of the files that are searched for mistakes.
const MAX_FILE_BYTES: usize = 100_000;

/// Number of wrong files per format that are tried first, smallest first. A mistake that explains none of them is skipped.
const SCREENED_FILES: usize = 3;

/// Number of unexplained files, smallest first, for which pairs of mistakes are tried.
const PAIR_SEARCH_FILES: usize = 4;

/// Diagnosed cause of a writer's failures.
type WriterDiagnosis = Diagnosis<&'static Misreading>;

/// Request with two files: the file that the reference writes, and the file to examine. The file to examine is the wrong file
/// that was written for the request, or else a copy of the file from the reference.
struct Attempt {
    request: WriteRequest,
    /// File that the reference writes.
    reference_file: Vec<u8>,
    file: Vec<u8>,
}

/// Attempts that are small enough to search, by case index.
type Attempts = BTreeMap<usize, Attempt>;

/// Returns the causes of the failures of `run`: single mistakes, then pairs, then descriptions of the other differences.
#[must_use]
pub fn diagnose(
    suite: &Suite<FileCase<Recipe>>,
    run: &RunOf<FileCase<Recipe>>,
    threads: usize,
) -> Vec<WriterDiagnosis> {
    let mut failing: Vec<usize> = run.judgment.with_outcome(Outcome::Fail).collect();
    if failing.is_empty() {
        return Vec::new();
    }
    let attempt = |index: usize| attempt(suite, run, index);
    let attempts = map_in_parallel(suite.cases.len(), threads, &|_, _| (), &attempt);
    let attempts = attempts.into_iter().enumerate();
    let attempts: Attempts = attempts
        .filter_map(|(i, attempt)| Some((i, attempt?)))
        .collect();
    let passing: Vec<usize> = run.judgment.with_outcome(Outcome::Pass).collect();
    let single = single_mistakes(&attempts, &failing, &passing, threads);
    let single = cover(single, &mut failing).into_iter();
    let mut diagnoses: Vec<WriterDiagnosis> = single.map(CoverCandidate::diagnosis).collect();
    let pairs = mistake_pairs(&attempts, &failing, &passing, threads);
    diagnoses.extend(cover(pairs, &mut failing).into_iter().map(|pair| {
        let (misreading, second) = pair.cause;
        let cause = Cause::Misreading {
            misreading,
            equivalents: Vec::new(),
        };
        Diagnosis {
            accompanying: vec![Accompanying::Misreading(second)],
            is_mechanism: true,
            ..Diagnosis::new(cause, pair.explains)
        }
    }));
    diagnoses.extend(describe_differences(suite, run, &failing));
    diagnoses
}

/// Returns the attempt for a request, or `None` if a file is too large or the reference cannot write it.
fn attempt(
    suite: &Suite<FileCase<Recipe>>,
    run: &RunOf<FileCase<Recipe>>,
    index: usize,
) -> Option<Attempt> {
    let request = suite.cases[index].request();
    let reference_file = write_requested_file(&request).ok()?;
    let wrong = wrong_file(run.observations[index].as_ref());
    let file = wrong.map_or(&reference_file[..], |(file, _)| file).to_vec();
    let is_small = reference_file.len().max(file.len()) <= MAX_FILE_BYTES;
    is_small.then_some(Attempt {
        request,
        reference_file,
        file,
    })
}

/// Returns the failing attempts whose reference files are smallest, at most [`SCREENED_FILES`] per format.
fn smallest_attempts<'a>(attempts: &'a Attempts, failing: &[usize]) -> Vec<&'a Attempt> {
    let mut smallest: Vec<&Attempt> = failing.iter().filter_map(|i| attempts.get(i)).collect();
    smallest.sort_by_key(|attempt| attempt.reference_file.len());
    let mut counts: BTreeMap<Format, usize> = BTreeMap::new();
    smallest.retain(|attempt| {
        let count = counts.entry(attempt.request.format).or_default();
        *count += 1;
        *count <= SCREENED_FILES
    });
    smallest
}

/// Returns true if a reader with these mistakes misreads the right file, so that a writer with the mistakes would write another.
fn misreads_right_file(attempt: &Attempt, mistakes: &[&Misreading]) -> bool {
    let seen = MisreadFile::new(&attempt.reference_file, mistakes);
    // Within the loss, a wrong file may look right.
    !attempt.request.is_lossy() && seen.is_some_and(|seen| !seen.is_right(&attempt.request))
}

/// Returns single mistakes that explain failures and that no passing case contradicts.
fn single_mistakes(
    attempts: &Attempts,
    failing: &[usize],
    passing: &[usize],
    threads: usize,
) -> Vec<CoverCandidate<&'static WriterMistake>> {
    let mistakes: Vec<&'static WriterMistake> = writing::all().collect();
    let screen = smallest_attempts(attempts, failing);
    let candidate = |i: usize| {
        let mistake = mistakes[i];
        let explains =
            |a: &Attempt| explains(&a.request, &a.reference_file, &a.file, mistake.change);
        let contradicts = |a: &Attempt| misreads_right_file(a, &[mistake.change]);
        if !screen.iter().any(|attempt| explains(attempt)) {
            return None;
        }
        let explains = |index: usize| attempts.get(&index).is_some_and(explains);
        let contradicts = |index: usize| attempts.get(&index).is_some_and(contradicts);
        CoverCandidate::new(mistake, failing, explains, passing, contradicts)
    };
    let found = map_in_parallel(mistakes.len(), threads, &|_, _| (), &candidate);
    found.into_iter().flatten().collect()
}

/// Returns pairs of mistakes that explain one of the smallest failing files and a quarter of all, and that no passing case
/// contradicts.
fn mistake_pairs(
    attempts: &Attempts,
    failing: &[usize],
    passing: &[usize],
    threads: usize,
) -> Vec<CoverCandidate<(&'static WriterMistake, &'static WriterMistake)>> {
    let mistakes: Vec<&'static WriterMistake> = writing::all().collect();
    let explains = |Attempt { request, file, .. }: &Attempt, pair: [&WriterMistake; 2]| {
        is_right_only_with(request, file, &pair.map(|mistake| mistake.change))
    };
    let pair = |attempt: &Attempt| {
        let with_first = |i: usize| {
            let first = mistakes[i];
            let mut seconds = mistakes[i + 1..].iter().copied();
            let second = seconds.find(|second| {
                can_combine(first.change, second.change) && explains(attempt, [first, second])
            });
            second.map(|second| (first, second))
        };
        let found = map_in_parallel(mistakes.len(), threads, &|_, _| (), &with_first);
        let (first, second) = found.into_iter().flatten().next()?;
        let is_explained = |attempt: &Attempt| explains(attempt, [first, second]);
        let explains = |index: usize| attempts.get(&index).is_some_and(is_explained);
        let is_misread =
            |attempt: &Attempt| misreads_right_file(attempt, &[first.change, second.change]);
        let contradicts = |index: usize| attempts.get(&index).is_some_and(is_misread);
        CoverCandidate::new((first, second), failing, explains, passing, contradicts)
            .filter(|pair| 4 * pair.explains.len() >= failing.len())
    };
    let smallest = smallest_attempts(attempts, failing).into_iter();
    smallest.take(PAIR_SEARCH_FILES).filter_map(pair).collect()
}

/// Describes the failures that no mistake in the catalog explains, grouped by the clause of the first difference.
pub(super) fn describe_differences<V: RequestValues>(
    suite: &Suite<FileCase<V>>,
    run: &RunOf<FileCase<V>>,
    failing: &[usize],
) -> Vec<WriterDiagnosis> {
    let mut groups: BTreeMap<(FaultKind, &str, &str), Vec<(usize, &WriterFault)>> = BTreeMap::new();
    for &index in failing {
        if let Some((_, fault)) = wrong_file(run.observations[index].as_ref()) {
            let group = groups
                .entry((fault.kind, &fault.clause, fault.fix))
                .or_default();
            group.push((index, fault));
        }
    }
    let mut diagnoses: Vec<WriterDiagnosis> = groups
        .into_iter()
        .map(|((_, clause, _), faults)| {
            let (index, fault) = faults[0];
            let example = format!("for example {}: {fault}", suite.cases[index].id);
            let cause = describe(clause, effect_and_fix(clause, fault), example);
            Diagnosis::new(cause, faults.iter().map(|&(index, _)| index).collect())
        })
        .collect();
    diagnoses.sort_by_key(|diagnosis| Reverse(diagnosis.explains.len()));
    diagnoses
}

pub(super) fn describe<A>(clause: &str, (effect, fix): (&str, &str), example: String) -> Cause<A> {
    Cause::Described {
        category: Category::Difference,
        clause: (!clause.is_empty()).then(|| clause.to_owned()),
        effect: effect.to_owned(),
        fix: fix.to_owned(),
        example,
        equivalents: Vec::new(),
    }
}

fn or_default(text: &'static str, default: &'static str) -> &'static str {
    if text.is_empty() { default } else { text }
}

fn effect_and_fix(clause: &str, fault: &WriterFault) -> (&'static str, &'static str) {
    match fault.kind {
        FaultKind::Refused => {
            let effect = "writes files that the reference refuses";
            return (
                effect,
                or_default(fault.fix, "check the byte that the example names"),
            );
        }
        FaultKind::LintError => {
            let effect =
                "writes files in which lint finds an error, although their values are right";
            return (effect, or_default(fault.fix, "see the example"));
        }
        FaultKind::Different => {}
    }
    let effect = match clause {
        "1.0/1" => "fits the images worse than the best possible map",
        "2.2/1" => "writes a different format than requested",
        "2.3/1" => "writes a different size than requested",
        "2.4/3" => "writes different scales than requested",
        "2.4/4" => "writes different biases than requested",
        "2.6/2" => "writes a different matrix than requested",
        "2.9.1/1" => "exceeds the loss that the parameter allows, or writes a different parameter",
        "2.9.8/4" => {
            "writes no side information for texels that wrap around because of lossy compression"
        }
        "2.9.8/8" => "writes wrong values into side information",
        _ => "writes different values than requested",
    };
    let fix = match clause {
        "1.0/1" => "compare the images under the light direction in the example",
        "2.2/1" => "write the format of the request, or exit with 69",
        "2.3/1" => "write the width, then the height",
        "2.4/3" => "write all digits of the six scales, in the order of the coefficients",
        "2.4/4" => "write the six biases unchanged, including their signs",
        "2.6/2" => "write all digits of the sixteen numbers, in the order of the request",
        "2.9.1/1" => {
            "predict from the planes as a decoder reconstructs them, and use the parameter in the request"
        }
        "2.9.8/4" => {
            "write a record for every texel that wraps around because of lossy compression"
        }
        "2.9.8/8" => "write the value that the texel has in the request",
        _ => "compare the bytes in the example with the request",
    };
    (effect, fix)
}
