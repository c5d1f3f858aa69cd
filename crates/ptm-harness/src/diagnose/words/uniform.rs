//! Describes images that do not depend on the file: the same image for every file, or the same value in every sample.

use super::refusals::example;
use crate::diagnose::diagnosis::{Category, CauseText, Diagnosis};
use crate::diagnose::rules;
use crate::diagnose::tuning::{MIN_SUPPORT, is_few, is_most, is_nearly_all};
use crate::diagnose::witness::{Witness, is_same_value, uniform_value};
use ptm_suite::cases::Expect;
use ptm_suite::protocol::frame::{Frame, ViewKind};
use ptm_suite::verdicts::observation::Response;

/// Describes views whose images do not depend on the file, and removes these images from `left`.
pub fn describe(witnesses: &[Witness], left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let found = find_uniform_images(witnesses, left);
    let diagnosis = |(effect, mut indices): (String, Vec<usize>)| {
        rules::sort_smallest_first(witnesses, &mut indices);
        let clause = witnesses[indices[0]].observation.view.kind().clause();
        left.retain(|w| !indices.contains(w));
        let text = CauseText {
            effect,
            fix: "start with the example, the first of these files".to_owned(),
            example: example(witnesses, &indices),
        };
        Diagnosis::from_description(
            Category::Difference,
            witnesses,
            &indices,
            text,
            Some(clause),
        )
    };
    found.into_iter().map(diagnosis).collect()
}

/// Returns true if nearly all failures are images that do not depend on the file. Mistakes match such images only by chance.
pub(in crate::diagnose) fn is_prevalent(witnesses: &[Witness]) -> bool {
    let failing = (0..witnesses.len()).filter(|&w| witnesses[w].failed);
    let failing: Vec<usize> = failing.collect();
    let found = find_uniform_images(witnesses, &failing);
    let count: usize = found.iter().map(|(_, indices)| indices.len()).sum();
    is_nearly_all(count, failing.len())
}

/// Returns the effect and the cases of each view in which the failing images do not depend on the file.
fn find_uniform_images(witnesses: &[Witness], failing: &[usize]) -> Vec<(String, Vec<usize>)> {
    let mut found = Vec::new();
    for view in ViewKind::ALL {
        let is_of_view = |witness: &Witness| witness.observation.view.kind() == view;
        let frame = |&w: &usize| match &witnesses[w].observation.response {
            Response::Image { frame, .. } if is_of_view(&witnesses[w]) => {
                Some((w, frame.as_ref()?))
            }
            _ => None,
        };
        let received: Vec<(usize, &Frame)> = failing.iter().filter_map(frame).collect();
        let Some(&(first_case, first)) = received.first() else {
            continue;
        };
        let is_legal =
            |witness: &&Witness| is_of_view(witness) && witness.case.expect == Expect::Decode;
        let legal = witnesses.iter().filter(is_legal).count();
        let right = &witnesses[first_case].expected;
        let are_equal = (received.iter()).all(|&(w, _)| witnesses[w].expected == *right);
        // A few legal files have a uniform image, and files with equal contents have equal images.
        if are_equal || received.len() < MIN_SUPPORT || !is_most(received.len(), legal) {
            continue;
        }
        let count = received.len();
        if received.iter().all(|(_, frame)| *frame == first) {
            let (width, height) = (first.width, first.height);
            let image = format!("the same {width} × {height} image for {count} files");
            let indices = received.into_iter().map(|(w, _)| w).collect();
            found.push((format!("shows {image} in view {view}"), indices));
            continue;
        }
        let common = received.iter().find_map(|(_, frame)| uniform_value(frame));
        let is_common = |(_, frame): &&(usize, &Frame)| {
            let pair = uniform_value(frame).zip(common);
            pair.is_some_and(|(value, common)| is_same_value(value.into(), common.into()))
        };
        let indices: Vec<usize> = received.iter().filter(is_common).map(|&(w, _)| w).collect();
        if let Some(value) = common.filter(|_| is_few(count - indices.len(), count)) {
            let effect = format!(
                "shows {value} in every sample of {} images in view {view}",
                indices.len()
            );
            found.push((effect, indices));
        }
    }
    found
}
