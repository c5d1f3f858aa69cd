//! Images that do not depend on the file: the same image for every file, or one value in every sample.

use super::refusals::example;
use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::witness::Witness;
use crate::protocol::frame::{Frame, Samples};
use crate::session::observation::Response;
use crate::suite::cases::Expect;

/// Files whose images are compared: fewer may be alike by chance.
const MIN_FILES: usize = 10;

/// Describes views in which no image depends on the file, and removes their images from `left`.
pub(in crate::diagnose) fn describe(
    witnesses: &[Witness],
    left: &mut Vec<usize>,
) -> Vec<Diagnosis> {
    let diagnosis = |(effect, of): (String, Vec<usize>)| {
        left.retain(|w| !of.contains(w));
        let words = Words {
            effect,
            fix: "start with the example, the smallest of these files".to_owned(),
            example: example(witnesses, &of),
        };
        Diagnosis::described(Category::Difference, witnesses, &of, words)
    };
    find(witnesses).into_iter().map(diagnosis).collect()
}

/// Returns true if no image depends on the file in some view. Mistakes then agree with the images by chance.
pub(in crate::diagnose) fn is_prevalent(witnesses: &[Witness]) -> bool {
    !find(witnesses).is_empty()
}

/// Returns what the images of a view have in common, and their cases.
fn find(witnesses: &[Witness]) -> Vec<(String, Vec<usize>)> {
    let all: Vec<usize> = (0..witnesses.len()).collect();
    let mut found = Vec::new();
    for view in ["raw", "coef", "rgb"] {
        let of_view: Vec<&usize> = (all.iter())
            .filter(|&&w| witnesses[w].observation.view.name() == view)
            .collect();
        let frame = |&&w: &&usize| match &witnesses[w].observation.response {
            Response::Picture { frame, .. } if witnesses[w].failed => Some((w, frame.as_ref()?)),
            _ => None,
        };
        let shown: Vec<(usize, &Frame)> = of_view.iter().filter_map(frame).collect();
        let is_legal = |w: &&&usize| witnesses[***w].case.expect == Expect::Decode;
        let legal = of_view.iter().filter(is_legal).count();
        let Some(&(_, first)) = shown.first() else {
            continue;
        };
        // A few legal files have such an image.
        if shown.len() < MIN_FILES || shown.len() * 2 < legal {
            continue;
        }
        let count = shown.len();
        let effect = if shown.iter().all(|(_, frame)| *frame == first) {
            let (width, height) = (first.width, first.height);
            format!("shows the same image of {width} × {height} for {count} files in view {view}")
        } else if let Some(value) = value(first)
            && shown
                .iter()
                .all(|(_, frame)| self::value(frame) == Some(value))
        {
            format!("shows {value} in every sample of {count} images in view {view}")
        } else {
            continue;
        };
        found.push((effect, shown.into_iter().map(|(w, _)| w).collect()));
    }
    found
}

/// Returns the value of all samples of an image, if they are equal.
fn value(frame: &Frame) -> Option<f32> {
    match &frame.samples {
        Samples::U8(samples) => {
            let first = *samples.first()?;
            samples
                .iter()
                .all(|&sample| sample == first)
                .then(|| f32::from(first))
        }
        Samples::F32(samples) => {
            let first = *samples.first()?;
            samples
                .iter()
                .all(|&sample| sample == first)
                .then_some(first)
        }
    }
}
