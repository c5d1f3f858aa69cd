//! Tests of the texture suite: the cases are correct, and the suite catches and distinguishes mistakes.

use std::collections::{BTreeMap, HashMap, HashSet};

use ptm_harness::diagnose::{Cause, Diagnosis, texture::diagnose};
use ptm_harness::pipeline::texture::judge_answers;
use ptm_harness::session::plan::RunPlan;
use ptm_harness::session::texture::TextureRun;
use ptm_harness::strength::matrix::texture_matrix;
use ptm_mistakes::{Misreading, texture as misreadings};
use ptm_suite::cases::Suite;
use ptm_suite::clauses::{ClauseStatus, Ruling, RulingKind};
use ptm_suite::protocol::frame::Answer;
use ptm_suite::protocol::request::Request;
use ptm_suite::texture::cases::{self, Basis, TextureCase, TextureView};
use ptm_suite::texture::question::{OPERATIONS, Question, Refusal};
use ptm_suite::texture::verify::verify;
use ptm_suite::texture::{choices::CHOICES, compare::ExpectedAnswer};
use ptm_suite::verdicts::outcome::Outcome;
use ptm_texture::map::texel_color;
use ptm_texture::{Boundary, ClampMethod, RenderingControl, Rules, sample};
use serde_json::Value;

use crate::table::rows;

fn suite() -> Suite<TextureCase> {
    Suite::load_texture().expect("the suite loads")
}

fn run(
    suite: &Suite<TextureCase>,
    ask: impl Fn(&TextureCase) -> Answer<Value> + Sync,
) -> TextureRun {
    let ask = |request: &Request<'_, TextureView>, _: usize| {
        ask(suite.case(request.name).expect("the case exists")).into()
    };
    judge_answers(suite, &RunPlan::new(suite, 1), &ask)
}

fn cases_with_outcome(
    suite: &Suite<TextureCase>,
    run: &TextureRun,
    wanted: Outcome,
) -> Vec<String> {
    let cases = run.judgment.with_outcome(wanted);
    cases.map(|i| suite.cases[i].id.clone()).collect()
}

#[test]
fn reference_gives_every_expected_answer() {
    let suite = suite();
    for line in suite.cases.iter().flat_map(verify) {
        let says = format!("{} {:?}: {}", line.id, line.reading, line.message);
        assert_eq!(line.agrees, Some(true), "{says}");
    }
}

#[test]
fn every_misreading_is_caught_by_a_case_about_it_and_differs_from_every_other() {
    let suite = suite();
    let rows = texture_matrix(&suite, 2);
    println!("{} misreadings, {} cases", rows.len(), suite.cases.len());
    assert!(rows.len() >= 40);
    // A requirement is tested if a case about it catches a misreading.
    let killers = rows.iter().flat_map(|row| &row.killed_by);
    let caught: HashSet<&String> = killers.flat_map(|&i| &suite.cases[i].clauses).collect();
    let mut weak = Vec::new();
    for clause in cases::clauses().expect("the requirements load") {
        let mut judged = suite.cases.iter().filter(|case| case.basis != Basis::Impl);
        if judged.any(|case| case.clauses.contains(&clause.id)) && !caught.contains(&clause.id) {
            weak.push(format!("no case about {} catches a misreading", clause.id));
        }
    }
    let mut known: HashMap<&[u64], &str> = HashMap::new();
    let mut alike = Vec::new();
    for row in &rows {
        let clause = row.misreading.clause;
        let mut killers = row.killed_by.iter().map(|&i| &suite.cases[i]);
        if !killers.any(|case| case.clauses.iter().any(|id| id == clause)) {
            let slug = row.misreading.slug;
            weak.push(format!("{slug} is caught by no case about {clause}"));
        }
        if let Some(other) = known.insert(&row.answers, row.misreading.slug) {
            alike.push((other, row.misreading.slug));
        }
    }
    assert!(weak.is_empty(), "{weak:#?}");
    assert!(alike.is_empty(), "equal answers to every case: {alike:?}");
}

/// Returns the tolerance of the number that separates another answer best, as a multiple of half the distance between the answers:
/// 0 if the answers differ in a word or in their shape, and infinity if they are equal.
fn tolerance_ratio(expected: &ExpectedAnswer, other: &Value) -> f64 {
    let fields = expected.answer.as_object().expect("an object");
    let ratios = fields.iter().map(|(name, value)| {
        let tolerance = &expected.filter_tolerance[name];
        match other.get(name) {
            Some(other) => ratio_of_values(name, value, other, tolerance),
            None => 0.0,
        }
    });
    ratios.fold(f64::INFINITY, f64::min)
}

fn ratio_of_values(name: &str, a: &Value, b: &Value, filter: &Value) -> f64 {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a number"), b.as_f64().expect("a number"));
            let mut distance = (a - b).abs();
            if name == "color" {
                // Both colors may be clamped.
                distance = distance.min((a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).abs());
            }
            let arithmetic = 1e-5 * a.abs().max(b.abs()) + 1e-6;
            let tolerance = arithmetic + filter.as_f64().unwrap_or(0.0);
            if distance == 0.0 {
                f64::INFINITY
            } else {
                tolerance / (distance / 2.0)
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            // A luminance stands for three equal components.
            let is_gray = name == "texel" && a.len() == 3 && b.len() == 1;
            if a.len() != b.len() && !is_gray {
                return 0.0;
            }
            let ratios = a.iter().enumerate().map(|(i, a)| {
                let b = if is_gray { &b[0] } else { &b[i] };
                ratio_of_values(name, a, b, &filter[i])
            });
            ratios.fold(f64::INFINITY, f64::min)
        }
        (a, b) if a == b => f64::INFINITY,
        _ => 0.0,
    }
}

/// Misreadings that change texels as little as the weights of texture units change samples. Cases of single texels catch them.
const MISTAKES_OF_PRECISION: [&str; 2] = ["texels-of-8-bits", "texels-of-half-floats"];

/// For every judged case, compares its tolerance with half the distance to each other reading and to each misreading that fails
/// the case without the tolerance of filters, except mistakes of precision. Prints the largest ratio of each family of cases.
#[test]
fn tolerances_are_below_half_the_distance_to_other_readings_and_misreadings() {
    let suite = suite();
    let mut largest: BTreeMap<String, (f64, String)> = BTreeMap::new();
    let mut too_large = Vec::new();
    let (mut readings, mut caught) = (0, 0);
    for case in suite.cases.iter().filter(|case| case.basis != Basis::Impl) {
        let mut record = |what: &str, ratio: f64| {
            let label = format!("{} against {what}", case.id);
            if ratio >= 1.0 {
                too_large.push(format!("{label}: {ratio}"));
            }
            let family = format!("{} ({})", &case.id[..3], case.op);
            let entry = largest.entry(family).or_default();
            if ratio > entry.0 {
                *entry = (ratio, label);
            }
        };
        let reference = case.expected(&CHOICES.reference());
        for other in &case.alternatives {
            readings += 1;
            record(&other.reading, tolerance_ratio(&reference, &other.expect));
        }
        let mut dialects = vec![CHOICES.reference()];
        for &axis in case.relevant_axes() {
            for (reading, (name, _)) in CHOICES[axis].readings.iter().enumerate().skip(1) {
                let mut dialect = CHOICES.reference();
                dialect.0[axis] = reading;
                let other = case.expected(&dialect);
                // Some readings of a choice agree on a case.
                if exact(&reference).difference(&other.answer).is_some() {
                    record(name, tolerance_ratio(&reference, &other.answer));
                    record(name, tolerance_ratio(&other, &reference.answer));
                    dialects.push(dialect);
                }
            }
        }
        for dialect in dialects {
            let expected = case.expected(&dialect);
            let distinct = |one: &&Misreading<_>| !MISTAKES_OF_PRECISION.contains(&one.slug);
            for misreading in misreadings::all().filter(distinct) {
                let rules = misreading.apply_to(CHOICES.apply(&dialect, Rules::SPEC));
                if let Some(misread) = case.expected_under(&rules)
                    && exact(&expected).difference(&misread.answer).is_some()
                {
                    caught += 1;
                    let slug = misreading.slug;
                    record(slug, tolerance_ratio(&expected, &misread.answer));
                    assert!(expected.difference(&misread.answer).is_some(), "{slug}");
                }
            }
        }
    }
    for (family, (ratio, label)) in &largest {
        println!("{family}: {ratio:.4} ({label})");
    }
    assert!(readings > 30 && caught > 1000, "{readings} {caught}");
    assert!(too_large.is_empty(), "{too_large:#?}");
}

/// Returns an expected answer without the tolerance of filters.
fn exact(expected: &ExpectedAnswer) -> ExpectedAnswer {
    ExpectedAnswer {
        filter_tolerance: Value::Null,
        ..expected.clone()
    }
}

#[test]
fn depths_of_any_formula_pass() {
    let suite = suite();
    let run = run(&suite, |case| {
        let mut answer = case.answer(&Rules::SPEC);
        if let Answer::Decoded(value) = &mut answer
            && let Some(depth) = value.get("depth").and_then(Value::as_f64)
        {
            value["depth"] = depth.max(0.0).into();
        }
        answer
    });
    let failed = cases_with_outcome(&suite, &run, Outcome::Fail);
    assert!(failed.is_empty(), "{failed:?}");
    // The mode is judged.
    let wrong = run_with_mode(&suite, "min");
    let failed = cases_with_outcome(&suite, &wrong, Outcome::Fail);
    assert!(failed.contains(&"DEP-05".to_owned()), "{failed:?}");
}

/// Runs a stage that always returns the same mode.
fn run_with_mode(suite: &Suite<TextureCase>, mode: &str) -> TextureRun {
    run(suite, |case| match case.op.as_str() {
        "depth" => Answer::Decoded(serde_json::json!({ "depth": 0, "mode": mode })),
        _ => case.answer(&Rules::SPEC),
    })
}

#[test]
fn modes_must_follow_one_reading_of_the_bias() {
    let suite = suite();
    let axis = CHOICES.axes(&["bias-and-mode"])[0];
    let mut dialect = CHOICES.reference();
    dialect.0[axis] = 1;
    let biased = CHOICES.apply(&dialect, Rules::SPEC);
    let consistent = run(&suite, |case| case.answer(&biased));
    assert_eq!(consistent.exit_status(), 0);
    assert_eq!(consistent.judgment.dialect, dialect);
    let mixed = run(&suite, |case| match case.id.as_str() {
        "DEP-56" => case.answer(&biased),
        _ => case.answer(&Rules::SPEC),
    });
    let failed = cases_with_outcome(&suite, &mixed, Outcome::Fail);
    assert!(failed.iter().all(|id| id == "DEP-56" || id == "DEP-58"));
    assert_eq!(failed.len(), 1);
}

#[test]
fn every_misreading_is_diagnosed() {
    let suite = suite();
    let mut unnamed = Vec::new();
    for misreading in misreadings::all() {
        let rules = misreading.apply_to(Rules::SPEC);
        let run = run(&suite, |case| case.answer(&rules));
        let diagnoses = diagnose(&suite, &run);
        let first = diagnoses.first().map(|first| match &first.cause {
            Cause::Misreading { misreading, .. } => misreading.slug,
            Cause::Described { .. } => "described",
        });
        if first != Some(misreading.slug) {
            unnamed.push((misreading.slug, first));
        }
    }
    assert!(unnamed.is_empty(), "{unnamed:#?}");
}

/// Returns the names of the causes that are found if only one of the cases was judged.
fn causes_of_one_case(
    suite: &Suite<TextureCase>,
    run: &mut TextureRun,
    case: usize,
) -> Vec<String> {
    let whole = run.judgment.clone();
    for (i, verdict) in run.judgment.cases.iter_mut().enumerate() {
        verdict.take_if(|_| i != case);
    }
    let causes = names_of_causes(&diagnose(suite, run));
    run.judgment = whole;
    causes
}

fn names_of_causes(diagnoses: &[Diagnosis<misreadings::Change>]) -> Vec<String> {
    let names = diagnoses.iter().map(|diagnosis| match &diagnosis.cause {
        Cause::Misreading { misreading, .. } => misreading.slug.to_owned(),
        Cause::Described { effect, .. } => effect.clone(),
    });
    names.collect()
}

/// Mistakes under which the answer to a case is undefined cannot be recognized by the answer.
#[test]
fn undefined_answers_explain_nothing() {
    let suite = suite();
    let lighter = Rules {
        texel_color: |texel| texel_color(texel).map(|c| c + 0.002),
        ..Rules::SPEC
    };
    let mut run = run(&suite, |case| case.answer(&lighter));
    let failing: Vec<usize> = run.judgment.with_outcome(Outcome::Fail).collect();
    let ids: Vec<&str> = failing
        .iter()
        .map(|&i| suite.cases[i].id.as_str())
        .collect();
    assert!(
        ids.contains(&"PTM-16") && ids.contains(&"PTM-17"),
        "{ids:?}"
    );
    for i in failing {
        let causes = causes_of_one_case(&suite, &mut run, i);
        assert!(causes.is_empty(), "{}: {causes:?}", suite.cases[i].id);
    }
    assert_eq!(
        names_of_causes(&diagnose(&suite, &run)),
        Vec::<String>::new()
    );
}

fn round_to_multiple(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}

/// Rounds to a number of significant bits.
fn round_to_bits(value: f64, bits: i32) -> f64 {
    if value == 0.0 {
        return value;
    }
    let exponent = value.abs().log2().floor() as i32;
    round_to_multiple(value, 2.0_f64.powi(bits - 1 - exponent))
}

/// Returns the rules of a stage whose weights are multiples of 1/256.
fn with_weights_of_8_bits(rules: Rules) -> Rules {
    Rules {
        neighbors: |edge, t, size, rules| {
            let [(lower, _), (upper, weight)] = sample::cells_around(edge, t, size, rules);
            let weight = round_to_multiple(weight, 256.0);
            [(lower, 1.0 - weight), (upper, weight)]
        },
        levels: |depth, top| {
            let (lower, upper, weight) = sample::levels_around(depth, top);
            (lower, upper, (weight * 256.0).floor() / 256.0)
        },
        ..rules
    }
}

/// Stages that store texels as graphics processors do, with exact weights and with weights of 8 bits: the only cause must be the
/// format, and must explain every failure.
#[test]
fn formats_of_texels_are_recognized() {
    let suite = suite();
    let formats: [(&str, fn(f64) -> f64); 2] = [
        ("texels-of-8-bits", |value| round_to_multiple(value, 255.0)),
        ("texels-of-half-floats", |value| round_to_bits(value, 11)),
    ];
    for (slug, stored_component) in formats {
        let exact_weights = Rules {
            stored_component,
            ..Rules::SPEC
        };
        for rules in [exact_weights, with_weights_of_8_bits(exact_weights)] {
            let mut run = run(&suite, |case| case.answer(&rules));
            let failing: Vec<usize> = run.judgment.with_outcome(Outcome::Fail).collect();
            let diagnoses = diagnose(&suite, &run);
            assert_eq!(names_of_causes(&diagnoses), [slug]);
            let [first] = &diagnoses[..] else {
                panic!("{slug}")
            };
            let is_alone = matches!(&first.cause, Cause::Misreading { equivalents, .. } if equivalents.is_empty());
            assert!(is_alone && first.is_mechanism, "{slug}");
            assert!(failing.len() > 50 && first.explains == failing, "{slug}");
            for i in failing {
                let causes = causes_of_one_case(&suite, &mut run, i);
                assert_eq!(causes, [slug], "{}", suite.cases[i].id);
            }
        }
        let and_another = Rules {
            is_outside: |t| !(0.0..1.0).contains(&t),
            ..exact_weights
        };
        let run = run(&suite, |case| case.answer(&and_another));
        let causes = names_of_causes(&diagnose(&suite, &run));
        assert_eq!(causes, [slug, "one-is-outside"]);
    }
}

/// Stages whose texels are inexact in another way are not said to have the two formats.
#[test]
fn other_inexact_texels_are_not_taken_for_formats() {
    let suite = suite();
    let others: [(&str, fn(f64) -> f64); 6] = [
        ("truncated to 8 bits", |value| {
            (value * 255.0).floor() / 255.0
        }),
        ("multiples of 1/256", |value| {
            round_to_multiple(value, 256.0)
        }),
        ("10 bits", |value| round_to_multiple(value, 1023.0)),
        ("8 significant bits", |value| round_to_bits(value, 8)),
        ("a little larger", |value| value * 1.003),
        ("a little smaller", |value| value - 0.0015),
    ];
    for (name, stored_component) in others {
        let exact_weights = Rules {
            stored_component,
            ..Rules::SPEC
        };
        for rules in [exact_weights, with_weights_of_8_bits(exact_weights)] {
            let run = run(&suite, |case| case.answer(&rules));
            let causes = names_of_causes(&diagnose(&suite, &run));
            assert!(
                run.judgment.with_outcome(Outcome::Fail).count() > 30,
                "{name}"
            );
            assert_eq!(causes, Vec::<String>::new(), "{name}");
        }
    }
}

#[test]
fn mixed_readings_fail() {
    let suite = suite();
    for (axis, choice) in CHOICES.iter().enumerate() {
        for (reading, (name, _)) in choice.readings.iter().enumerate() {
            let mut dialect = CHOICES.reference();
            dialect.0[axis] = reading;
            let rules = CHOICES.apply(&dialect, Rules::SPEC);
            let pure = run(&suite, |case| case.answer(&rules));
            let failed = cases_with_outcome(&suite, &pure, Outcome::Fail);
            assert!(failed.is_empty(), "{}: {name}: {failed:?}", choice.ruling);
            assert_eq!(pure.judgment.dialect, dialect, "{}: {name}", choice.ruling);
            let revealing = suite.cases.iter().filter(|case| {
                let other = case.expected(&dialect).answer;
                let reference = case.expected(&CHOICES.reference());
                case.relevant_axes().contains(&axis) && reference.difference(&other).is_some()
            });
            let revealing: Vec<&str> = revealing.map(|case| case.id.as_str()).collect();
            assert!(
                reading == 0 || !revealing.is_empty(),
                "no case reveals {}",
                choice.ruling
            );
            if revealing.len() > 1 {
                let mixed = run(&suite, |case| {
                    let is_first = case.id == revealing[0];
                    case.answer(if is_first { &Rules::SPEC } else { &rules })
                });
                assert!(
                    !cases_with_outcome(&suite, &mixed, Outcome::Fail).is_empty(),
                    "{}: {name}",
                    choice.ruling
                );
            }
        }
    }
}

#[test]
fn implementation_defined_answers_never_fail() {
    let suite = suite();
    let run = run(&suite, |case| match case.basis {
        Basis::Impl => Answer::Decoded(
            serde_json::json!({ "t": [7, 7, 7], "texel": [7], "depth": 7, "color": [7, 7, 7] }),
        ),
        _ => case.answer(&Rules::SPEC),
    });
    assert_eq!(run.exit_status(), 0);
    let open = suite.cases.iter().filter(|case| case.basis == Basis::Impl);
    assert_eq!(
        cases_with_outcome(&suite, &run, Outcome::ImplementationDefined).len(),
        open.count()
    );
}

#[test]
fn only_out_of_range_questions_may_be_refused() {
    let suite = suite();
    let refused = run(&suite, |case| match case.op.as_str() {
        "resolve" => Answer::Rejected,
        _ => case.answer(&Rules::SPEC),
    });
    assert_eq!(refused.exit_status(), 1);
    let has = |outcome, id: &str| {
        cases_with_outcome(&suite, &refused, outcome)
            .iter()
            .any(|one| one == id)
    };
    assert!(has(Outcome::Inconclusive, "RES-04") && has(Outcome::Fail, "RES-01"));
}

#[test]
fn only_whole_steps_can_be_unsupported() {
    let suite = suite();
    let unsupported = |case: &TextureCase| {
        matches!(case.op.as_str(), "interpolate" | "depth") || case.features().contains("PTM maps")
    };
    let consistent = run(&suite, |case| match unsupported(case) {
        true => Answer::Unsupported,
        false => case.answer(&Rules::SPEC),
    });
    assert_eq!(consistent.exit_status(), 0);
    let names: Vec<&String> = consistent.judgment.unsupported.iter().collect();
    assert_eq!(names, ["PTM maps", "depth", "interpolate"]);
    let inconsistent = run(&suite, |case| match case.id.as_str() {
        "SMP-08" => Answer::Unsupported,
        _ => case.answer(&Rules::SPEC),
    });
    assert_eq!(
        cases_with_outcome(&suite, &inconsistent, Outcome::Fail),
        ["SMP-08"]
    );
}

#[test]
fn every_requirement_is_tested_or_has_a_reason() {
    let suite = suite();
    let rulings = cases::rulings().expect("the rulings load");
    let clauses = cases::clauses().expect("the requirements load");
    assert_eq!(clauses.len(), 153);
    for clause in &clauses {
        let id = &clause.id;
        let has_case = suite.cases.iter().any(|case| case.clauses.contains(id));
        let has_misreading = misreadings::all().any(|one| one.clause == id);
        let is_covered = match clause.status {
            // A misreading of one requirement often violates related ones, so a case about each requirement is enough.
            ClauseStatus::Tested => has_case,
            ClauseStatus::Ruled => {
                let is_ruling = |ruling: &&Ruling| Some(&ruling.id) == clause.ruling.as_ref();
                let ruling = rulings.iter().find(is_ruling);
                has_case && ruling.is_some_and(|ruling| ruling.clauses.contains(id))
            }
            ClauseStatus::Informative | ClauseStatus::Untestable => {
                clause.why.is_some() && !has_case && !has_misreading
            }
        };
        assert!(is_covered, "{id}");
    }
}

#[test]
fn every_enumerant_has_a_case() {
    let suite = suite();
    let text = |case: &TextureCase| format!("{} {} {}\n", case.op, case.given, case.expect);
    let all: String = suite.cases.iter().map(text).collect();
    let enumerants = "PreLight PostLight VertexMCCoord VertexWCCoord VertexMCNormal VertexWCNormal NURBUV FloatData \
        ReflectionSphereVRC ReflectionSphereWC Replace Modulate BlendEnvColor Decal DecalBackground Red Green Blue \
        Alpha SingleBase WeightedBase SingleInMipmap WeightedInMipmap SingleBetweenMipmaps WeightedBetweenMipmaps \
        ClampExplicit ClampBorder Wrap Mirror Discontinue Color None Vertex Pixel InterpDep DotProduct Normal L LA RGB \
        RGBA Texture Hollow Solid Pattern Hatch Empty";
    for name in enumerants.split(' ') {
        assert!(all.contains(&format!("\"{name}\"")), "{name}");
    }
    for op in OPERATIONS.split(' ') {
        assert!(suite.cases.iter().any(|case| case.op == op), "{op}");
    }
}

#[test]
fn every_cross_reference_exists_and_agrees() {
    let clauses = cases::clauses().expect("the requirements load").into_iter();
    let clauses: HashSet<String> = clauses.map(|clause| clause.id).collect();
    let are_known = |ids: &[String]| ids.iter().all(|id| clauses.contains(id));
    let rulings = cases::rulings().expect("the rulings load");
    let mut ids = HashSet::new();
    for case in &suite().cases {
        let id = &case.id;
        assert!(ids.insert(id.clone()), "duplicate {id}");
        assert!(are_known(&case.clauses), "{id}");
        let ruling = case.ruling.as_ref().map(|name| {
            let ruling = rulings.iter().find(|ruling| ruling.id == *name);
            ruling
                .unwrap_or_else(|| panic!("{id}: no ruling {name}"))
                .kind
        });
        let agrees = match case.basis {
            Basis::Text => true,
            Basis::Sibling => ruling == Some(RulingKind::Must),
            Basis::Inferred => ruling.is_some(),
            Basis::Reading => ruling == Some(RulingKind::Choice),
            Basis::Impl => ruling == Some(RulingKind::ImplementationDefined),
        };
        assert!(agrees, "{id}: {:?} under {ruling:?}", case.basis);
        // A case whose answer depends on a choice must declare the choice.
        let is_open = !case.relevant_axes().is_empty();
        let has_others = !case.alternatives.is_empty() && case.basis != Basis::Impl;
        assert_eq!(is_open, case.basis == Basis::Reading, "{id}");
        assert_eq!(is_open, has_others, "{id}");
    }
    for ruling in &rulings {
        assert!(are_known(&ruling.clauses), "{}", ruling.id);
        let choice = CHOICES.iter().find(|choice| choice.ruling == ruling.id);
        let others = choice.map_or(0, |choice| choice.readings.len() - 1);
        assert_eq!(others, ruling.alternatives.len(), "{}", ruling.id);
    }
    let mut slugs = HashSet::new();
    for misreading in misreadings::all() {
        let slug = misreading.slug;
        assert!(slugs.insert(slug), "duplicate {slug}");
        assert!(clauses.contains(misreading.clause), "{slug}");
    }
}

#[test]
fn malformed_questions_name_the_faulty_field() {
    for [question, says] in rows(
        r#"
| EOF
[] | a question must have an op
{"op":"orient","given":{"t":[1,2,3]}} | matrix
{"op":"sample","given":{"map":"none such","t":[0,0,0]}} | no map "none such"
{"op":"sample","given":{"map":{"kind":"L","levels":[]},"t":[0,0,0]}} | dimensions
{"op":"sample","given":{"map":{"kind":"L","levels":[{"size":[2],"texels":[[1]]}]},"t":[0,0,0]}} | has 1 texels
{"op":"sample","given":{"map":{"kind":"LA","levels":[{"size":[1],"texels":[[1]]}]},"t":[0,0,0]}} | 2 components
{"op":"sample","given":{"map":{"ptm":"50x","light":[0,0]},"t":[0,0,0]}} | hexadecimal
{"op":"sample","given":{"map":{"ptm":"5054","light":[0,0]},"t":[0,0,0]}} | header string
{"op":"index","given":{"boundary":"Repeat","size":4,"t":[0]}} | ClampExplicit, ClampBorder, Wrap, Mirror
{"op":"index","given":{"boundary":"Wrap","size":0,"t":[0]}} | from 1 to 2^31
{"op":"parameterize","given":{"entry":{},"point":{"vrc":[0,0,0]}}} | a normal
{"op":"parameterize","given":{"dim":4}} | 1, 2 or 3
{"op":"interpolate","given":{"ts":[[0],[1]],"b":[1],"correction":"None"}} | per corner
{"op":"resolve","given":{"index":0}} | index-out-of-range
{"op":"compose","given":{"texel":["RGB",[1]],"color":[0,0,0]}} | [kind, components]"#,
    ) {
        let answer = Question::read(question.as_bytes()).and_then(|q| q.answer(&Rules::SPEC));
        match answer {
            Err(Refusal::Malformed(why)) => assert!(why.contains(&says), "{question}: {why}"),
            other => panic!("{question}: {other:?}"),
        }
    }
    let unknown = Question::read(br#"{"op":"paint","given":{}}"#);
    let is_unsupported = matches!(unknown, Err(Refusal::Unsupported(_)));
    assert!(is_unsupported, "{unknown:?}");
}

#[test]
fn long_and_short_names_are_accepted() {
    for name in ["PEXTMRCPostLight", "PEXTMRenderingControlPostLight"] {
        let control: RenderingControl = name.parse().expect(name);
        assert_eq!(control.name(), "PostLight");
    }
    let clamp: Result<ClampMethod, _> = "PEXTMBoundaryClampExplicitColor".parse();
    assert_eq!(clamp.map(ClampMethod::name), Ok("Color"));
    for (name, short) in [
        ("PEXTMBCWrap", "Wrap"),
        ("ClampExplicitMethod", "ClampExplicit"),
    ] {
        let boundary: Result<Boundary, _> = name.parse();
        assert_eq!(boundary.map(Boundary::name), Ok(short));
    }
}
