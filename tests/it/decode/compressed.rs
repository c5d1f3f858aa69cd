//! Tests properties of the cases for §2.9.

use ptm::Reading;
use ptm::{Coding, Limits};
use ptm_generate::{Model, plan::Residuals};
use ptm_suite::cases::{Case, Suite, TableSpelling};
use ptm_suite::choices::CHOICES;
use ptm_suite::dialect::{Axis, Dialect};
use ptm_suite::protocol::frame::View;
use ptm_suite::values::Values;

/// Returns the small compressed cases that the generator writes undamaged, with their models.
fn generated_cases() -> Vec<(Case, Model)> {
    let suite = Suite::load().expect("the suite loads");
    let small = |case: &Case| {
        case.recipe()
            .is_some_and(|recipe| recipe.size.texels() < 10_000)
    };
    let is_wanted = |case: &Case| case.compression().is_some() && case.damage().is_none();
    let cases = suite.cases.into_iter();
    let cases = cases.filter(|case| is_wanted(case) && small(case));
    let model = |case: Case| match &case.build(TableSpelling::default()).values {
        Values::Painted(model) => Some((case, model.clone())),
        _ => None,
    };
    cases.filter_map(model).collect()
}

#[test]
fn only_lossy_jpeg_planes_have_a_tolerance() {
    for (case, model) in generated_cases() {
        let recipe = case.recipe().expect("painted");
        let natural_jpeg = recipe.format.coding() == Some(Coding::Jpeg)
            && recipe.compression.residuals == Residuals::Natural;
        assert!(natural_jpeg || model.slack.is_empty(), "{}", case.id);
    }
}

#[test]
fn tolerance_grows_with_each_predictor_and_is_zero_where_corrected() {
    for (case, model) in generated_cases()
        .iter()
        .filter(|(_, model)| !model.slack.is_empty())
    {
        let compressed = model.compressed.as_ref().expect("painted");
        let channels = model.format.channels();
        let reference = |plane: &usize| compressed.plan.reference(*plane);
        let depth = |plane: usize| std::iter::successors(reference(&plane), reference).count();
        for plane in 0..channels {
            let corrected = |texel: usize| {
                let (width, height) = (model.size.width as usize, model.size.height as usize);
                let stored = (height - 1 - texel / width) * width + texel % width;
                let mut records = compressed.planes[plane].records.iter();
                records.any(|&(position, _)| position as usize == stored)
            };
            for (texel, slack) in model.slack.iter().skip(plane).step_by(channels).enumerate() {
                let limit = if corrected(texel) {
                    0
                } else {
                    1 + depth(plane)
                };
                assert!(usize::from(*slack) <= limit, "{}: plane {plane}", case.id);
            }
        }
    }
}

#[test]
fn cases_with_overflows_have_corrections() {
    let mut cases = generated_cases();
    cases.retain(|(case, _)| case.id.starts_with("overflows-"));
    assert!(!cases.is_empty());
    for (case, model) in cases {
        let mut planes = model.compressed.expect("painted").planes.into_iter();
        assert!(planes.any(|plane| !plane.records.is_empty()), "{}", case.id);
    }
}

#[test]
fn cases_depend_only_on_the_choices_of_their_recipes() {
    for (case, _) in generated_cases() {
        let recipe = case.recipe().expect("painted");
        let relevant = recipe.compression.axes();
        let are_relevant = case.axes().iter().all(|axis| relevant.contains(axis));
        assert!(are_relevant, "{}", case.id);
    }
}

/// A choice that a case does not show has no effect on its planes, whatever the readings of the other choices are.
#[test]
fn choices_that_a_case_does_not_show_have_no_effect() {
    let mut missing = Vec::new();
    for (case, _) in generated_cases() {
        let shown = CHOICES.axes(&case.axes());
        let all = CHOICES.axes(&case.recipe().expect("painted").compression.axes());
        let file = &case.build(TableSpelling::default()).file;
        let planes = |dialect: &Dialect| {
            let reading = CHOICES.apply(dialect, Reading::SPEC);
            ptm::decode_as(file, &reading, &Limits::default()).map(|ptm| ptm.planes)
        };
        for dialect in CHOICES.combinations(&shown) {
            let expected = planes(&dialect);
            for &axis in all.iter().filter(|axis| !shown.contains(axis)) {
                for reading in 1..CHOICES[axis].readings.len() {
                    let mut other = dialect.clone();
                    other.0[axis] = reading;
                    if planes(&other) != expected {
                        missing.push((case.id.clone(), CHOICES[axis].readings[reading].0));
                    }
                }
            }
        }
    }
    missing.dedup();
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn choices_that_a_case_shows_have_an_effect() {
    let mut idle = Vec::new();
    for (case, _) in generated_cases() {
        let shown = CHOICES.axes(&case.axes());
        // A recipe without a list shows everything that could matter.
        let is_listed = shown.len() < case.recipe().expect("painted").compression.axes().len();
        let file = &case.build(TableSpelling::default()).file;
        let planes = |dialect: &Dialect| {
            let reading = CHOICES.apply(dialect, Reading::SPEC);
            ptm::decode_as(file, &reading, &Limits::default()).map(|ptm| ptm.planes)
        };
        for &axis in shown.iter().filter(|_| is_listed) {
            let others: Vec<Axis> = shown
                .iter()
                .copied()
                .filter(|&other| other != axis)
                .collect();
            let has_effect = CHOICES.combinations(&others).into_iter().any(|dialect| {
                let expected = planes(&dialect);
                (1..CHOICES[axis].readings.len()).any(|reading| {
                    let mut other = dialect.clone();
                    other.0[axis] = reading;
                    planes(&other) != expected
                })
            });
            if !has_effect {
                idle.push((case.id.clone(), CHOICES[axis].ruling));
            }
        }
    }
    assert!(idle.is_empty(), "{idle:#?}");
}

#[test]
fn every_choice_has_a_case_that_shows_little_else() {
    let cases = generated_cases();
    for axes in [
        &["jpeg-ls-offset"][..],
        &["motion-vertical"],
        &["motion-half"],
        &["side-lossless"],
        // A mirrored border depends on the direction, and a displaced plane has samples outside its reference.
        &["motion-sign", "motion-border"],
        &["motion-half", "motion-inversion"],
    ] {
        assert!(
            cases.iter().any(|(case, _)| case.axes() == axes),
            "{axes:?}"
        );
    }
}

#[test]
fn lossy_planes_near_0_or_255_are_requested_only_raw() {
    for (case, model) in generated_cases() {
        let mut samples = model.samples.iter().zip(&model.slack);
        let is_near =
            samples.any(|(&sample, &slack)| slack > 0 && (sample < slack || 255 - sample < slack));
        assert!(!is_near || case.views == [View::Raw], "{}", case.id);
    }
}
