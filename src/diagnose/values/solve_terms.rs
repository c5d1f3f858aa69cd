//! Which numbers a decoder puts into (raw − bias) · scale, solved from final values.
//!
//! Of each coefficient, every scale and bias that a slip may put there is tried on every texel. What fits one file by
//! chance does not fit the next: only what fits all files that are asked is left.

use super::number_readers::OtherNumbers;
use super::numbers::{Used, all_used};
use super::terms::{Source, Terms, all_terms, final_value};
use crate::diagnose::pair::Pair;
use crate::diagnose::search::{Search, Set};
use crate::diagnose::solved::Act;
use crate::diagnose::words::pictures::pair_of;
use crate::protocol::frame::{Answer, View};
use crate::ptm::{Ptm, Shape};
use crate::session::observation::Response;
use crate::suite::compare::is_close;

/// Files that are asked.
const FILES: usize = 60;
/// Fewest files whose final values tell something.
const FEWEST: usize = 3;

/// For each channel, the places of the terms in [`all_terms`] that give what was received.
struct Fitting {
    shape: Shape,
    of: Vec<Vec<bool>>,
}

/// What may be done in the coefficients of `pictures`, made with the mistakes of `set`.
pub(in crate::diagnose) fn candidates(search: &Search, set: &Set, pictures: &[usize]) -> Vec<Act> {
    let of_finals = |&w: &usize| search.witnesses[w].observation.view == View::Coef;
    let finals: Vec<usize> = pictures.iter().copied().filter(of_finals).collect();
    let mut sample = search.smallest(&finals, 1 << 16);
    sample.truncate(FILES);
    let terms = all_terms();
    let fitting = search.each(&sample, |&w| fitting(search, set, w, &terms));
    let fitting: Vec<Fitting> = fitting.into_iter().flatten().collect();
    let is_rgb = |one: &&Fitting| one.shape == Shape::Rgb;
    let alike: Vec<&Fitting> = fitting.iter().collect();
    let (rgb, others): (Vec<&Fitting>, Vec<&Fitting>) = fitting.iter().partition(is_rgb);
    let common = |of: &[&Fitting], count| common(of, count, &terms);
    let tries = [common(&alike, 6), common(&rgb, 18), common(&others, 6)];
    let mut acts: Vec<Act> = Vec::new();
    acts.extend(other_numbers(search, set, &finals));
    for places in tries.into_iter().flatten() {
        let act = Act::Terms(Terms(
            places.into_iter().map(|place| terms[place]).collect(),
        ));
        if !acts.contains(&act) {
            acts.push(act);
        }
    }
    acts
}

/// Texts that stand for other numbers in every file that is wrong.
fn other_numbers(search: &Search, set: &Set, finals: &[usize]) -> Option<Act> {
    let used = search.each(finals, |&w| {
        let pair = pair_of(search, set, w)?;
        all_used(&pair, &search.witnesses[w])
    });
    let files = finals
        .iter()
        .zip(used)
        .filter_map(|(&w, used)| Some((w, used?)));
    let files: Vec<(usize, Vec<Used>)> = files.collect();
    if files.len() < FEWEST {
        return None;
    }
    let used = files
        .into_iter()
        .flat_map(|(w, used)| used.into_iter().map(move |used| (w, used)));
    OtherNumbers::of(used.map(|(w, used)| (&search.witnesses[w], used))).map(Act::OtherNumbers)
}

/// The terms that fit all files, an exchange before all others, and then the first; nothing if there are none, or if these are
/// the right ones.
fn common(files: &[&Fitting], count: usize, terms: &[(Source, Source)]) -> Option<Vec<usize>> {
    if files.len() < FEWEST {
        return None;
    }
    let fits = |i: usize, place: &usize| {
        files.iter().all(|file| {
            let mut channels = (i..file.of.len()).step_by(count);
            channels.all(|channel| file.of[channel][*place])
        })
    };
    if let Some(places) = exchange(terms, count, fits) {
        return Some(places);
    }
    let places: Vec<usize> = (0..count)
        .map(|i| (0..terms.len()).find(|place| fits(i, place)))
        .collect::<Option<_>>()?;
    places.iter().any(|&place| place > 0).then_some(places)
}

/// The places of the terms of the first exchange that fits.
fn exchange(
    terms: &[(Source, Source)],
    count: usize,
    fits: impl Fn(usize, &usize) -> bool,
) -> Option<Vec<usize>> {
    Terms::exchanges().into_iter().find_map(|Terms(exchange)| {
        let place = |term: &(Source, Source)| terms.iter().position(|other| other == term);
        let places: Vec<usize> = exchange.iter().map(place).collect::<Option<_>>()?;
        let fits = places.len() == count && (0..count).all(|i| fits(i, &places[i]));
        fits.then_some(places)
    })
}

fn fitting(search: &Search, set: &Set, w: usize, terms: &[(Source, Source)]) -> Option<Fitting> {
    let witness = &search.witnesses[w];
    let Response::Picture {
        frame: Some(received),
        ..
    } = &witness.observation.response
    else {
        return None;
    };
    let made = search.made(w, set);
    let Answer::Decoded(made) = &*made else {
        return None;
    };
    let pair = Pair::of(made, received)?;
    let ptm: Ptm = witness.planes(&search.mistakes_of(set)).ok()?;
    let planes = &ptm.planes;
    if planes.samples.len() != pair.got.len() {
        return None;
    }
    let of = |channel: usize| {
        let places = || (channel..pair.got.len()).step_by(pair.channels);
        let fits = |&term: &(Source, Source)| {
            places().all(|i| {
                let value =
                    final_value(planes.samples[i], channel % 6, term, &ptm.header.scale_bias);
                is_close(value, pair.got[i], 0.0) || f64::from(value as f32) == pair.got[i]
            })
        };
        terms.iter().map(fits).collect()
    };
    Some(Fitting {
        shape: planes.shape,
        of: (0..planes.shape.coefficients()).map(of).collect(),
    })
}
