//! Streams of planes that come out wrong: a mistake in the decoder's own JPEG or JPEG-LS.
//!
//! Such a mistake loses its place in some streams and not in others, and ends in a refusal here and in nonsense there. It
//! shows in planes that are not predicted, which nothing but their stream makes.

use super::diagnosis::{Category, Diagnosis, Words};
use super::failure_mode::FailureMode;
use super::pictures;
use super::refusals::{self, example};
use super::search::{Found, Id, Search, of};
use super::traits::{TRAITS, traits};
use super::witness::Witness;
use crate::protocol::frame::View;
use crate::ptm::Format;
use crate::suite::cases::Expect;

/// What the planes of some formats are streams of, and its standard.
const CODECS: [(&str, &str, [Format; 2]); 2] = [
    ("JPEG", "T.81", [Format::JpegRgb, Format::JpegLrgb]),
    ("JPEG-LS", "T.87", [Format::JpeglsRgb, Format::JpeglsLrgb]),
];

/// The first sample of a plane that comes out wrong, in the order of the stream.
struct First {
    plane: usize,
    row: usize,
    column: usize,
    want: f64,
    got: f64,
}

/// One diagnosis for each codec that goes wrong. Its failures are taken out of `left`.
pub(super) fn describe(search: &Search, found: &Found, left: &mut Vec<usize>) -> Vec<Diagnosis> {
    let witnesses = search.witnesses;
    let set = of(&found.members);
    let mut diagnoses = Vec::new();
    for (codec, standard, formats) in CODECS {
        let is_legal = |w: &usize| {
            let case = witnesses[*w].case;
            formats.contains(&case.format()) && case.expect == Expect::Decode
        };
        let is_near = |w: usize| {
            let near = |&member: &Id| pictures::is_near(search, w, &set, member);
            FailureMode::of(&witnesses[w]).is_none() && set.iter().any(near)
        };
        let open: Vec<usize> = left
            .iter()
            .copied()
            .filter(|w| is_legal(w) && !is_near(*w))
            .collect();
        let (refused, wrong): (Vec<usize>, Vec<usize>) = open
            .iter()
            .partition(|&&w| FailureMode::of(&witnesses[w]).is_some());
        let firsts: Vec<(usize, First)> = wrong
            .iter()
            .filter_map(|&w| Some((w, first_wrong(search, &set, w)?)))
            .collect();
        // What only goes wrong where planes are predicted has another cause, and so has what other formats share.
        let in_streams = firsts.len() * 2 > wrong.len() || refused.len() > 3 * wrong.len();
        let elsewhere = left.iter().filter(|&&w| {
            let case = witnesses[w].case;
            case.expect == Expect::Decode && !formats.contains(&case.format())
        });
        let one_trait = !refused.is_empty()
            && refusals::widest(witnesses, &refused)
                .iter()
                .any(|of| of.len() == refused.len());
        if !in_streams || elsewhere.count() * 4 > open.len() || one_trait {
            continue;
        }
        let all: Vec<usize> = (0..witnesses.len()).filter(is_legal).collect();
        let effect = format!(
            "goes wrong in {codec} streams: of {} such files {} come out wrong and {} not at all{}",
            all.len(),
            wrong.len(),
            refused.len(),
            shared_by(witnesses, &open, &all),
        );
        left.retain(|w| !open.contains(w));
        let words = Words {
            effect,
            fix: format!(
                "compare the decoder of these streams with {standard}, from the first sample that is wrong"
            ),
            example: example_of(witnesses, &firsts, &refused),
        };
        let category = match wrong.is_empty() {
            true => Category::Refusal,
            false => Category::Difference,
        };
        diagnoses.push(Diagnosis::described(category, witnesses, &open, words).about("2.9.8/3"));
    }
    diagnoses
}

/// The first wrong sample of the smallest file, or the smallest file that was refused.
fn example_of(witnesses: &[Witness], firsts: &[(usize, First)], refused: &[usize]) -> String {
    let smallest = firsts
        .iter()
        .min_by_key(|(w, _)| witnesses[*w].built.file.len());
    match smallest {
        Some((w, first)) => format!(
            "for example {}, plane {}: received {}, expected {} in column {} of row {} of its stream, the first that is wrong, both counted from 0",
            witnesses[*w].case.id, first.plane, first.got, first.want, first.column, first.row
        ),
        None => example(witnesses, refused),
    }
}

/// What all these files have, and few others of `all`.
fn shared_by(witnesses: &[Witness], these: &[usize], all: &[usize]) -> String {
    let has = |w: &usize, one: usize| traits(&witnesses[*w]).has[one];
    let others = || all.iter().filter(|&&w| !witnesses[w].failed);
    let rarest = (0..TRAITS.len())
        .filter(|&one| !TRAITS[one].is_view && these.iter().all(|w| has(w, one)))
        .map(|one| (one, others().filter(|w| has(w, one)).count()))
        .min_by_key(|&(_, count)| count);
    match rarest {
        Some((one, count)) if these.len() > 2 && count * 2 < others().count() => {
            let says = &TRAITS[one].says;
            format!(", all of them {says}; of those that it reads {count} are so")
        }
        _ => String::new(),
    }
}

/// Where the first plane goes wrong that is not predicted, if one does; records that land elsewhere spoil no more than two
/// texels each.
fn first_wrong(search: &Search, set: &[Id], w: usize) -> Option<First> {
    let witness = &search.witnesses[w];
    if matches!(witness.observation.view, View::Rgb(_)) {
        return None;
    }
    let pair = pictures::pair_of(search, set, w)?;
    let plan = witness.case.compression()?;
    let stored = |i: usize| {
        let (texel, plane) = (i / pair.channels, i % pair.channels);
        (
            plane,
            pair.height - 1 - texel / pair.width,
            texel % pair.width,
        )
    };
    let intra = pair
        .wrong()
        .into_iter()
        .filter(|i| plan.reference(i % pair.channels).is_none());
    let intra: Vec<usize> = intra.collect();
    let mut wrong = vec![0; pair.channels];
    for i in &intra {
        wrong[i % pair.channels] += 1;
    }
    let coded = witness.model().and_then(|model| model.compressed.as_ref());
    let records = |plane: usize| Some(coded?.planes.get(plane)?.records.len());
    let is_of_stream = |plane: usize| wrong[plane] > 2 * records(plane).unwrap_or_default();
    let by_stream = intra
        .into_iter()
        .filter(|i| is_of_stream(i % pair.channels));
    let first = by_stream.min_by_key(|&i| stored(i))?;
    let (plane, row, column) = stored(first);
    Some(First {
        plane,
        row,
        column,
        want: pair.want[first],
        got: pair.got[first],
    })
}
