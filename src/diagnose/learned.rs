//! Mistakes that are a function of the correct value alone, read from the images: a table of stored values or stream samples.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::mistake::misreading_of;
use super::search::{Search, Set};
use super::tuning::{MIN_SHARING_FILES, is_few, is_most};
use super::witness::Witness;
use crate::formula::{Edit, EditedForm, Formula};
use crate::misreadings::Misreading;
use crate::protocol::frame::{Answer, Frame, Samples, View};
use crate::ptm::{Coding, Ptm};

/// The stored values that may have been shown as one value: a bit for each of 0 to 255.
type Candidates = [bool; 256];

/// The values that were shown for one correct value.
struct ShownValues {
    /// For each stored value, the texels in which it may have been shown.
    votes: [usize; 256],
    texels: usize,
    files: Vec<usize>,
}

/// Returns misreadings by tables that explain wrong values in `left`: of all stored values, and of the samples of streams.
pub(super) fn tables(search: &Search, set: &Set, left: &[usize]) -> Vec<&'static Misreading> {
    let pictures = search.solvable(left);
    let of_streams = |w: &usize| search.witnesses[*w].case.format().coding() == Some(Coding::Jpeg);
    let (streams, values): (Vec<usize>, Vec<usize>) = pictures.into_iter().partition(of_streams);
    let tables = [
        table(search, set, &streams, true).map(|table| (Formula::StreamSample, table)),
        table(search, set, &values, false).map(|table| (Formula::StoredValue, table)),
    ];
    let misreading = |(formula, table)| -> &'static Misreading {
        let change = EditedForm::Table(Box::new(table));
        // Two tables for each diagnosis live as long as the program.
        let edit: &'static Edit = Box::leak(Box::new(Edit { formula, change }));
        Box::leak(Box::new(misreading_of(edit)))
    };
    tables.into_iter().flatten().map(misreading).collect()
}

/// Returns the table that explains every value of these images, if each is a function of the correct value.
fn table(search: &Search, set: &Set, pictures: &[usize], of_streams: bool) -> Option<[u8; 256]> {
    let mut shown: BTreeMap<u8, ShownValues> = BTreeMap::new();
    for &w in pictures {
        let witness = &search.witnesses[w];
        let (Ok(ptm), Some(frame)) = (witness.decoded(), witness.shown()) else {
            continue;
        };
        // Corrected and predicted planes are compared with the table later.
        let channels = ptm.planes.shape.channels();
        let is_plain = |channel: usize| !of_streams || witness.is_of_stream(channel);
        let sources = sources(search, set, witness, ptm, frame)?;
        for (at, (&right, candidates)) in ptm.planes.samples.iter().zip(sources).enumerate() {
            if !is_plain(at % channels) {
                continue;
            }
            let known = shown.entry(right).or_insert_with(|| ShownValues {
                votes: [0; 256],
                texels: 0,
                files: Vec::new(),
            });
            for (votes, is) in known.votes.iter_mut().zip(candidates) {
                *votes += usize::from(is);
            }
            known.texels += 1;
            if known.files.last() != Some(&w) {
                known.files.push(w);
            }
        }
    }
    let mut table: [u8; 256] = std::array::from_fn(|value| value as u8);
    let mut differing = 0;
    for (&right, shown) in &shown {
        // Inverse transforms differ by one here and there, so a few texels disagree.
        let votes = |value: u8| shown.votes[usize::from(value)];
        let best = (0..=255).max_by_key(|&value| (votes(value), Reverse(value.abs_diff(right))))?;
        if is_few(votes(best) - votes(right), shown.texels) {
            continue;
        }
        if !is_most(votes(best), shown.texels) {
            return None;
        }
        table[usize::from(right)] = best;
        // A value seen once, or in one file, may be anything.
        differing += usize::from(shown.files.len() >= MIN_SHARING_FILES);
    }
    // A table is shorter than the data: most values of it are seen in several files.
    let changed = (0..256).filter(|&value| usize::from(table[value]) != value);
    (differing > 1 && is_most(differing, changed.count())).then_some(table)
}

/// Returns, for each sample of an image, the stored values for which a decoder with the mistakes of `set` shows it.
fn sources(
    search: &Search,
    set: &Set,
    witness: &Witness,
    ptm: &Ptm,
    frame: &Frame,
) -> Option<Vec<Candidates>> {
    match (&witness.observation.view, &frame.samples) {
        (View::Raw, Samples::U8(samples)) => {
            let only = |&shown: &u8| std::array::from_fn(|value| value == usize::from(shown));
            Some(samples.iter().map(only).collect())
        }
        (View::Coef, Samples::F32(samples)) => {
            let mut sources = vec![[false; 256]; samples.len()];
            for value in 0..=255u8 {
                let mut uniform = ptm.clone();
                uniform.planes.samples.fill(value);
                let Answer::Decoded(Frame {
                    samples: Samples::F32(made),
                    ..
                }) = witness.show(&search.mistakes_of(set), &uniform)
                else {
                    return None;
                };
                for (at, (made, shown)) in made.iter().zip(samples).enumerate() {
                    sources[at][usize::from(value)] = made == shown;
                }
            }
            Some(sources)
        }
        _ => None,
    }
}
