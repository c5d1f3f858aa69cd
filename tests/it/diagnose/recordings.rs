//! Judges and diagnoses recorded responses of seven public decoders.
//!
//! `tests/it/recordings/` contains the compressed answers of each decoder and `rows.yaml`. For each mistake in the decoder's
//! source code, `rows.yaml` lists the cause that must be named. It also lists false statements that must not be made.

use std::collections::HashMap;

use crate::in_process::{reference_answer, suite};
use crate::recordings::{digest, folder, recorded_answers};
use ptm_harness::diagnose::{Accompanying, Cause, diagnose, diagnose_among};
use ptm_harness::pipeline::judge_answers;
use ptm_harness::session::plan::{Repeat, RunPlan};
use ptm_harness::session::run::Run;
use ptm_mistakes::Misreading;
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::kit::yaml;
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::{Reply, Request};
use ptm_suite::verdicts::outcome::Outcome;
use serde::Deserialize;

/// A decoder, with statements that must and must not be made about it.
#[derive(Deserialize)]
struct Reader {
    name: String,
    rows: Vec<SourceMistake>,
    forbidden: Vec<ForbiddenStatement>,
}

/// A mistake in the source code of a decoder.
#[derive(Deserialize)]
struct SourceMistake {
    mistake: String,
    /// A slug, or part of the effect of a cause. Alternatives are separated by " or ".
    #[serde(default)]
    cause: String,
    /// Minimum number of failing cases listed under the cause.
    #[serde(default)]
    at_least: usize,
    /// Reason why no case can reveal the mistake.
    #[serde(default)]
    omitted: String,
}

/// Parts of a false statement that an earlier version of the program made.
#[derive(Deserialize)]
struct ForbiddenStatement {
    effect: String,
    /// Part of the scope or of the example. It is needed if the effect alone does not make the statement false.
    #[serde(default, rename = "and")]
    context: String,
}

/// A reported cause: the number of cases that it explains, its slug or effect, and its example.
struct ReportedCause {
    count: usize,
    effect: String,
    example: String,
}

impl ForbiddenStatement {
    fn matches(&self, cause: &ReportedCause) -> bool {
        let text = format!("{} {}", cause.effect, cause.example);
        cause.effect.contains(&self.effect) && text.contains(&self.context)
    }
}

/// Replays the recorded run, for all cases whose answers were recorded.
fn replay(suite: &Suite, reader: &str) -> Run {
    let answers = recorded_answers(reader);
    let is_recorded = |case: &Case| {
        TableSpelling::all().any(|table| {
            let file = digest(&case.build(table).file);
            let mut views = case.views.iter();
            views.any(|view| answers.contains_key(&(file.clone(), view.to_string())))
        })
    };
    let withheld = |case: &Case| (!is_recorded(case)).then(|| "no answer was recorded".to_owned());
    let plan = RunPlan {
        repeat: Repeat::Nothing,
        withheld: suite.cases.iter().map(withheld).collect(),
        ..RunPlan::new(suite, 2)
    };
    let ask = |request: &Request<'_>, _: usize| -> Reply {
        let key = (digest(request.file), request.view.to_string());
        let Some(recorded) = answers.get(&key) else {
            return Answer::Unsupported.into();
        };
        // Images that equal the expected ones were not recorded.
        let answer = recorded.answer.clone();
        let answer = answer.unwrap_or_else(|| reference_answer(request));
        Reply {
            stderr: recorded.stderr.clone(),
            exit: recorded.exit,
            ..answer.into()
        }
    };
    judge_answers(suite, &plan, &ask)
}

/// Returns every cause that is reported for a decoder.
fn causes(suite: &Suite, reader: &str) -> Vec<ReportedCause> {
    let run = replay(suite, reader);
    let failures = run.judgment.with_outcome(Outcome::Fail).count();
    let found = diagnose(suite, &run, &[], 2);
    println!(
        "\n{reader}: {failures} failures, {} answers computed in {:?}",
        found.answer_count, found.cpu_time
    );
    let causes = found.diagnoses.into_iter().map(|diagnosis| {
        let (effect, example) = match diagnosis.cause {
            Cause::Misreading { misreading, .. } => {
                let with = diagnosis.accompanying.iter().map(|other| match other {
                    Accompanying::Misreading(other) => format!(" with {}", other.slug),
                    Accompanying::Edit(effect) => format!(" with \"{effect}\""),
                });
                let with: String = with.collect();
                (format!("{}{with}", misreading.slug), String::new())
            }
            Cause::Described {
                effect,
                example,
                equivalents,
                ..
            } => {
                let like = equivalents
                    .iter()
                    .map(|other| format!(" like {}", other.slug));
                let like: String = like.collect();
                (format!("{effect}{like}"), example)
            }
        };
        let cause = ReportedCause {
            count: diagnosis.explains.len(),
            effect,
            example,
        };
        println!(
            "  {:>4} {}\n         {}",
            cause.count, cause.effect, cause.example
        );
        cause
    });
    causes.collect()
}

fn readers() -> Vec<Reader> {
    let text = std::fs::read_to_string(folder().join("rows.yaml")).expect("rows.yaml");
    yaml::from_yaml(&text).expect("rows.yaml is valid")
}

#[test]
fn mistakes_of_seven_readers_are_named_without_false_statements() {
    let suite = suite().with_prepared_files();
    let mut missed = Vec::new();
    for reader in readers() {
        let causes = causes(&suite, &reader.name);
        for row in reader.rows.iter().filter(|row| row.omitted.is_empty()) {
            let is_named = |cause: &&ReportedCause| {
                let mut alternatives = row.cause.split(" or ");
                alternatives.any(|part| cause.effect.contains(part))
            };
            let named = causes.iter().filter(is_named);
            let count: usize = named.map(|cause| cause.count).sum();
            println!(
                "  {:<6} {:<40} {count} of {}",
                row.mistake, row.cause, row.at_least
            );
            if count < row.at_least.max(1) {
                missed.push(format!(
                    "{}: {} ({}), {count}",
                    reader.name, row.mistake, row.cause
                ));
            }
        }
        for forbidden in &reader.forbidden {
            let made = causes.iter().filter(|cause| forbidden.matches(cause));
            missed.extend(made.map(|cause| format!("{}: false: {}", reader.name, cause.effect)));
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// The renderer lights PTM files in a fragment shader, with coefficients in RGBA8 textures and an RGBA8 framebuffer.
#[test]
fn renderer_on_a_gpu_passes() {
    let suite = suite().with_prepared_files();
    let run = replay(&suite, "h200-opengl-ptm-rgba8-framebuffer");
    let failing = run.judgment.with_outcome(Outcome::Fail);
    let failing: Vec<&str> = failing.map(|i| suite.cases[i].id.as_str()).collect();
    assert!(failing.is_empty(), "{failing:?}");
    assert_eq!(run.exit_status(), 0);
    let passing = run.judgment.with_outcome(Outcome::Pass).count();
    assert!(passing > 1700, "{passing}");
}

/// Returns the decisions about a recorded run: the cases of each outcome, and the cases of each cause, which is identified by its
/// name, or by its category and clause.
fn decisions(
    suite: &Suite,
    catalog: &[&'static Misreading],
    run: &Run,
) -> Vec<(String, Vec<usize>)> {
    let with_outcome = |one| run.judgment.with_outcome(one).collect();
    let outcomes = Outcome::ALL.map(|one| (one.name().to_owned(), with_outcome(one)));
    let diagnoses = diagnose_among(catalog, suite, run, &[], 2).diagnoses;
    let causes = diagnoses.into_iter().map(|diagnosis| {
        let name = match &diagnosis.cause {
            Cause::Misreading { misreading, .. } => misreading.slug.to_owned(),
            Cause::Described {
                category, clause, ..
            } => format!("{} {clause:?}", category.name()),
        };
        (name, diagnosis.explains)
    });
    outcomes.into_iter().chain(causes).collect()
}

/// Replaces the purposes of cases, the texts of misreadings and the messages by ids. The decisions must be the same.
#[test]
fn decisions_do_not_depend_on_texts() {
    let suite = suite().with_prepared_files();
    let mut with_ids = suite.clone();
    for case in &mut with_ids.cases {
        case.because.clone_from(&case.id);
    }
    let catalog: Vec<&Misreading> = ptm_mistakes::all().collect();
    let catalog_with_ids = ptm_mistakes::all().map(|one| -> &Misreading {
        Box::leak(Box::new(Misreading {
            effect: one.slug,
            fix: one.slug,
            ..one.clone()
        }))
    });
    let catalog_with_ids: Vec<&Misreading> = catalog_with_ids.collect();
    for reader in ["relight", "oxrti"] {
        let run = replay(&suite, reader);
        let mut run_with_ids = replay(&with_ids, reader);
        for verdict in run_with_ids.judgment.cases.iter_mut().flatten() {
            verdict.message = verdict.outcome.name().to_owned();
        }
        let expected = decisions(&suite, &catalog, &run);
        assert!(expected.len() > Outcome::ALL.len(), "{reader}: no cause");
        assert_eq!(
            decisions(&with_ids, &catalog_with_ids, &run_with_ids),
            expected
        );
    }
}

/// A forbidden statement that never matches would prove nothing, so each must match earlier output of the program.
#[test]
fn forbidden_statements_match_earlier_output() {
    let text = std::fs::read_to_string(folder().join("before.yaml")).expect("before.yaml");
    let before: HashMap<String, Vec<[String; 2]>> =
        yaml::from_yaml(&text).expect("before.yaml is valid");
    for reader in readers() {
        let causes = before[&reader.name]
            .iter()
            .map(|[effect, example]| ReportedCause {
                count: 0,
                effect: effect.clone(),
                example: example.clone(),
            });
        let causes: Vec<ReportedCause> = causes.collect();
        for forbidden in &reader.forbidden {
            let matches = causes.iter().any(|cause| forbidden.matches(cause));
            assert!(
                matches,
                "{}: {} matches nothing",
                reader.name, forbidden.effect
            );
        }
    }
}

/// Returns the part of a report in `reports/readers` that is computed from the run.
fn report_text(suite: &Suite, run: &Run) -> String {
    let views = run.offer.views.join(", ");
    let mut text = format!(
        "views: [{views}]\nsuite: \"{}\"\ncases: {}\noutcomes:\n",
        env!("CARGO_PKG_VERSION"),
        suite.cases.len()
    );
    for outcome in Outcome::ALL
        .into_iter()
        .filter(|&outcome| outcome != Outcome::Pass)
    {
        let mut cases = run.judgment.with_outcome(outcome).peekable();
        if cases.peek().is_some() {
            text.extend(["  ", outcome.name(), ":\n"]);
        }
        text.extend(cases.map(|i| format!("    - {}\n", suite.cases[i].id)));
    }
    text
}

/// `WRITE_REPORTS=1` updates the reports.
#[test]
fn reports_of_readers_match_their_recordings() {
    let suite = suite().with_prepared_files();
    for reader in readers() {
        let path = format!(
            "{}/reports/readers/{}.yaml",
            env!("CARGO_MANIFEST_DIR"),
            reader.name
        );
        let text = std::fs::read_to_string(&path).expect("a report");
        let (facts, published) = text.split_at(text.find("views:").expect("views"));
        let report_text = report_text(&suite, &replay(&suite, &reader.name));
        if std::env::var_os("WRITE_REPORTS").is_some() {
            std::fs::write(&path, format!("{facts}{report_text}")).expect("the report is written");
        } else {
            assert_eq!(published, report_text, "{}", reader.name);
        }
    }
}
