//! Tests properties of the cases for §2.9.

use ptm_conform::generate::{Model, plan::Residuals};
use ptm_conform::protocol::frame::View;
use ptm_conform::ptm::Coding;
use ptm_conform::suite::cases::{Case, Suite, TableSpelling};
use ptm_conform::suite::values::Values;

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

#[test]
fn every_choice_except_inversion_has_an_isolated_case() {
    let cases = generated_cases();
    let has_case = |axes: &[&str]| cases.iter().any(|(case, _)| case.axes() == axes);
    let axes = "jpeg-ls-offset motion-sign motion-vertical motion-half motion-border side-lossless";
    for axis in axes.split(' ') {
        assert!(has_case(&[axis]), "{axis}");
    }
    assert!(has_case(&["motion-half", "motion-inversion"]));
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
