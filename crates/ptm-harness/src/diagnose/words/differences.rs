//! Describes wrong images with an unknown cause: the step at which values first differ, the channels and files, and one example.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::ops::Range;

use super::arithmetic::format_arithmetic;
use super::files_of_group;
use crate::diagnose::diagnosis::{Category, CauseText, Diagnosis};
use crate::diagnose::groups::Group;
use crate::diagnose::image_pair::{ImagePair, image_pair};
use crate::diagnose::mistake::{COLORS, ChannelSubset};
use crate::diagnose::place::{Step, are_differences_of, is_rearranged, wrong_channels};
use crate::diagnose::search::{MistakeId, MistakeSet, Search, without_id};
use crate::diagnose::tuning::{MIN_READ_FILES, MIN_SHARING_FILES, MIN_SUPPORT, is_nearly_all};
use crate::diagnose::witness::Witness;
use ptm::channel_name;
use ptm_suite::compare::format_distinct;
use ptm_suite::origin;
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};

/// Maximum number of channels that are listed by name.
const MAX_LISTED: usize = 3;
/// Minimum number of channels with the values of other channels that are too many to be listed.
const MAX_MOVED: usize = 7;

/// Returns the behavior of a decoder whose images first differ in this step, as a sentence without a subject, and advice on how to
/// fix it.
const fn effect_and_fix(step: Step) -> [&'static str; 2] {
    match step {
        Step::Size => [
            "shows an image of a different size",
            "compare width and height with the header of the file",
        ],
        Step::Channels => [
            "shows an image with a different number of channels",
            "compare the number of channels with the expected frame",
        ],
        Step::SampleType => [
            "shows an image with a different sample type",
            "compare the sample type with the expected frame",
        ],
        Step::Choice => [
            "mixes listed readings of an open question: these images follow another one than images of other files",
            "follow one listed reading of the question in all files",
        ],
        Step::NoReading => [
            "shows an image that is wrong under every reading of the file",
            "show the image that follows one of the readings, or exit with 65",
        ],
        Step::Rearranged => [
            "shows the correct values in the wrong places",
            "compare the order of rows, columns, blocks and channels with the clause",
        ],
        Step::Stream => [
            "shows wrong values in planes that are neither predicted nor corrected",
            "decode the stream in the example with another JPEG or JPEG-LS decoder; if the samples are equal, the mistake is in a later step",
        ],
        Step::Prediction => [
            "shows wrong values in predicted planes",
            "compute the sample in the example by hand from the residual and the reference",
        ],
        Step::Correction => [
            "shows wrong values at texels that side information corrects, and in planes predicted from them",
            "read the record in the example by hand, and check the bytes, the position and the value",
        ],
        Step::CorrectedPlane => [
            "shows wrong values in planes with side information, and in planes predicted from them",
            "read the records of the plane in the example by hand, and check the bytes, the position and the value of each",
        ],
        Step::StoredValue => [
            "shows wrong stored values",
            "compare the bytes that the example names with the values that the decoder reads there",
        ],
        Step::FinalValue => ["shows wrong final values", "compute the example by hand"],
        Step::Color => [
            "shows wrong colors",
            "compute the example by hand: final values first, then the polynomial, then the color",
        ],
    }
}

/// Returns the clause that defines the values of a step, if the step is one that not all files have.
const fn step_clause(step: Step) -> Option<&'static str> {
    match step {
        Step::Prediction => Some("2.9.5/4"),
        Step::Correction | Step::CorrectedPlane => Some("2.9.8/8"),
        _ => None,
    }
}

/// Describes a group of wrong images. `set` contains the mistakes that were found, and `named` those of them that are named.
pub(in crate::diagnose) fn describe(
    search: &Search,
    [set, named]: [&MistakeSet; 2],
    step: Step,
    group: &Group,
) -> Diagnosis {
    let (witnesses, cases) = (search.witnesses, &group.cases[..]);
    let mut wrong = wrong_channels(search, set, cases);
    wrong.retain(|_| cases.len() >= MIN_SHARING_FILES);
    let [effect, fix] = match step {
        Step::FinalValue if are_only_final_values_wrong(search, cases) => [
            "shows wrong final values, although all colors under a light in the formats of these files are correct",
            "compare the code that computes and writes the values of view coef with the code that computes colors; docs/protocol.md describes the bytes",
        ],
        Step::Stream => [wrong_planes(search, cases), effect_and_fix(step)[1]],
        Step::Rearranged if !are_rearranged(search, cases) => {
            let is_coded = |&w: &usize| witnesses[w].case.format().coding().is_some();
            match cases.iter().all(is_coded) {
                true if are_differences_of(search, &[], step, cases) => [
                    "shows the correct values in the wrong places, in planes that are neither predicted nor corrected",
                    effect_and_fix(step)[1],
                ],
                true => [wrong_planes(search, cases), effect_and_fix(Step::Stream)[1]],
                false => effect_and_fix(Step::StoredValue),
            }
        }
        _ => effect_and_fix(step),
    };
    let effect = format!("{effect}{}", elsewhere(search, named, step, cases));
    let [_, swap_fix] = effect_and_fix(Step::Rearranged);
    let swapped = swapped_channels(search, cases, &wrong);
    let (effect, fix) = match (swapped, exchanged_axes(search, step, cases)) {
        (Some([first, second]), _) => (format!("swaps {first} and {second}"), swap_fix),
        (None, Some(axes)) => (
            format!(
                "exchanges the axes of images: ({axes}) instead of ({})",
                AXES.join(", ")
            ),
            "order the samples by row, then by column, then by channel, and state the size in that order",
        ),
        (None, None) => (
            format!(
                "{effect}{}{}{}{}{}{}",
                shape_text(search, step, cases),
                value_text(search, cases),
                source_text(search, cases),
                channel_text(search, cases, &wrong),
                common_channel_text(search, set, cases),
                texel_text(search, cases)
            ),
            fix,
        ),
    };
    let (files, views) = (
        files_of_group(witnesses, group),
        views_phrase(witnesses, cases),
    );
    let text = CauseText {
        effect: format!("{effect}, in {files}{views}"),
        fix: fix.to_owned(),
        example: example(search, set, cases[0]),
    };
    let clause = group.clause().or(step_clause(step));
    Diagnosis::from_description(Category::Difference, witnesses, cases, text, clause)
}

/// Returns true if each of these images in the first of their views has the correct samples in another order. Predicted planes have
/// other samples if their reference is moved.
fn are_rearranged(search: &Search, cases: &[usize]) -> bool {
    let pairs = cases.iter().filter_map(|&w| image_pair(search, &[], w));
    let pairs: Vec<ImagePair> = pairs.collect();
    let first = pairs.iter().map(|pair| pair.view).min();
    let mut of_view = pairs.iter().filter(|pair| Some(pair.view) == first);
    of_view.all(is_rearranged)
}

/// The axes of an array of samples.
const AXES: [&str; 3] = ["height", "width", "channels"];

/// Returns the axes of the received arrays, such as "channels, height, width", if all have the sizes of the expected ones in this
/// order.
fn exchanged_axes(search: &Search, step: Step, cases: &[usize]) -> Option<String> {
    // The images of other steps have the expected sizes.
    if !matches!(step, Step::Size | Step::Channels) {
        return None;
    }
    let sizes = |frame: &Frame| [frame.height, frame.width, frame.channels];
    let shapes = cases.iter().map(|&w| {
        let received = search.witnesses[w].wrong_image()?;
        match &*search.best_answer(w, &[]) {
            Answer::Decoded(expected) => Some((sizes(received), sizes(expected))),
            _ => None,
        }
    });
    let shapes: Vec<_> = shapes.collect::<Option<_>>()?;
    let orders = [[1, 0, 2], [2, 0, 1], [2, 1, 0], [0, 2, 1], [1, 2, 0]];
    let is_order = |order: &[usize; 3]| {
        let mut shapes = shapes.iter();
        shapes.all(|(received, expected)| *received == order.map(|axis| expected[axis]))
    };
    let is_exchanged = shapes
        .iter()
        .any(|(received, expected)| received != expected);
    let order = orders.into_iter().find(is_order)?;
    (is_exchanged && shapes.len() >= MIN_SUPPORT).then(|| order.map(|axis| AXES[axis]).join(", "))
}

/// Sizes that a decoder may confuse with the width or the height: a name, and the value in terms of both.
const SIZES: [(&str, fn([u32; 2]) -> Option<u32>); 9] = [
    ("width", |[width, _]| Some(width)),
    ("height", |[_, height]| Some(height)),
    ("(width + 1)", |[width, _]| width.checked_add(1)),
    ("(width - 1)", |[width, _]| width.checked_sub(1)),
    ("(height + 1)", |[_, height]| height.checked_add(1)),
    ("(height - 1)", |[_, height]| height.checked_sub(1)),
    ("width * height", |[width, height]| {
        width.checked_mul(height)
    }),
    ("(width + height)", |[width, height]| {
        width.checked_add(height)
    }),
    ("1", |_| Some(1)),
];

/// Returns text such as ": 4 channels instead of 3 channels" if all images of a group have the same wrong shape, or ": height × height
/// instead of width × height" if all sizes follow from the expected ones in the same way.
fn shape_text(search: &Search, step: Step, cases: &[usize]) -> String {
    let frames = cases.iter().filter_map(|&w| {
        let received = search.witnesses[w].wrong_image()?;
        match &*search.best_answer(w, &[]) {
            Answer::Decoded(expected) => Some((received, expected.clone())),
            _ => None,
        }
    });
    let frames: Vec<(&Frame, Frame)> = frames.collect();
    let value = |frame: &Frame| match step {
        Step::Size => Some(format!("{} × {}", frame.width, frame.height)),
        Step::Channels => Some(format!("{} channels", frame.channels)),
        Step::SampleType => Some(frame.samples.sample_type().to_owned()),
        _ => None,
    };
    let shapes = frames
        .iter()
        .filter_map(|(received, expected)| value(received).zip(value(expected)));
    let shapes: BTreeSet<(String, String)> = shapes
        .filter(|(received, expected)| received != expected)
        .collect();
    if let (Some((received, expected)), 1) = (shapes.first(), shapes.len()) {
        return format!(": {received} instead of {expected}");
    }
    let size_of = |side: fn(&Frame) -> u32| {
        let mut sizes = SIZES.iter();
        sizes.find(|(_, size)| {
            let mut frames = frames.iter();
            frames.all(|(received, expected)| {
                size([expected.width, expected.height]) == Some(side(received))
            })
        })
    };
    let sides = size_of(|frame| frame.width).zip(size_of(|frame| frame.height));
    match sides {
        Some(((width, _), (height, _))) if step == Step::Size && shapes.len() >= MIN_SUPPORT => {
            format!(": {width} × {height} instead of width × height")
        }
        _ => String::new(),
    }
}

/// Returns the most precise statement about the wrong planes of images that differ in a stream, and that holds for all of them.
fn wrong_planes(search: &Search, cases: &[usize]) -> &'static str {
    let (mut are_plain, mut are_unpredicted) = (true, true);
    for &w in cases {
        let witness = &search.witnesses[w];
        let coded = witness.model().and_then(|model| model.compressed.as_ref());
        let pair = image_pair(search, &[], w).filter(|pair| pair.view != ViewKind::Rgb);
        let Some((coded, pair)) = coded.zip(pair) else {
            continue;
        };
        let wrong = pair.wrong_channels();
        let wrong = || (0..wrong.len()).filter(|&plane| wrong[plane]);
        are_plain &= wrong().any(|plane| witness.is_plain_plane(plane));
        are_unpredicted &= wrong().any(|plane| coded.plan.reference(plane).is_none());
    }
    match (are_plain, are_unpredicted) {
        (true, _) => effect_and_fix(Step::Stream)[0],
        (false, true) => "shows wrong values in planes that are not predicted",
        _ => "shows wrong values in planes, predicted or not",
    }
}

/// Returns what is known about the values outside the planes and texels in which images of compressed files first differ, such as
/// ", and nowhere else".
fn elsewhere(search: &Search, named: &[MistakeId], step: Step, cases: &[usize]) -> &'static str {
    let are_there = |set: &[MistakeId]| are_differences_of(search, set, step, cases);
    match step {
        Step::Prediction | Step::Correction | Step::CorrectedPlane => {
            if are_there(&[]) {
                ", and nowhere else"
            } else if are_there(named) {
                ", and, apart from what named mistakes explain, nowhere else"
            } else {
                ""
            }
        }
        _ => "",
    }
}

/// Returns true if all colors of legal files of these formats are correct, and nearly all images of final values are wrong.
fn are_only_final_values_wrong(search: &Search, cases: &[usize]) -> bool {
    let format = |w: usize| search.witnesses[w].case.format();
    let of_view = |view: ViewKind| {
        let all = search.witnesses.iter().filter(move |witness| {
            witness.observation.view.kind() == view && witness.is_image_of_legal_file()
        });
        all.filter(|witness| cases.iter().any(|&w| format(w) == witness.case.format()))
    };
    let [wrong, right] = [true, false].map(|failed| {
        [ViewKind::Coef, ViewKind::Rgb]
            .map(|view| of_view(view).filter(|w| w.failed == failed).count())
    });
    wrong[1] == 0 && right[1] >= MIN_READ_FILES && is_nearly_all(wrong[0], wrong[0] + right[0])
}

/// Returns text such as ": every wrong sample is NaN", or ": every wrong sample is 127 instead of 255", if all wrong samples of the
/// images, or of those in the earliest view, have the same value.
fn value_text(search: &Search, cases: &[usize]) -> String {
    let view = |w: &usize| search.witnesses[*w].observation.view.kind();
    let Some(first) = cases.iter().map(view).min() else {
        return String::new();
    };
    let of_view = match cases.iter().all(|w| view(w) == first) {
        true => String::new(),
        false => format!(" in view {first}"),
    };
    let cases = cases.iter().filter(|w| view(w) == first);
    // Received and expected values, with one representation of NaN.
    let bits = |value: f64| if value.is_nan() { f64::NAN } else { value }.to_bits();
    let (mut values, mut expected, mut count) = (BTreeSet::new(), BTreeSet::new(), 0);
    for &w in cases {
        let Some(pair) = image_pair(search, &[], w) else {
            return String::new();
        };
        for i in pair.wrong_samples() {
            values.insert(bits(pair.received[i]));
            let is_color = pair.view == ViewKind::Rgb;
            let right = pair.expected[i];
            expected.insert(bits(if is_color {
                right.clamp(0.0, 255.0).round()
            } else {
                right
            }));
            count += 1;
        }
        if values.len() > 1 {
            return String::new();
        }
    }
    let only = |values: &BTreeSet<u64>| match values.len() {
        1 => values.first().map(|&bits| f64::from_bits(bits)),
        _ => None,
    };
    let Some(value) = only(&values).filter(|_| count >= MIN_SUPPORT) else {
        return String::new();
    };
    match only(&expected) {
        Some(expected) => {
            format!(": every wrong sample{of_view} is {value} instead of {expected}")
        }
        None => format!(": every wrong sample{of_view} is {value}"),
    }
}

/// Returns text such as " (12 in view raw, 10 in view coef)" if the images belong to several views.
fn views_phrase(witnesses: &[Witness], indices: &[usize]) -> String {
    let count = |view: &ViewKind| {
        let has_view = |w: &&usize| witnesses[**w].observation.view.kind() == *view;
        indices.iter().filter(has_view).count()
    };
    let views = ViewKind::ALL.iter().filter(|view| count(view) > 0);
    let counts: Vec<String> = views
        .map(|view| format!("{} in view {view}", count(view)))
        .collect();
    match counts.len() {
        0 | 1 => String::new(),
        _ => format!(" ({})", counts.join(", ")),
    }
}

/// Returns the names of the two wrong channels if swapping them corrects all images.
fn swapped_channels(search: &Search, indices: &[usize], wrong: &[bool]) -> Option<[String; 2]> {
    let channels: Vec<usize> = (0..wrong.len()).filter(|&channel| wrong[channel]).collect();
    let [first, second] = channels[..] else {
        return None;
    };
    let is_swapped = |&w: &usize| {
        let pair = image_pair(search, &[], w).filter(|pair| pair.channels == wrong.len());
        pair.is_some_and(|mut pair| {
            let texels = pair.expected.chunks_exact_mut(pair.channels);
            texels.for_each(|texel| texel.swap(first, second));
            pair.wrong_samples().is_empty()
        })
    };
    let name = |channel| channel_name(wrong.len(), channel);
    let are_swapped = indices.iter().all(is_swapped);
    are_swapped.then(|| [name(first), name(second)])
}

/// Returns text such as ": G has the values of R, B those of G" if wrong channels have the values of other channels in all images of
/// stored values.
fn source_text(search: &Search, cases: &[usize]) -> String {
    let pairs = cases.iter().filter_map(|&w| image_pair(search, &[], w));
    let pairs: Vec<ImagePair> = pairs.filter(|pair| pair.view == ViewKind::Raw).collect();
    if pairs.len() < MIN_SUPPORT {
        return String::new();
    }
    for (step, end, which) in [(1, "last", "next"), (-1, "first", "previous")] {
        let is_moved = |pair: &ImagePair| {
            let mut all = 0..pair.channels;
            all.all(|channel| match channel.checked_add_signed(step) {
                Some(source) if source < pair.channels => pair.has_values_of(channel, source),
                _ => true,
            })
        };
        if pairs.iter().all(is_moved) {
            return format!(": every channel but the {end} has the values of the {which} one");
        }
    }
    let channels = pairs[0].channels;
    if pairs.iter().any(|pair| pair.channels != channels) {
        return String::new();
    }
    let only_source = |channel: usize| {
        let is_source = |&source: &usize| {
            let mut pairs = pairs.iter();
            pairs.all(|pair| pair.has_values_of(channel, source))
        };
        let sources: Vec<usize> = (0..channels).filter(is_source).collect();
        match sources[..] {
            [source] if source != channel => Some((channel, source)),
            _ => None,
        }
    };
    let moved: Vec<(usize, usize)> = (0..channels).filter_map(only_source).collect();
    let verbs = ["has the values of"]
        .into_iter()
        .chain(std::iter::repeat("those of"));
    // The colors of RGB move as a whole.
    let is_of_color = |six: &[(usize, usize)]| {
        let (first, source) = six[0];
        let is_whole = six.len() == 6 && first % 6 == 0 && source % 6 == 0;
        let mut six = six.iter().enumerate();
        is_whole && six.all(|(i, pair)| *pair == (first + i, source + i))
    };
    let (moved, channels) = match channels == 18 && moved.chunks(6).all(is_of_color) {
        true => {
            let colors = moved.iter().step_by(6);
            (
                colors
                    .map(|&(channel, source)| (channel / 6, source / 6))
                    .collect(),
                3,
            )
        }
        false => (moved, channels),
    };
    let parts = moved.iter().zip(verbs).map(|(&(channel, source), verb)| {
        let [channel, source] = [channel, source].map(|one| channel_name(channels, one));
        format!("{channel} {verb} {source}")
    });
    match moved.len() {
        0 | MAX_MOVED.. => String::new(),
        _ => format!(": {}", parts.collect::<Vec<_>>().join(", ")),
    }
}

/// Returns text such as ", only in a3" if all other channels are correct. Mistakes that were found may affect other channels; then
/// the text would be ambiguous, and it is empty.
fn channel_text(search: &Search, cases: &[usize], wrong: &[bool]) -> String {
    if wrong_channels(search, &[], cases) != wrong {
        return String::new();
    }
    let names: Vec<String> = (0..wrong.len())
        .filter(|&channel| wrong[channel])
        .map(|channel| channel_name(wrong.len(), channel))
        .collect();
    match names.len() {
        0 => String::new(),
        1..=MAX_LISTED if names.len() < wrong.len() => format!(", only in {}", names.join(", ")),
        _ => match ChannelSubset::smallest_containing(wrong) {
            ChannelSubset::All if wrong.len() == 18 => {
                let has_wrong = |c: &usize| wrong[6 * c..6 * (c + 1)].contains(&true);
                let colors: Vec<&str> = (0..3).filter(has_wrong).map(|c| COLORS[c]).collect();
                match colors.len() {
                    3 => String::new(),
                    _ => format!(", only in {}", colors.join(", ")),
                }
            }
            subset => subset.describe(),
        },
    }
}

/// Returns text such as ", only in the first channel after a5" for images of 8 and of 9 channels. Only a0 to a5 have the same names in
/// both. As in [`channel_text`], the text is empty if mistakes that were found may affect other channels.
fn common_channel_text(search: &Search, set: &[MistakeId], cases: &[usize]) -> String {
    let with_channels = |count: usize| -> Vec<usize> {
        let has_count = |w: &usize| {
            let format = search.witnesses[*w].case.format();
            format.shape().channels() == count
        };
        cases.iter().copied().filter(has_count).collect()
    };
    let parts = [8, 9].map(with_channels);
    let wrong = |set: &[MistakeId]| {
        parts
            .each_ref()
            .map(|part| wrong_channels(search, set, part))
    };
    let by_count = wrong(&[]);
    let are_whole = by_count.each_ref().map(Vec::len) == [8, 9];
    let are_all = parts.iter().map(Vec::len).sum::<usize>() == cases.len();
    if cases.len() < MIN_SHARING_FILES || !are_whole || !are_all || wrong(set) != by_count {
        return String::new();
    }
    let is_wrong = |channel: usize| {
        by_count
            .iter()
            .any(|wrong| wrong.get(channel) == Some(&true))
    };
    let flags: Vec<bool> = (0..9).map(is_wrong).collect();
    match flags.iter().rposition(|&wrong| wrong) {
        Some(6) if !flags[..6].contains(&true) => ", only in the first channel after a5".to_owned(),
        _ => ChannelSubset::smallest_containing(&flags).describe(),
    }
}

/// A place in an image: its name, and the condition that a texel at (x, y) of a w × h image is there.
type Place = (&'static str, fn([usize; 4]) -> bool);

/// Places where a loop may begin or end too early or too late.
const PLACES: [Place; 6] = [
    ("in the first stored texel", |[x, y, _, h]| {
        x == 0 && y == h - 1
    }),
    ("in the last stored texel", |[x, y, w, _]| {
        x == w - 1 && y == 0
    }),
    ("in the bottom row", |[_, y, _, h]| y == h - 1),
    ("in the top row", |[_, y, _, _]| y == 0),
    ("in the left column", |[x, ..]| x == 0),
    ("in the right column", |[x, _, w, _]| x == w - 1),
];

/// Returns text such as ", only in the bottom row" if all wrong values are there, in at least some images with other texels.
fn texel_text(search: &Search, cases: &[usize]) -> String {
    let (mut places, mut large_images) = (PLACES.to_vec(), 0);
    for &w in cases {
        let Some(pair) = image_pair(search, &[], w) else {
            return String::new();
        };
        for texel in pair.wrong_samples().into_iter().map(|i| i / pair.channels) {
            let (x, y) = (texel % pair.width, texel / pair.width);
            places.retain(|place| place.1([x, y, pair.width, pair.height]));
        }
        // Most images show at once that all places are excluded.
        if places.is_empty() {
            return String::new();
        }
        large_images += usize::from(pair.width > 1 && pair.height > 1);
    }
    match places.first() {
        Some((name, _)) if large_images >= MIN_SUPPORT => format!(", only {name}"),
        _ => String::new(),
    }
}

/// Describes the first wrong sample in a file that the mistakes in `set` do not explain: its received and expected values, the
/// arithmetic, and the bytes that determine the expected value.
fn example(search: &Search, set: &[MistakeId], w: usize) -> String {
    let pair = (!set.is_empty()).then(|| image_pair(search, set, w));
    let open = pair.flatten().map(|pair| pair.wrong_samples());
    describe_sample(search, w, &open.unwrap_or_default(), None)
}

/// Describes the first wrong sample in a file that a mistake changes. If the mistake is found in the reference's reading only, so are the
/// expected values.
pub(in crate::diagnose) fn example_of_mistake(
    search: &Search,
    set: &MistakeSet,
    id: MistakeId,
    w: usize,
) -> String {
    let witness = &search.witnesses[w];
    let other = |set: &[MistakeId]| witness.answer_in_other_reading(&search.mistakes_in(set));
    let others = without_id(set, id);
    let with = search.best_answer(w, set);
    let is_other_reading =
        other(set).as_ref() == Some(&*with) && *witness.answer(&search.mistakes_in(set)) != *with;
    let (without, right) = match is_other_reading {
        true => (other(&others).map(Cow::Owned), other(&[])),
        false => (Some(search.best_answer(w, &others)), None),
    };
    let changed: Vec<usize> = match (&*with, without.as_deref()) {
        (Answer::Decoded(with), Some(Answer::Decoded(without))) => {
            let samples = 0..with.samples.len().min(without.samples.len());
            let differs = |&i: &usize| with.samples.real(i) != without.samples.real(i);
            samples.filter(differs).collect()
        }
        _ => Vec::new(),
    };
    describe_sample(search, w, &changed, right.as_ref())
}

/// Describes the first wrong sample, one of `preferred` if possible. The expected values are those of the file, without mistakes: in the
/// decoder's dialect or, if it is given, in the answer `right`.
fn describe_sample(
    search: &Search,
    w: usize,
    preferred: &[usize],
    right: Option<&Answer>,
) -> String {
    let witness = &search.witnesses[w];
    let id = &witness.case.id;
    let pair = match right {
        Some(Answer::Decoded(right)) => {
            let received = witness.wrong_image();
            received.and_then(|received| ImagePair::new(witness, right, received))
        }
        _ => image_pair(search, &[], w),
    };
    let first = pair.and_then(|pair| {
        let first = first_wrong(&pair, witness, preferred)?;
        Some((pair, first))
    });
    let Some((pair, i)) = first else {
        return format!("for example {id}: {}", witness.case.because);
    };
    let (texel, channel) = (i / pair.channels, i % pair.channels);
    let (x, y) = (texel % pair.width, texel / pair.width);
    let [received, expected] = format_distinct(pair.received[i], pair.expected[i], 4);
    let mut text = format!(
        "for example {id}, texel ({x}, {y}), {}: received {received}, expected {expected}",
        channel_name(pair.channels, channel),
    );
    let own_readings = witness.own_readings.iter().filter(|_| right.is_none());
    text.extend(own_readings.map(|readings| format!(" {readings}")));
    let is_limited =
        pair.view == ViewKind::Rgb && (pair.expected[i] <= 0.0 || pair.expected[i] >= 255.0);
    let limited = is_limited.then_some(", limited to 0…255");
    let limited = limited.unwrap_or_default();
    let steps = format_arithmetic(witness, texel, channel).filter(|_| right.is_none());
    text.extend(steps.map(|steps| format!(" = {steps}{limited}")));
    if pair.view != ViewKind::Rgb
        && let Ok(ptm) = witness.decoded()
    {
        let (format, size, file) = (witness.case.format(), ptm.planes.size, &witness.built.file);
        let origins = origin::origin_of_samples(format, file, size, (x, y), channel..channel + 1);
        for (name, _, Range { start, end }) in origins {
            let bytes = match end - start {
                1 => format!("byte {start} (0x{start:x})"),
                _ => format!("bytes {start}–{}", end - 1),
            };
            let _ = write!(text, "; the expected value comes from {bytes}, {name}");
        }
    }
    text
}

/// Returns the first wrong sample. In a compressed file, this is the first wrong sample, in stored order, of the first wrong
/// plane that is not predicted from another wrong plane.
fn first_wrong(pair: &ImagePair, witness: &Witness, open: &[usize]) -> Option<usize> {
    let mut wrong = pair.wrong_samples();
    let is_open = |i: &usize| open.binary_search(i).is_ok();
    if wrong.iter().any(is_open) {
        wrong.retain(is_open);
    }
    let coded = witness.model().and_then(|model| model.compressed.as_ref());
    let Some(coded) = coded.filter(|_| pair.view != ViewKind::Rgb) else {
        return wrong.first().copied();
    };
    let channels = pair.wrong_channels();
    let is_root = |i: &usize| {
        let reference = coded.plan.reference(i % pair.channels);
        reference.is_none_or(|reference| !channels[reference])
    };
    let stored = |&i: &usize| {
        let (texel, plane) = (i / pair.channels, i % pair.channels);
        (
            !is_root(&i),
            plane,
            pair.height - 1 - texel / pair.width,
            texel % pair.width,
        )
    };
    wrong.into_iter().min_by_key(stored)
}
