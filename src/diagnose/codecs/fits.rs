//! Which slips in the decoder of a codec make just what is shown of its streams.

use super::file_streams::{FileStreams, Fit};
use super::stream_slips::StreamSlip;
use crate::diagnose::search::Search;
use crate::ptm::Format;
use crate::suite::cases::Expect;

/// Fewer wrong samples and refused files may agree by chance.
const FEWEST: usize = 4;
/// For so many pictures that are just as a slip makes them one may be otherwise: what else is wrong there has another cause.
const NEARLY_ALL: usize = 10;
/// Slips that are held against everything that was answered.
const SINGLES: usize = 4;
/// Slips that may be one of two, and files on which these are looked for.
const HALVES: usize = 12;
const FILES: usize = 16;
/// Samples of a plane that is gone through.
const LARGE: usize = 1 << 13;

/// What a slip explains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Count {
    same: usize,
    other: usize,
    wrong: usize,
    refused: usize,
}

/// Slips that explain what is shown of the files in `left` beside those known `before`: one, or two made together. The best
/// come first.
pub(in crate::diagnose) fn fitting(
    search: &Search,
    formats: [Format; 2],
    before: &[StreamSlip],
    left: &[usize],
) -> Vec<Vec<StreamSlip>> {
    let files = files(search, formats, left);
    // Where the reference's own samples are shown, the streams are read right.
    let pictures: Vec<&FileStreams> = (files.iter())
        .filter(|file| file.fit(before) == Fit::Other)
        .collect();
    let refused: Vec<&FileStreams> = (files.iter())
        .filter(|file| file.fit(&[]) == Fit::Picture)
        .collect();
    if pictures.is_empty() {
        return Vec::new();
    }
    let slips: Vec<StreamSlip> = StreamSlip::all()
        .filter(|slip| slip.is_of(formats[0]) && !before.contains(slip))
        .collect();
    let with = |more: &[StreamSlip]| [before, more].concat();
    let alone: Vec<Vec<StreamSlip>> = slips.iter().map(|&slip| with(&[slip])).collect();
    let single = best(search, formats, &alone, &pictures, &refused);
    if !single.is_empty() {
        return single
            .into_iter()
            .map(|set| set[before.len()..].to_vec())
            .collect();
    }
    let pairs = pairs(search, &slips, &alone, &pictures);
    let both = best(search, formats, &pairs, &pictures, &refused);
    both.into_iter()
        .take(1)
        .map(|set| set[before.len()..].to_vec())
        .collect()
}

/// Two slips each, of which one or the other makes the first wrong samples of nearly all planes. `alone` are the slips beside
/// those that are known.
fn pairs(
    search: &Search,
    slips: &[StreamSlip],
    alone: &[Vec<StreamSlip>],
    pictures: &[&FileStreams],
) -> Vec<Vec<StreamSlip>> {
    let first = &pictures[..pictures.len().min(FILES)];
    let begins = search.each(alone, |set| {
        let of_files = first.iter().map(|file| file.begins(set));
        of_files.collect::<Vec<_>>().concat()
    });
    let mut halves: Vec<(Vec<bool>, usize)> = begins.into_iter().zip(0..).collect();
    halves.retain(|(planes, _)| planes.contains(&true));
    let begun = |planes: &[bool]| planes.iter().filter(|is| **is).count();
    halves.sort_by_key(|(planes, _)| std::cmp::Reverse(begun(planes)));
    let pairs = halves
        .iter()
        .take(HALVES)
        .enumerate()
        .flat_map(|(i, (planes, one))| {
            // Of two slips one or the other makes the first wrong sample of a plane.
            let makes_rest = move |(more, _): &&(Vec<bool>, usize)| {
                let missed = planes
                    .iter()
                    .zip(more)
                    .filter(|(one, other)| !**one && !**other);
                missed.count() * NEARLY_ALL <= planes.len()
            };
            let others = halves[i + 1..].iter().filter(makes_rest);
            others.map(move |(_, other)| [&alone[*one][..], &[slips[*other]]].concat())
        });
    pairs.collect()
}

/// The files in `of` whose streams are known, the smallest first.
fn files<'a>(search: &Search<'a>, formats: [Format; 2], of: &[usize]) -> Vec<FileStreams<'a>> {
    let witnesses = search.witnesses;
    let is_small = |w: &usize| {
        let size = witnesses[*w].case.recipe().map(|recipe| recipe.size);
        size.is_some_and(|size| size.texels() <= LARGE)
    };
    let is_of = |w: &usize| {
        let case = witnesses[*w].case;
        case.expect == Expect::Decode && formats.contains(&case.format())
    };
    let of = of.iter().filter(|w| is_of(w) && is_small(w));
    let mut files: Vec<FileStreams> = of.filter_map(|&w| FileStreams::of(&witnesses[w])).collect();
    files.sort_by_key(FileStreams::len);
    files
}

/// Those sets of slips that make what is shown, and get no file wrong that is right.
fn best(
    search: &Search,
    formats: [Format; 2],
    sets: &[Vec<StreamSlip>],
    pictures: &[&FileStreams],
    refused: &[&FileStreams],
) -> Vec<Vec<StreamSlip>> {
    // Most of many are out on a few files.
    let first = &pictures[..pictures.len().min(FILES)];
    let of_first = search.each(sets, |set| count(set, first).is_some());
    let likely = sets.iter().zip(of_first).filter(|(_, is)| *is);
    let likely: Vec<&Vec<StreamSlip>> = likely.map(|(set, _)| set).collect();
    let counts = search.each(&likely, |set| count(set, pictures));
    let mut counted: Vec<(Count, &Vec<StreamSlip>)> = (counts.into_iter().zip(likely))
        .filter_map(|(count, set)| Some((count?, set)))
        .filter(|(count, _)| count.wrong > 0 && count.other * NEARLY_ALL <= count.same)
        .collect();
    for (count, set) in &mut counted {
        let is_refused = |file: &&&FileStreams| file.fit(set) == Fit::Refused;
        count.refused = refused.iter().filter(is_refused).count();
    }
    counted.retain(|(count, _)| count.wrong + count.refused >= FEWEST);
    counted.sort_by_key(|(count, _)| std::cmp::Reverse((count.same + count.refused, count.wrong)));
    let passing: Vec<usize> = (0..search.witnesses.len())
        .filter(|&w| !search.witnesses[w].failed)
        .collect();
    let right = match counted.is_empty() {
        true => Vec::new(),
        false => files(search, formats, &passing),
    };
    let mut best: Vec<(Count, Vec<StreamSlip>)> = Vec::new();
    for (count, set) in counted {
        // What makes fewer of the wrong samples is not the same.
        let is_less = |(first, _): &(Count, _)| *first != count;
        if best.len() == SINGLES || best.first().is_some_and(is_less) {
            break;
        }
        let denies = search.each(&right, |file| file.fit(set) == Fit::Other);
        if !denies.contains(&true) {
            best.push((count, set.clone()));
        }
    }
    best.into_iter().map(|(_, set)| set).collect()
}

/// How many pictures are just as these slips make them; nothing where too many are not.
fn count(set: &[StreamSlip], pictures: &[&FileStreams]) -> Option<Count> {
    let mut count = Count::default();
    for file in pictures {
        match file.fit(set) {
            Fit::Same(wrong) => {
                count.same += 1;
                count.wrong += wrong;
            }
            Fit::Other => count.other += 1,
            _ => {}
        }
        if count.other * NEARLY_ALL > pictures.len() {
            return None;
        }
    }
    Some(count)
}
