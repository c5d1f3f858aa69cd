//! First files that are all wrong in one and the same way: turned over, channels exchanged, scaled.
//!
//! Such a mistake fails hundreds of cases and is one mistake. It is looked for among a few changes of whole pictures: what
//! was received is changed back and held against what was expected, by the ordinary tolerances.

use crate::harness::cases::Suite;
use crate::harness::check::Run;
use crate::harness::compare::{Expected, ExpectedValues};
use crate::harness::protocol::{Answer, Frame, Samples};

/// A change of whole pictures.
struct Transform {
    /// What it does, behind "pictures are".
    words: &'static str,
    /// Puts a picture right that it has changed; nothing where it cannot have.
    undo: fn(&Frame) -> Option<Frame>,
}

const TRANSFORMS: &[Transform] = &[
    Transform {
        words: "upside down: rows are sent top row first, and files store the bottom row first",
        undo: |frame| {
            rearranged(frame, (frame.width, frame.height), |x, y| {
                (x, frame.height as usize - 1 - y)
            })
        },
    },
    Transform {
        words: "mirrored: each row is sent from left to right",
        undo: |frame| {
            rearranged(frame, (frame.width, frame.height), |x, y| {
                (frame.width as usize - 1 - x, y)
            })
        },
    },
    Transform {
        words: "turned by 180 degrees: texels are sent from the top left to the bottom right",
        undo: |frame| {
            rearranged(frame, (frame.width, frame.height), |x, y| {
                (frame.width as usize - 1 - x, frame.height as usize - 1 - y)
            })
        },
    },
    Transform {
        words: "transposed: texels are sent row after row, and not column after column",
        undo: |frame| rearranged(frame, (frame.height, frame.width), |x, y| (y, x)),
    },
    Transform {
        words: "sent column after column, under the right size: texels are sent row after row",
        undo: |frame| {
            let (width, height) = (frame.width as usize, frame.height as usize);
            rearranged(frame, (frame.width, frame.height), |x, y| {
                let place = x * height + y;
                (place % width, place / width)
            })
        },
    },
    Transform {
        words: "sent with red and blue exchanged (BGR): the order is red, green, blue",
        undo: |frame| rechanneled(frame, bgr),
    },
    Transform {
        words: "sent with the channels of each texel in reverse",
        undo: |frame| rechanneled(frame, |channel, channels| channels - 1 - channel),
    },
    Transform {
        words: "sent plane after plane: the channels of a texel stand side by side",
        undo: from_planes,
    },
    Transform {
        words: "sent with the high byte of each f32 first: the low byte comes first",
        undo: |frame| match &frame.samples {
            Samples::F32(values) => {
                let swapped = |value: &f32| f32::from_bits(value.to_bits().swap_bytes());
                Some(with(
                    frame,
                    Samples::F32(values.iter().map(swapped).collect()),
                ))
            }
            Samples::U8(_) => None,
        },
    },
];

/// What all pictures of the first files have in common in a view, in a sentence, where none of them is right and one
/// change explains all.
#[must_use]
pub fn common(suite: &Suite, run: &Run) -> Vec<String> {
    let of_view = |view: &&'static str| {
        let pictures: Vec<(Expected, &Frame)> = run
            .first
            .iter()
            .filter(|first| first.view.name() == *view)
            .filter_map(|first| {
                let Answer::Decoded(frame) = &first.reply.answer else {
                    return None;
                };
                let built = suite.cases[first.case].build(run.table);
                Some((Expected::of(&built.values, &first.view)?, frame))
            })
            .collect();
        in_common(&pictures).map(|words| format!("all first files in {view} are {words}"))
    };
    ["raw", "coef", "rgb"].iter().filter_map(of_view).collect()
}

fn in_common(pictures: &[(Expected, &Frame)]) -> Option<String> {
    // One picture may be like a mistake by chance; some are the same either way.
    let wrong = pictures
        .iter()
        .filter(|(expected, frame)| expected.compare(frame).is_some());
    if wrong.count() < 2 {
        return None;
    }
    let explains = |transform: &&Transform| {
        pictures.iter().all(|(expected, frame)| {
            (transform.undo)(frame).is_some_and(|frame| expected.compare(&frame).is_none())
        })
    };
    let found = TRANSFORMS
        .iter()
        .find(explains)
        .map(|found| found.words.to_owned());
    found.or_else(|| scaled(pictures))
}

/// A factor between what was received and what was expected, everywhere the same.
fn scaled(pictures: &[(Expected, &Frame)]) -> Option<String> {
    let mut pairs = Vec::new();
    for (expected, frame) in pictures {
        let shape = (
            expected.size.width,
            expected.size.height,
            expected.channels as u32,
        );
        if shape != (frame.width, frame.height, frame.channels) {
            return None;
        }
        let values: Vec<f64> = match &expected.values {
            ExpectedValues::Raw(values) => values.iter().copied().map(f64::from).collect(),
            ExpectedValues::Coef(values) | ExpectedValues::Rgb(values) => values.clone(),
        };
        let received: Vec<f64> = match &frame.samples {
            Samples::U8(bytes) => bytes.iter().copied().map(f64::from).collect(),
            Samples::F32(values) => values.iter().copied().map(f64::from).collect(),
        };
        pairs.extend(values.into_iter().zip(received));
    }
    let is_real = matches!(pictures[0].1.samples, Samples::F32(_));
    // Of bytes that are as large as they get the factor cannot be told.
    let told = pairs
        .iter()
        .filter(|&&(_, received)| is_real || received > 0.0 && received < 255.0);
    let (sum, square) = told.fold((0.0, 0.0), |(sum, square), (a, b)| {
        (sum + a * b, square + a * a)
    });
    let factor = sum / square;
    if !factor.is_finite() || factor <= 0.0 || (factor - 1.0).abs() < 0.02 {
        return None;
    }
    let near = |&(expected, received): &(f64, f64)| {
        let scaled = expected * factor;
        match is_real {
            true => (scaled - received).abs() <= 1e-4 * scaled.abs().max(received.abs()) + 1e-6,
            false => (scaled.clamp(0.0, 255.0) - received).abs() <= 1.5,
        }
    };
    pairs.iter().all(near).then(|| {
        let (by, times) = if factor < 1.0 {
            ("divided", 1.0 / factor)
        } else {
            ("multiplied", factor)
        };
        format!("{by} by about {times:.3}: values are sent from 0 to 255")
    })
}

fn with(frame: &Frame, samples: Samples) -> Frame {
    Frame {
        samples,
        ..frame.clone()
    }
}

/// A frame of another size whose texel (x, y) is the texel `from(x, y)` of this one.
fn rearranged(
    frame: &Frame,
    size: (u32, u32),
    from: impl Fn(usize, usize) -> (usize, usize),
) -> Option<Frame> {
    let channels = frame.channels as usize;
    let places = (0..size.1 as usize).flat_map(|y| (0..size.0 as usize).map(move |x| (x, y)));
    let places = places.map(|(x, y)| from(x, y)).flat_map(|(x, y)| {
        let first = (y * frame.width as usize + x) * channels;
        first..first + channels
    });
    let moved = taken(frame, &places.collect::<Vec<_>>());
    Some(Frame {
        width: size.0,
        height: size.1,
        ..moved
    })
}

fn rechanneled(frame: &Frame, from: fn(usize, usize) -> usize) -> Option<Frame> {
    let channels = frame.channels as usize;
    let places = (0..frame.samples.len()).map(|i| i - i % channels + from(i % channels, channels));
    Some(taken(frame, &places.collect::<Vec<_>>()))
}

/// Where a channel stands if blue comes first: among 3, among the three polynomials of 18, among the colors of 9.
fn bgr(channel: usize, channels: usize) -> usize {
    match channels {
        3 => 2 - channel,
        18 => (2 - channel / 6) * 6 + channel % 6,
        9 if channel > 5 => 14 - channel,
        _ => channel,
    }
}

fn from_planes(frame: &Frame) -> Option<Frame> {
    let channels = frame.channels as usize;
    let texels = frame.samples.len() / channels;
    let places = (0..frame.samples.len()).map(|i| i % channels * texels + i / channels);
    Some(taken(frame, &places.collect::<Vec<_>>()))
}

fn taken(frame: &Frame, places: &[usize]) -> Frame {
    let samples = match &frame.samples {
        Samples::U8(bytes) => Samples::U8(places.iter().map(|&place| bytes[place]).collect()),
        Samples::F32(values) => Samples::F32(places.iter().map(|&place| values[place]).collect()),
    };
    with(frame, samples)
}
