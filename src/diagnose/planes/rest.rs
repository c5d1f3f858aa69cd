//! Wrong planes of unknown cause: the smallest place that has all wrong samples.
//!
//! Each plane is made again from the reference that was shown, so that what is wrong only because its reference is wrong does
//! not count.

use super::places::{PLANES, Place, PlaneIs, SAMPLES};
use super::slips::PlaneSlip;
use super::solve::{Shown, Trace, of_files, passing_files, slips_of};
use crate::diagnose::diagnosis::{Category, Diagnosis, Words};
use crate::diagnose::search::{Search, Set};
use crate::diagnose::words::pictures::{example, smallest};

/// Fewer files share something by chance.
const FEWEST: usize = 4;
/// A place is said if it leaves out so many of the planes, and of the samples in these, that are right.
const LEFT_OUT: usize = 2;
const SAMPLES_LEFT_OUT: usize = 4;

/// The files of `left` in which planes are wrong that are predicted or corrected, and no others.
pub(in crate::diagnose) fn describe(
    search: &Search,
    set: &Set,
    left: &mut Vec<usize>,
) -> Option<Diagnosis> {
    let slips = slips_of(search, set);
    let slips: Vec<&PlaneSlip> = slips.iter().collect();
    let (of, failing) = of_files(search, set, &search.solvable(left));
    let (_, passing) = of_files(search, set, &passing_files(search, left));
    let wrong = traces(search, &failing, &slips);
    let right = traces(search, &passing, &slips);
    let is_open = |trace: &&Trace| !trace.hits.is_empty();
    let in_streams = wrong.iter().filter(is_open).any(|trace| {
        let plane = &failing[trace.file].coding.planes[trace.plane];
        plane.step.reference.is_none() && plane.records.is_empty()
    });
    if of.len() < FEWEST || in_streams {
        return None;
    }
    let of_wrong = wrong.iter().map(|trace| (&failing[trace.file], trace));
    let of_right = right.iter().map(|trace| (&passing[trace.file], trace));
    let place = place(&of_wrong.chain(of_right).collect::<Vec<_>>())?;
    left.retain(|w| !of.contains(w));
    let words = Words {
        effect: format!("shows wrong values{}; the cause is unknown", place.says()),
        fix: "follow this sample by hand: the residual, the plane that it is predicted from, its inversion and its vector, and only then side information".to_owned(),
        example: example(search, smallest(search.witnesses, &of)),
    };
    let described = Diagnosis::described(Category::Difference, search.witnesses, &of, words);
    Some(described.about(place.clause()))
}

/// Each plane that is predicted or corrected: its wrong samples, and the others.
fn traces(search: &Search, files: &[Shown], slips: &[&PlaneSlip]) -> Vec<Trace> {
    let places: Vec<usize> = (0..files.len()).collect();
    let of_file = |&file: &usize| -> Vec<Trace> {
        let of = &files[file];
        let made = of.all(slips).into_iter().enumerate();
        let trace = |(plane, made): (usize, Vec<u8>)| {
            let (hits, misses) = (0..made.len()).partition(|&at| made[at] != of.planes[plane][at]);
            Trace {
                file,
                plane,
                hits,
                misses,
            }
        };
        made.map(trace).collect()
    };
    search
        .each(&places, of_file)
        .into_iter()
        .flatten()
        .collect()
}

/// What holds of every wrong plane, and of fewest right ones; and the same of their samples.
fn place(of: &[(&Shown, &Trace)]) -> Option<Place> {
    let (wrong, right): (Vec<_>, Vec<_>) = of.iter().partition(|(_, trace)| !trace.hits.is_empty());
    let right: Vec<_> = (right.into_iter())
        .filter(|(file, trace)| file.coding.planes[trace.plane].step.reference.is_some())
        .collect();
    let holds =
        |one: PlaneIs, (file, trace): &(&Shown, &Trace)| one.holds(&file.coding, trace.plane);
    let shared = (0..PLANES.len()).map(PlaneIs::Listed);
    let shared = shared.filter(|&one| wrong.iter().all(|item| holds(one, item)));
    let count = |one: PlaneIs| right.iter().filter(|item| holds(one, item)).count();
    let best = shared
        .map(|one| (count(one), one))
        .min_by_key(|&(count, _)| count);
    let plane = best.filter(|(count, _)| count * LEFT_OUT <= right.len());
    let plane = plane.map(|(_, one)| one);
    let inside = of
        .iter()
        .filter(|item| plane.is_none_or(|one| holds(one, item)));
    let mut all = 0;
    let mut open = [(true, 0); SAMPLES.len()];
    for (file, trace) in inside {
        let predictor = (file.coding).right_predictor(trace.plane, &file.planes, &file.reading);
        let sample = |at: usize| {
            let place = (trace.plane, at);
            (file.coding).sample(place, &file.planes, &predictor, &file.reading)
        };
        for at in trace.hits.iter().map(|&at| sample(at)) {
            for (one, open) in SAMPLES.iter().zip(&mut open) {
                open.0 &= (one.holds)(&at);
            }
        }
        all += trace.misses.len();
        for at in trace.misses.iter().map(|&at| sample(at)) {
            for (one, open) in SAMPLES.iter().zip(&mut open) {
                open.1 += usize::from((one.holds)(&at));
            }
        }
    }
    let fewest = (0..SAMPLES.len()).filter(|&one| open[one].0);
    let sample = fewest
        .min_by_key(|&one| open[one].1)
        .filter(|&one| open[one].1 * SAMPLES_LEFT_OUT <= all);
    let place = Place {
        planes: plane.into_iter().collect(),
        sample,
    };
    (place != Place::default()).then_some(place)
}
