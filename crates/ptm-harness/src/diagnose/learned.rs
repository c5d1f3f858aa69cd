//! Mistakes that map each correct value to a wrong one: tables of stored values or of stream samples, learned from the images.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::mistake::edits_as_misreading;
use super::search::{MistakeSet, Search};
use super::tuning::{MIN_SHARING_FILES, is_few, is_most};
use super::witness::Witness;
use ptm::{Coding, Ptm, Size};
use ptm_mistakes::Misreading;
use ptm_mistakes::formula::{Edit, EditedForm, Formula};
use ptm_suite::protocol::frame::{Answer, Frame, Samples, View};

/// Stored values that could produce an output value: one flag for each value from 0 to 255.
type Candidates = [bool; 256];

struct ObservedOutputs {
    /// For each stored value, the number of texels that it could explain.
    votes: [usize; 256],
    texels: usize,
    files: Vec<usize>,
}

/// Returns misreadings that explain wrong values in `left`. Each maps all stored values, or all stream samples, through a table.
pub fn learn_tables(search: &Search, set: &MistakeSet, left: &[usize]) -> Vec<&'static Misreading> {
    let images = search.comparable_images(left);
    let is_jpeg = |w: &usize| search.witnesses[*w].case.format().coding() == Some(Coding::Jpeg);
    let (streams, values): (Vec<usize>, Vec<usize>) = images.into_iter().partition(is_jpeg);
    let tables = [
        learn_table(search, set, &streams, true).map(|table| (Formula::StreamSample, table)),
        learn_table(search, set, &values, false).map(|table| (Formula::StoredValue, table)),
    ];
    let misreading = |(formula, table)| -> &'static Misreading {
        let change = EditedForm::Table(Box::new(table));
        // Leaks at most two tables per diagnosis.
        let edit: &'static Edit = Box::leak(Box::new(Edit { formula, change }));
        Box::leak(Box::new(edits_as_misreading(std::slice::from_ref(edit))))
    };
    tables.into_iter().flatten().map(misreading).collect()
}

/// Learns the table that explains every value in these images, if each value is a function of the correct value.
fn learn_table(
    search: &Search,
    set: &MistakeSet,
    images: &[usize],
    only_plain_planes: bool,
) -> Option<[u8; 256]> {
    let mut shown: BTreeMap<u8, ObservedOutputs> = BTreeMap::new();
    for &w in images {
        let witness = &search.witnesses[w];
        let (Ok(ptm), Some(frame)) = (witness.decoded(), witness.wrong_image()) else {
            continue;
        };
        // The search later compares the table with corrected and predicted planes.
        let channels = ptm.planes.shape.channels();
        let is_plain = |channel: usize| !only_plain_planes || witness.is_plain_plane(channel);
        let sources = candidate_sources(search, set, witness, ptm, frame)?;
        for (i, (&right, candidates)) in ptm.planes.samples.iter().zip(sources).enumerate() {
            if !is_plain(i % channels) {
                continue;
            }
            let known = shown.entry(right).or_insert_with(|| ObservedOutputs {
                votes: [0; 256],
                texels: 0,
                files: Vec::new(),
            });
            for (votes, is_candidate) in known.votes.iter_mut().zip(candidates) {
                *votes += usize::from(is_candidate);
            }
            known.texels += 1;
            if known.files.last() != Some(&w) {
                known.files.push(w);
            }
        }
    }
    let mut table: [u8; 256] = std::array::from_fn(|value| value as u8);
    let mut reliable = 0;
    for (&right, shown) in &shown {
        // Inverse transforms may differ by one, so a few texels disagree.
        let votes = |value: u8| shown.votes[usize::from(value)];
        let best = (0..=255).max_by_key(|&value| (votes(value), Reverse(value.abs_diff(right))))?;
        if is_few(votes(best) - votes(right), shown.texels) {
            continue;
        }
        if !is_most(votes(best), shown.texels) {
            return None;
        }
        table[usize::from(right)] = best;
        // A value that occurs once, or in one file, is not reliable.
        reliable += usize::from(shown.files.len() >= MIN_SHARING_FILES);
    }
    // Most entries of a plausible table are supported by several files.
    let changed = (0..256).filter(|&value| usize::from(table[value]) != value);
    (reliable > 1 && is_most(reliable, changed.count())).then_some(table)
}

/// Returns, for each sample of an image, the stored values for which a decoder with the mistakes in `set` outputs this sample.
fn candidate_sources(
    search: &Search,
    set: &MistakeSet,
    witness: &Witness,
    ptm: &Ptm,
    frame: &Frame,
) -> Option<Vec<Candidates>> {
    match (&witness.observation.view, &frame.samples) {
        (View::Raw, Samples::U8(samples)) => {
            let flags = |&shown: &u8| std::array::from_fn(|value| value == usize::from(shown));
            Some(samples.iter().map(flags).collect())
        }
        (View::Coef, Samples::F32(samples)) => {
            let channels = ptm.planes.shape.channels();
            let Answer::Decoded(Frame {
                samples: Samples::F32(made),
                ..
            }) = witness.render_stored_values(&search.mistakes_in(set), &map_of_all_values(ptm))
            else {
                return None;
            };
            let flags = |(i, &shown): (usize, &f32)| {
                let channel = i % channels;
                std::array::from_fn(|value| made.get(value * channels + channel) == Some(&shown))
            };
            Some(samples.iter().enumerate().map(flags).collect())
        }
        _ => None,
    }
}

/// Returns a map with the header of `ptm` and 256 texels: all stored values of texel t are t.
fn map_of_all_values(ptm: &Ptm) -> Ptm {
    let mut map = ptm.clone();
    let size = Size {
        width: 256,
        height: 1,
    };
    map.header.size = size;
    map.planes.size = size;
    let channels = map.planes.shape.channels();
    let texels = (0..=255).flat_map(|value| std::iter::repeat_n(value, channels));
    map.planes.samples = texels.collect();
    map
}
