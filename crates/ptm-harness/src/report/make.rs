//! Converts a run and its diagnoses to a report.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fmt::Display;
use std::path::Path;

use crate::diagnose::{Accompanying, Cause, Diagnosis};
use crate::report::document::{
    CaseResult, DecoderInfo, FollowedReading, LikelyCause, Report, SCHEMA, Tool, Verdict,
};
use crate::report::leniency::{leniency, passing_case_ids};
use crate::session::remark::Remark;
use crate::session::run::{Run, RunOf};
use crate::session::texture::TextureRun;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Expect, Suite};
use ptm_suite::compare::{FlatBlocks, LOSSY_TOLERANCE};
use ptm_suite::dialect::{Choices, Dialect};
use ptm_suite::name::SuiteName;
use ptm_suite::test_case::{Allowance, Listed, TestCase};
use ptm_suite::texture::{self, cases::TextureCase};
use ptm_suite::verdicts::dialect::{Certainty, DependentAnswers};
use ptm_suite::verdicts::observation::Response;
use ptm_suite::verdicts::outcome::Outcome;

impl Report {
    /// Creates the report on `run`, without causes. Directories are removed from `command`.
    #[must_use]
    pub fn new<C: TestCase>(
        suite: &Suite<C>,
        run: &RunOf<C>,
        command: &[String],
        limits: Vec<String>,
    ) -> Report {
        let mut dialect = table_readings(suite, run);
        let answers = DependentAnswers::new(suite, &run.observations);
        let is_right = |i: usize, dialect: &Dialect| answers.is_right(i, dialect);
        dialect.extend(followed_readings(suite, run, &C::CHOICES, is_right));
        Report {
            lenient: leniency(suite, run),
            ..report(suite, run, |i| suite.features(i), dialect, command, limits)
        }
    }

    /// Creates the report on a texture stage.
    #[must_use]
    pub fn on_texture_stage(
        suite: &Suite<TextureCase>,
        run: &TextureRun,
        command: &[String],
        limits: Vec<String>,
    ) -> Report {
        let is_right = |i: usize, dialect: &Dialect| {
            let (case, seen) = (&suite.cases[i], run.observations[i].as_ref());
            let Some(Response::Image { frame, .. }) = seen.map(|seen| &seen.response) else {
                return false;
            };
            let answer = frame.as_ref().unwrap_or(&case.expect);
            case.expected(dialect).difference(answer).is_none()
        };
        let dialect = followed_readings(suite, run, &texture::choices::CHOICES, is_right);
        let features = |i: usize| suite.cases[i].features();
        report(suite, run, features, dialect, command, limits)
    }

    /// Replaces the likely causes of the report with `diagnoses`.
    #[must_use]
    pub fn with_diagnoses<C: Listed, A: 'static>(
        mut self,
        suite: &Suite<C>,
        diagnoses: &[Diagnosis<A>],
    ) -> Report {
        self.diagnoses = likely_causes(suite, diagnoses);
        self
    }

    /// Removes the readings of these open questions from the dialect.
    pub fn remove_readings(&mut self, rulings: &[&str]) {
        self.dialect
            .retain(|followed| !rulings.contains(&&*followed.ruling));
    }
}

/// Creates a report on a run of any suite. `features` returns the features that a decoder may need for a case.
fn report<C, V, T, D, F>(
    suite: &Suite<C>,
    run: &Run<V, T, D, F>,
    features: impl Fn(usize) -> BTreeSet<F>,
    dialect: Vec<FollowedReading>,
    command: &[String],
    limits: Vec<String>,
) -> Report
where
    C: Listed,
    V: Display,
    F: Display + Ord,
{
    let verdict = match run.exit_status() {
        0 => Verdict::Pass,
        1 => Verdict::Fail,
        _ => match C::SUITE {
            SuiteName::Ptm | SuiteName::Texture => Verdict::NotADecoder,
            SuiteName::Writers | SuiteName::Fitters => Verdict::NotAWriter,
        },
    };
    let name = |word| Path::new(word).file_name().unwrap_or(OsStr::new(word));
    let words: Vec<_> = (command.iter().map(|word| name(word).to_string_lossy())).collect();
    let views = run.offer.views.iter();
    let decoded = run.judgment.decoded.iter();
    let remarks = run.remarks.iter().cloned();
    Report {
        schema: SCHEMA,
        suite: C::SUITE,
        tool: Tool {
            name: "ptm-conform".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            corpus: C::digest(suite),
            limits,
        },
        decoder: DecoderInfo {
            command: words.join(" "),
            name: None,
            version: None,
            mode: "one-shot".to_owned(),
            views: views.map(|&view| view.to_owned()).collect(),
            decodes: decoded.map(ToString::to_string).collect(),
            unsupported: unsupported(run, &features),
        },
        verdict,
        reason: run.not_a_decoder.clone(),
        scores: run.scores(features),
        remarks: remarks.chain(tolerance_remarks(run)).collect(),
        not_asked: run
            .not_asked
            .iter()
            .map(|(feature, cases)| (feature.to_string(), cases.len()))
            .collect(),
        dialect,
        lenient: Vec::new(),
        baseline: None,
        diagnoses: Vec::new(),
        results_digest: None,
        cases: case_results(suite, run),
    }
}

fn case_results<C: Listed, V: Display, T, D, F>(
    suite: &Suite<C>,
    run: &Run<V, T, D, F>,
) -> Vec<CaseResult> {
    let mut results = Vec::new();
    let observed = run.judgment.cases.iter().zip(&run.observations);
    for (case, (judged, observation)) in suite.cases.iter().zip(observed) {
        let Some(judged) = judged else { continue };
        let observation = observation.as_ref();
        let failed = observation.filter(|_| judged.outcome == Outcome::Fail);
        results.push(CaseResult {
            id: case.id().to_owned(),
            outcome: judged.outcome,
            view: observation.map_or_else(String::new, |observation| observation.view.to_string()),
            expect: case.expectation_name().to_owned(),
            clauses: case.clauses().to_vec(),
            message: judged.message.clone(),
            weak: observation.is_some_and(|observation| observation.weak),
            stderr: failed.map_or_else(String::new, |observation| observation.stderr.clone()),
        });
    }
    results
}

/// Returns the decoder's reading of each settled choice, with the cases that demonstrate the reading: their images are wrong in
/// another reading. `is_right` returns true if the image of a case is right in a dialect.
fn followed_readings<C: Listed, V, T, D, F, R>(
    suite: &Suite<C>,
    run: &Run<V, T, D, F>,
    choices: &Choices<R>,
    is_right: impl Fn(usize, &Dialect) -> bool,
) -> Vec<FollowedReading> {
    let mut readings = Vec::new();
    for (axis, choice) in choices.iter().enumerate() {
        if run.judgment.certainties[axis] != Certainty::Settled {
            continue;
        }
        let is_wrong_in = |i: usize, reading: usize| {
            let mut other = run.judgment.dialect.clone();
            other.0[axis] = reading;
            !is_right(i, &other)
        };
        let shows = |i: usize| {
            let observation = run.observations[i].as_ref();
            let is_about = matches!(
                observation.map(|observation| &observation.response),
                Some(Response::Image { right, .. }) if right.axes().contains(&axis)
            );
            is_about && (0..choice.readings.len()).any(|reading| is_wrong_in(i, reading))
        };
        readings.push(FollowedReading {
            ruling: choice.ruling.to_owned(),
            reading: choice.readings[run.judgment.dialect.0[axis]].0.to_owned(),
            shown_by: passing_case_ids(suite, run, shows),
        });
    }
    readings
}

/// Returns the table spelling that the decoder reads, if it decodes tables. If files that test a spelling were requested, it must
/// decode one of them. The spelling determines only which files are sent to
/// the decoder, not which answers are correct.
fn table_readings<C: TestCase>(suite: &Suite<C>, run: &RunOf<C>) -> Vec<FollowedReading> {
    let decoded = &run.judgment.decoded;
    let mut cases = suite.cases.iter();
    if !cases.any(|case| case.has_table() && decoded.contains(&case.kind())) {
        return Vec::new();
    }
    let newline = if run.table.newline {
        "one line feed"
    } else {
        "nothing"
    };
    let readings = [
        ("lut-count", run.table.count.name()),
        ("lut-newline", newline),
    ];
    let is_asked =
        |&i: &usize| suite.cases[i].expect() == Expect::Spelling && run.observations[i].is_some();
    let mut asked = (0..suite.cases.len()).filter(is_asked);
    if asked.next().is_some() && !run.shows_table_spelling(suite) {
        return Vec::new();
    }
    readings
        .map(|(ruling, reading)| FollowedReading {
            ruling: ruling.to_owned(),
            reading: reading.to_owned(),
            shown_by: passing_case_ids(suite, run, |i| run.is_image_in_table_spelling(suite, i)),
        })
        .into()
}

/// Returns everything for which the decoder always exits with status 69: features, and views of individual kinds of cases. This includes
/// features that only cases need that were not requested because they also need a lacking one.
fn unsupported<V, T, D, F: Display + Ord>(
    run: &Run<V, T, D, F>,
    features: impl Fn(usize) -> BTreeSet<F>,
) -> Vec<String> {
    let not_asked = run.not_asked.iter().flat_map(|(_, cases)| cases);
    let not_asked: BTreeSet<F> = not_asked.flat_map(|&i| features(i)).collect();
    let lacking = not_asked.difference(&run.judgment.decoded);
    let all: BTreeSet<&F> = run.judgment.unsupported.iter().chain(lacking).collect();
    let mut names: Vec<String> = all.into_iter().map(ToString::to_string).collect();
    for (view, kind) in &run.offer.missing_views {
        let name = format!("{view} of {kind}");
        // The colors of LUM are already listed as a feature.
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Minimum mean difference, in levels, in flat JPEG blocks that is reported. An inverse DCT that truncates is half a level below.
const MIN_SYSTEMATIC_ERROR: f64 = 0.25;

/// Returns remarks on images that were compared with a tolerance larger than rounding requires.
fn tolerance_remarks<V, T, D, F>(
    run: &Run<V, T, D, F>,
) -> impl Iterator<Item = Remark> + use<V, T, D, F> {
    let others = "raw images of lossy JPEG planes differ from the reference within the tolerance; a different inverse DCT or a small mistake may be the reason";
    let lossy = format!(
        "responses are JPEG images, which are lossy, so the tolerance is larger by {LOSSY_TOLERANCE} and small mistakes are not found"
    );
    let (mut transforms, mut jpegs, mut flat) = (0, 0, FlatBlocks::default());
    for seen in run.observations.iter().flatten() {
        match seen.response {
            Response::Image {
                allowance: Allowance::AnotherTransform(blocks),
                ..
            } => {
                transforms += 1;
                flat.samples += blocks.samples;
                flat.sum += blocks.sum;
            }
            Response::Image {
                allowance: Allowance::Lossy,
                ..
            } => jpegs += 1,
            _ => {}
        }
    }
    let counted =
        |count: usize, says: &str| (count > 0).then(|| Remark::note(format!("{count} {says}")));
    let mean = f64::from(flat.sum) / f64::from(flat.samples.max(1));
    let systematic = (mean.abs() >= MIN_SYSTEMATIC_ERROR).then(|| {
        let direction = if mean < 0.0 { "below" } else { "above" };
        Remark::note(format!(
            "{} samples in flat blocks of JPEG planes are {:.2} {direction} the reference on average; each is within the tolerance, but together they show a transform that does not round to the nearest integer",
            flat.samples,
            mean.abs()
        ))
    });
    [
        counted(transforms, others),
        counted(jpegs, &lossy),
        systematic,
    ]
    .into_iter()
    .flatten()
}

/// Converts diagnoses to the likely causes listed in a report.
pub fn likely_causes<C: Listed, A: 'static>(
    suite: &Suite<C>,
    diagnoses: &[Diagnosis<A>],
) -> Vec<LikelyCause> {
    let ids = |case_indices: &[usize]| -> Vec<String> {
        (case_indices.iter().map(|&i| suite.cases[i].id().to_owned())).collect()
    };
    (diagnoses.iter().map(|diagnosis| cause(&ids, diagnosis))).collect()
}

/// Converts a diagnosis. `ids` returns the ids of the cases with the given indices.
fn cause<A: 'static>(
    ids: &dyn Fn(&[usize]) -> Vec<String>,
    diagnosis: &Diagnosis<A>,
) -> LikelyCause {
    let mut named = named_cause(&diagnosis.cause);
    for other in &diagnosis.accompanying {
        match other {
            Accompanying::Misreading(one) => named.accompanying.push(one.slug.to_owned()),
            Accompanying::Edit(effect) => named.accompanying_edits.push(effect.clone()),
        }
    }
    LikelyCause {
        explains: ids(&diagnosis.explains),
        ..named
    }
}

/// Converts the cause in a diagnosis to the form used in reports.
fn named_cause<A: 'static>(cause: &Cause<A>) -> LikelyCause {
    match cause {
        Cause::Misreading {
            misreading,
            equivalents,
        } => LikelyCause {
            misreading: Some(misreading.slug.to_owned()),
            clause: Some(misreading.clause.to_owned()),
            effect: misreading.effect.to_owned(),
            fix: misreading.fix.to_owned(),
            equivalents: slugs(equivalents),
            ..LikelyCause::default()
        },
        Cause::Described {
            category,
            clause,
            effect,
            fix,
            example,
            equivalents,
        } => LikelyCause {
            kind: Some(*category),
            clause: clause.clone(),
            effect: effect.clone(),
            fix: fix.clone(),
            example: Some(example.clone()),
            equivalents: slugs(equivalents),
            ..LikelyCause::default()
        },
    }
}

fn slugs<A: 'static>(misreadings: &[&Misreading<A>]) -> Vec<String> {
    misreadings.iter().map(|one| one.slug.to_owned()).collect()
}
