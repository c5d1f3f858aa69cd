//! Where the streams of planes first come out wrong, and what is so there.
//!
//! Of planes that are neither predicted nor corrected nothing but their stream makes the samples.

use super::jpeg_blocks::{self, blocks};
use super::jpeg_ls_samples::{self, samples};
use super::separate::{Evidence, Feature, Features};
use crate::diagnose::failure_mode::FailureMode;
use crate::diagnose::pair::Pair;
use crate::diagnose::search::{Id, Search};
use crate::diagnose::witness::Witness;
use crate::diagnose::words::pictures;
use crate::generate::plan::Stream;
use crate::protocol::frame::View;
use crate::ptm::Format;

/// Samples of a plane that is gone through.
const LARGE: usize = 1 << 13;

/// What the planes of some formats are streams of.
pub(in crate::diagnose) struct Codec {
    pub name: &'static str,
    pub standard: &'static str,
    pub formats: [Format; 2],
    /// What comes out right or wrong as a whole, and how many samples it is wide and high.
    pub places: &'static str,
    pub side: usize,
    /// The features of all places of a stream.
    features: fn(&[u8], (usize, usize), Stream) -> Vec<Features>,
    /// How many of them, the first ones, are of whole streams.
    pub of_streams: usize,
    /// What each feature says.
    pub says: fn() -> Vec<&'static str>,
}

/// Both of them.
pub(in crate::diagnose) const CODECS: [Codec; 2] = [
    Codec {
        name: "JPEG",
        standard: "T.81",
        formats: [Format::JpegRgb, Format::JpegLrgb],
        places: "blocks",
        side: 8,
        features: |bytes, size, stream| {
            Features::of_all(&blocks(bytes, size, stream), &jpeg_blocks::FEATURES)
        },
        of_streams: jpeg_blocks::OF_STREAMS,
        says: || words(&jpeg_blocks::FEATURES),
    },
    Codec {
        name: "JPEG-LS",
        standard: "T.87",
        formats: [Format::JpeglsRgb, Format::JpeglsLrgb],
        places: "samples",
        side: 1,
        features: |bytes, size, stream| {
            Features::of_all(&samples(bytes, size, stream), &jpeg_ls_samples::FEATURES)
        },
        of_streams: jpeg_ls_samples::OF_STREAMS,
        says: || words(&jpeg_ls_samples::FEATURES),
    },
];

fn words<P>(features: &'static [Feature<P>]) -> Vec<&'static str> {
    features.iter().map(|one| &one.says[..]).collect()
}

/// The first sample of a plane that comes out wrong, in the order of the stream.
pub(in crate::diagnose) struct First {
    pub plane: usize,
    pub row: usize,
    pub column: usize,
    pub want: f64,
    pub got: f64,
    /// Whether all samples of its block are off by one amount; nothing where they are alike anyway.
    pub is_uniform: Option<bool>,
    /// Whether most blocks after it are right; nothing where there are none.
    pub recovers: Option<bool>,
}

/// What the files of a codec tell. `legal` are all that must be read.
pub(in crate::diagnose) fn evidence(
    search: &Search,
    set: &[Id],
    codec: &Codec,
    legal: &[usize],
) -> Evidence {
    let of_files = search.each(legal, |&w| of_file(search, set, codec, w));
    let mut all = Evidence::default();
    for one in of_files {
        all.wrong.extend(one.wrong);
        all.refused.extend(one.refused);
        all.read.extend(one.read);
        for (features, count) in one.right {
            *all.right.entry(features).or_default() += count;
        }
        for (features, count) in one.unknown {
            *all.unknown.entry(features).or_default() += count;
        }
    }
    all
}

/// What one file tells.
fn of_file(search: &Search, set: &[Id], codec: &Codec, w: usize) -> Evidence {
    let witness = &search.witnesses[w];
    let mut evidence = Evidence::default();
    let Some(coded) = witness.model().and_then(|model| model.compressed.as_ref()) else {
        return evidence;
    };
    let size = witness.case.recipe().map(|recipe| recipe.size);
    let size = size.map_or((0, 0), |size| (size.width as usize, size.height as usize));
    if size.0 * size.1 > LARGE {
        return evidence;
    }
    let is_refused = FailureMode::of(witness).is_some();
    let firsts = match witness.failed && !is_refused {
        true => firsts(search, set, codec, w),
        false => Vec::new(),
    };
    let mut occurring = Features::default();
    for (plane, stored) in coded.planes.iter().enumerate() {
        let plan = &coded.plan;
        let stream = if plan.alternates && plane % 2 == 1 {
            Stream::PLAIN
        } else {
            plan.stream
        };
        let mut features = (codec.features)(&stored.stream, size, stream);
        let mut before = Features::default();
        for one in &mut features {
            before = std::mem::replace(one, one.after(before));
        }
        for &one in &features {
            occurring.add(one);
        }
        let first = firsts.iter().find(|first| first.plane == plane);
        let columns = size.0.div_ceil(codec.side);
        let first = first.map(|first| first.row / codec.side * columns + first.column / codec.side);
        let is_known =
            !is_refused && witness.is_of_stream(plane) && !(witness.failed && is_rgb(witness));
        for &one in features.iter().take(first.unwrap_or(features.len())) {
            if is_known {
                *evidence.right.entry(one).or_default() += 1;
            } else if is_refused {
                *evidence.unknown.entry(one).or_default() += 1;
            }
        }
        evidence
            .wrong
            .extend(first.and_then(|first| features.get(first)));
    }
    match witness.failed {
        true if is_refused => evidence.refused.push(occurring),
        true => {}
        false => evidence.read.push(occurring),
    }
    evidence
}

fn is_rgb(witness: &Witness) -> bool {
    matches!(witness.observation.view, View::Rgb(_))
}

/// Where each such plane first comes out wrong, of a picture that was received.
pub(in crate::diagnose) fn firsts(
    search: &Search,
    set: &[Id],
    codec: &Codec,
    w: usize,
) -> Vec<First> {
    let witness = &search.witnesses[w];
    if is_rgb(witness) {
        return Vec::new();
    }
    let Some(pair) = pictures::pair_of(search, set, w) else {
        return Vec::new();
    };
    let of_stream = (0..pair.channels).filter(|&plane| witness.is_of_stream(plane));
    let slack = witness.model().map_or(&[][..], |model| &model.slack);
    of_stream
        .filter_map(|plane| first_of_plane(&pair, slack, codec, plane))
        .collect()
}

/// The first wrong sample of a plane, in the order of the stream.
fn first_of_plane(pair: &Pair, slack: &[u8], codec: &Codec, plane: usize) -> Option<First> {
    let side = codec.side;
    // The stream has the bottom row first.
    let at = |row: usize, column: usize| {
        ((pair.height - 1 - row) * pair.width + column) * pair.channels + plane
    };
    let is_wrong = |i: usize| {
        let off = (pair.want[i] - pair.got[i]).abs();
        let slack = slack.get(i).copied().map_or(0.0, f64::from);
        // Samples are numbers modulo 256 where an inverse DCT may differ.
        let is_allowed = pair.view == "raw" && slack > 0.0 && off.min(256.0 - off) <= slack;
        !pair.near(pair.want[i], pair.got[i]) && !is_allowed
    };
    let (columns, rows) = (pair.width.div_ceil(side), pair.height.div_ceil(side));
    let of_block = |block: usize| {
        let (top, left) = (block / columns * side, block % columns * side);
        let below = top..(top + side).min(pair.height);
        below.flat_map(move |row| {
            (left..(left + side).min(pair.width)).map(move |column| (row, column))
        })
    };
    let wrong_in = |block: usize| of_block(block).find(|&(row, column)| is_wrong(at(row, column)));
    let first = (0..columns * rows).find(|&block| wrong_in(block).is_some())?;
    let (row, column) = wrong_in(first)?;
    let later = columns * rows - first - 1;
    let right = (first + 1..columns * rows).filter(|&block| wrong_in(block).is_none());
    Some(First {
        plane,
        row,
        column,
        want: pair.want[at(row, column)],
        got: pair.got[at(row, column)],
        is_uniform: is_uniform(
            of_block(first)
                .map(|(row, column)| at(row, column))
                .map(|i| (pair.want[i], pair.got[i])),
        ),
        recovers: (later > 0).then(|| right.count() * 2 >= later),
    })
}

/// Whether samples are off by one amount, but for rounding and for limits at 0 and 255; nothing where they should be alike.
fn is_uniform(samples: impl Iterator<Item = (f64, f64)> + Clone) -> Option<bool> {
    let first = samples.clone().next()?.0;
    if samples.clone().all(|(want, _)| want == first) {
        return None;
    }
    let limits = |value: f64| value == 0.0 || value == 255.0;
    let free = samples.filter(|&(want, got)| !limits(want) && !limits(got));
    let off = free.map(|(want, got)| want - got);
    let (least, most) = off.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
    (least <= most).then_some(most - least <= 1.0)
}

#[cfg(test)]
mod tests {
    use super::is_uniform;

    #[test]
    fn a_block_off_by_one_amount_may_be_rounded_and_limited() {
        let of = |samples: &[(u8, u8)]| {
            is_uniform(
                samples
                    .iter()
                    .map(|&(want, got)| (f64::from(want), f64::from(got))),
            )
        };
        assert_eq!(of(&[(10, 42), (20, 53), (240, 255)]), Some(true));
        assert_eq!(of(&[(10, 42), (20, 20)]), Some(false));
        assert_eq!(of(&[(10, 42), (10, 42)]), None, "a block of one value");
    }
}
