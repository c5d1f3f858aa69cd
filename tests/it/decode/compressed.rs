//! The properties of the cases of §2.9.

use ptm_conform::generate::Model;
use ptm_conform::generate::plan::Residuals;
use ptm_conform::protocol::frame::View;
use ptm_conform::ptm::Coding;
use ptm_conform::suite::cases::{Case, Suite, TableSpelling};
use ptm_conform::suite::values::Values;

/// The small compressed cases that the generator writes undamaged, and their models.
fn painted() -> Vec<(Case, Model)> {
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
fn only_natural_jpeg_planes_have_slack() {
    for (case, model) in painted() {
        let recipe = case.recipe().expect("painted");
        let natural_jpeg = recipe.format.coding() == Some(Coding::Jpeg)
            && recipe.compression.residuals == Residuals::Natural;
        assert!(natural_jpeg || model.slack.is_empty(), "{}", case.id);
    }
}

#[test]
fn slack_is_one_for_the_plane_and_one_for_each_on_its_way_and_none_where_corrected() {
    for (case, model) in painted()
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
                let most = if corrected(texel) {
                    0
                } else {
                    1 + depth(plane)
                };
                assert!(usize::from(*slack) <= most, "{}: plane {plane}", case.id);
            }
        }
    }
}

#[test]
fn overflows_are_corrected_where_cases_say_so() {
    let mut cases = painted();
    cases.retain(|(case, _)| case.id.starts_with("overflows-"));
    assert!(!cases.is_empty());
    for (case, model) in cases {
        let mut planes = model.compressed.expect("painted").planes.into_iter();
        assert!(planes.any(|plane| !plane.records.is_empty()), "{}", case.id);
    }
}

#[test]
fn a_case_shows_no_choice_that_its_lists_do_not_touch() {
    for (case, _) in painted() {
        let recipe = case.recipe().expect("painted");
        let touched = recipe.compression.axes();
        let are_touched = case.axes().iter().all(|axis| touched.contains(axis));
        assert!(are_touched, "{}", case.id);
    }
}

#[test]
fn every_open_choice_but_inversion_is_seen_alone_somewhere() {
    let cases = painted();
    let is_shown = |axes: &[&str]| cases.iter().any(|(case, _)| case.axes() == axes);
    let axes = "jpeg-ls-offset motion-sign motion-vertical motion-half motion-border side-lossless";
    for axis in axes.split(' ') {
        assert!(is_shown(&[axis]), "{axis}");
    }
    assert!(is_shown(&["motion-half", "motion-inversion"]));
}

#[test]
fn lossy_planes_near_the_ends_are_asked_raw_only() {
    for (case, model) in painted() {
        let mut samples = model.samples.iter().zip(&model.slack);
        let near =
            samples.any(|(&sample, &slack)| slack > 0 && (sample < slack || 255 - sample < slack));
        assert!(!near || case.views == [View::Raw], "{}", case.id);
    }
}
