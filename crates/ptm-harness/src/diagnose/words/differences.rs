//! Describes wrong images with an unknown cause: the step at which values first differ, the channels and files, and one example.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;
use std::ops::Range;

use super::arithmetic::format_arithmetic;
use super::{files_in_scope, share_text};
use crate::diagnose::diagnosis::{Category, CauseText, Diagnosis};
use crate::diagnose::scope::{FileScope, SharedScope, format_sets, shared_scope};
use crate::diagnose::search::{MistakeId, MistakeSet, Search, without_id};
use crate::diagnose::tuning::{MIN_SHARING_FILES, MIN_SUPPORT, is_few, is_most, is_substantial};
use crate::diagnose::{mistake::ChannelSubset, pair::ImagePair, witness::Witness};
use ptm::{Coding, Format, ScaleBias, channel_name};
use ptm_suite::compare::{Expected, format_distinct};
use ptm_suite::origin;
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};
use ptm_suite::verdicts::observation::Response;

/// Maximum number of channels that are listed by name.
const MAX_LISTED: usize = 3;

/// The step at which the values of an image first differ, as far as a single image reveals it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Phase {
    Size,
    Channels,
    Choice,
    NoReading,
    Rearranged,
    Stream,
    Prediction,
    Correction,
    CorrectedPlane,
    StoredValue,
    FinalValue,
    Color,
}

impl Phase {
    /// Returns the last step that affects the values in a view.
    fn for_view(view: ViewKind) -> Phase {
        match view {
            ViewKind::Raw => Phase::StoredValue,
            ViewKind::Coef => Phase::FinalValue,
            ViewKind::Rgb => Phase::Color,
        }
    }

    /// Returns the behavior of the decoder, as a sentence without a subject, and advice on how to fix it.
    fn effect_and_fix(self) -> [&'static str; 2] {
        match self {
            Phase::Size => [
                "shows an image of a different size",
                "compare width and height with the header of the file",
            ],
            Phase::Channels => [
                "shows an image with a different number of channels or a different sample type",
                "compare the number of channels and the sample type with the expected frame",
            ],
            Phase::Choice => [
                "follows a different reading of an open question than in its other images",
                "follow one reading of the question in all files",
            ],
            Phase::NoReading => [
                "shows an image that is wrong under every reading of the file",
                "show the image that follows one of the readings, or exit with 65",
            ],
            Phase::Rearranged => [
                "shows the correct values in the wrong places",
                "compare the order of rows, columns, blocks and channels with the clause",
            ],
            Phase::Stream => [
                "shows wrong values, as if some samples of a stream were decoded incorrectly",
                "decode the stream in the example with another JPEG or JPEG-LS decoder; if the samples are equal, the mistake is in a later step",
            ],
            Phase::Prediction => [
                "shows wrong values in predicted planes; planes that are not predicted are correct",
                "compute the sample in the example by hand from the residual and the reference",
            ],
            Phase::Correction => [
                "shows wrong values only at texels that side information corrects, and in planes predicted from them",
                "read the record in the example by hand, and check the bytes, the position and the value",
            ],
            Phase::CorrectedPlane => [
                "shows wrong values only in planes with side information, and in planes predicted from them",
                "read the records of the plane in the example by hand, and check the bytes, the position and the value of each",
            ],
            Phase::StoredValue => [
                "shows wrong stored values",
                "compare the bytes that the example names with the values that the decoder reads there",
            ],
            Phase::FinalValue => ["shows wrong final values", "compute the example by hand"],
            Phase::Color => [
                "shows wrong colors",
                "compute the example by hand: final values first, then the polynomial, then the color",
            ],
        }
    }

    /// Returns true if a mistake in this step may explain a wrong image that does not reveal the step itself.
    fn can_explain(self, witness: &Witness) -> bool {
        let coded = witness.model().and_then(|model| model.compressed.as_ref());
        // Final values reveal whether planes are predicted and corrected.
        let coded = coded.filter(|_| witness.is_rgb());
        let is_identity = |pair: &ScaleBias| pair.scale == [1.0; 6] && pair.bias == [0.0; 6];
        match self {
            Phase::Prediction => coded.is_some_and(|coded| coded.plan.predicts()),
            Phase::Correction | Phase::CorrectedPlane => coded
                .is_some_and(|coded| coded.planes.iter().any(|plane| !plane.records.is_empty())),
            Phase::FinalValue => {
                !matches!(witness.decoded(), Ok(ptm) if is_identity(&ptm.header.scale_bias))
            }
            _ => true,
        }
    }

    /// Returns the clause that defines the step for all formats, or `None` if the step depends on the layout of the format.
    fn common_clause(self) -> Option<&'static str> {
        match self {
            Phase::Color => Phase::Color.clause(Format::Rgb),
            Phase::Channels => Some("2.2/1"),
            _ => None,
        }
    }

    fn clause(self, format: Format) -> Option<&'static str> {
        Some(match (self, format) {
            (Phase::Size, _) => "2.3/1",
            (Phase::Channels | Phase::Rearranged | Phase::StoredValue, format) => {
                format.layout_clause()
            }
            (Phase::Stream, _) => "2.9.8/3",
            (Phase::Prediction, _) => "2.9.5/4",
            (Phase::Correction | Phase::CorrectedPlane, _) => "2.9.8/8",
            (Phase::FinalValue, _) => "2.4/8",
            (Phase::Color, Format::Lum) => "2.6/4",
            (Phase::Color, format) if format.channels() == 9 => "2.7.3/4",
            (Phase::Color, _) => "1.0/1",
            _ => return None,
        })
    }
}

/// Describes the wrong images in `left`, grouped by the step at which they first differ. `set` contains the mistakes found.
pub fn describe(search: &Search, set: &MistakeSet, left: &[usize]) -> Vec<Diagnosis> {
    let steps = search.par_map(left, |&w| first_difference(search, set, w, true));
    let format = |w: usize| search.witnesses[w].case.format();
    let mut step_of: HashMap<usize, Phase> = left.iter().copied().zip(steps).collect();
    drop_chance_permutations(search, set, &mut step_of);
    follow_raw_images(search.witnesses, &mut step_of);
    follow_streams(search.witnesses, &mut step_of);
    follow_earlier_steps(search, set, &mut step_of);
    let mut by_step: BTreeMap<Phase, Vec<usize>> = BTreeMap::new();
    for w in left {
        by_step.entry(step_of[w]).or_default().push(*w);
    }
    // A correct or explained image of a file with a property contradicts it. A file without an image is no evidence.
    let is_known = |w: &usize| {
        let witness = &search.witnesses[*w];
        witness.is_image_of_legal_file()
            && (!witness.failed || search.agreement(*w, set).explains())
    };
    let known: Vec<usize> = (0..search.witnesses.len()).filter(is_known).collect();
    let mut diagnoses = Vec::new();
    for (step, mut indices) in by_step {
        let mut parts = take_scopes(search, &known, &mut indices, &[Format::ALL.to_vec()]);
        let mut by_clause: BTreeMap<Option<&str>, Vec<usize>> = BTreeMap::new();
        for &w in &indices {
            let clause = step.common_clause().or(step.clause(format(w)));
            by_clause.entry(clause).or_default().push(w);
        }
        for mut indices in by_clause.into_values() {
            let formats = format_sets(search.witnesses, &indices);
            parts.extend(take_scopes(search, &known, &mut indices, &formats[1..]));
            if !indices.is_empty() {
                let files = share_text(search.witnesses, &indices);
                parts.push(CauseGroup {
                    cases: indices,
                    files,
                    clause: None,
                });
            }
        }
        let described = parts
            .iter()
            .map(|part| difference_text(search, set, step, part));
        diagnoses.extend(described);
    }
    diagnoses
}

/// Attributes wrong final values to scale and bias if all raw images of the format are correct.
fn follow_raw_images(witnesses: &[Witness], steps: &mut HashMap<usize, Phase>) {
    for format in Format::ALL {
        let is_member = |witness: &Witness, view: ViewKind| {
            witness.case.format() == format && witness.observation.view.kind() == view
        };
        let raw = || (witnesses.iter()).filter(|witness| is_member(witness, ViewKind::Raw));
        let right = raw().filter(|witness| witness.is_image_of_legal_file() && !witness.failed);
        if right.count() < MIN_SHARING_FILES || raw().any(|witness| witness.failed) {
            continue;
        }
        for (&w, step) in steps.iter_mut() {
            let is_stored = (Phase::Stream..=Phase::StoredValue).contains(step);
            if is_stored && is_member(&witnesses[w], ViewKind::Coef) {
                *step = Phase::FinalValue;
            }
        }
    }
}

/// Attributes wrong samples to the streams if the streams may explain most images of a coding.
fn follow_streams(witnesses: &[Witness], steps: &mut HashMap<usize, Phase>) {
    let format = |w: usize| witnesses[w].case.format();
    for coding in [Coding::Jpeg, Coding::JpegLs] {
        let mut in_coding: Vec<usize> = steps.keys().copied().collect();
        in_coding.retain(|&w| format(w).coding() == Some(coding));
        let count = |step| in_coding.iter().filter(|w| steps[*w] == step).count();
        let streams = count(Phase::Stream);
        let [predictions, planes] = [Phase::Prediction, Phase::CorrectedPlane].map(count);
        let corrections = planes + count(Phase::Correction);
        let others = streams + count(Phase::Rearranged) + count(Phase::StoredValue);
        let early = match is_substantial(streams, others + predictions + corrections) {
            true => Phase::Stream,
            false => Phase::StoredValue,
        };
        for w in in_coding {
            let is_late = match steps[&w] {
                // A few images may differ only at corrected texels by chance.
                Phase::Correction | Phase::CorrectedPlane => others > corrections,
                // Wrong residuals explain wrong predicted planes if more files have wrong planes that are not predicted.
                Phase::Prediction => others > predictions,
                step => step == Phase::StoredValue,
            };
            if is_late {
                steps.insert(w, early);
            } else if steps[&w] == Phase::Correction && is_substantial(planes, corrections) {
                steps.insert(w, Phase::CorrectedPlane);
            }
        }
    }
    // If files without streams also have wrong values, the mistake is in a step after the streams.
    let is_plain =
        |(&w, step): (&usize, &Phase)| *step == Phase::StoredValue && format(w).coding().is_none();
    if steps.iter().any(is_plain) {
        let streams = steps.values_mut().filter(|step| **step == Phase::Stream);
        streams.for_each(|step| *step = Phase::StoredValue);
    }
}

/// Replaces [`Phase::Rearranged`] with another step unless it applies to most wrong images of a format. A few values, or similar
/// ones, may be permuted by chance.
fn drop_chance_permutations(search: &Search, set: &MistakeSet, steps: &mut HashMap<usize, Phase>) {
    let witnesses = search.witnesses;
    for format in Format::ALL {
        let mut in_format: Vec<usize> = steps.keys().copied().collect();
        in_format
            .retain(|&w| steps[&w] >= Phase::Rearranged && witnesses[w].case.format() == format);
        let all = in_format.len();
        in_format.retain(|w| steps[w] == Phase::Rearranged);
        if !is_most(in_format.len(), all) {
            let plain = |w: usize| match first_difference(search, set, w, false) {
                Phase::Rearranged => (w, Phase::StoredValue),
                step => (w, step),
            };
            steps.extend(in_format.into_iter().map(plain));
        }
    }
}

/// Attributes wrong final values and colors to a step of an earlier view if the earlier view has more than half as many
/// unexplained wrong images as the later view, and at least half its share of wrong images. Images are counted in the same format,
/// or in all formats with wrong images in the earlier view. Images that are described elsewhere also count. The step must be able to
/// explain the image.
fn follow_earlier_steps(search: &Search, set: &MistakeSet, steps: &mut HashMap<usize, Phase>) {
    let witnesses = search.witnesses;
    let mut open = search.unexplained(set);
    open.retain(|w| {
        witnesses[*w].is_image_of_legal_file()
            && steps.get(w).is_none_or(|step| *step >= Phase::Rearranged)
    });
    let mut images: Vec<usize> = (0..witnesses.len()).collect();
    images.retain(|&w| witnesses[w].is_image_of_legal_file());
    let in_view = |all: &[usize], view: ViewKind, formats: &[Format]| -> Vec<usize> {
        let is_member = |w: &usize| {
            let witness = &witnesses[*w];
            witness.observation.view.kind() == view && formats.contains(&witness.case.format())
        };
        all.iter().copied().filter(is_member).collect()
    };
    for format in Format::ALL {
        let views = [
            (ViewKind::Coef, &[ViewKind::Raw][..]),
            (ViewKind::Rgb, &[ViewKind::Raw, ViewKind::Coef]),
        ];
        for (view, earlier) in views {
            let explains = |earlier: &&ViewKind| {
                let is_wrong = |format: &Format| {
                    in_view(&open, **earlier, &[*format]).len() >= MIN_SHARING_FILES
                };
                let formats: Vec<Format> = Format::ALL.into_iter().filter(is_wrong).collect();
                let is_enough = |formats: &[Format]| {
                    let [before, after] =
                        [**earlier, view].map(|view| in_view(&open, view, formats).len());
                    let [all_before, all_after] =
                        [**earlier, view].map(|view| in_view(&images, view, formats).len());
                    is_most(before, after) && 2 * before * all_after >= after * all_before
                };
                formats.contains(&format) && (is_enough(&[format]) || is_enough(&formats))
            };
            let known = |w: &usize| steps.get(w).copied().unwrap_or(Phase::StoredValue);
            let first = earlier.iter().find(explains);
            let first = first.map(|first| in_view(&open, *first, &[format]));
            let before: BTreeSet<Phase> = first.iter().flatten().map(known).collect();
            for (w, step) in steps.iter_mut() {
                let witness = &witnesses[*w];
                let is_member =
                    (witness.case.format(), witness.observation.view.kind()) == (format, view);
                if is_member && *step >= Phase::FinalValue {
                    let last = before.iter().rfind(|before| before.can_explain(witness));
                    *step = last.copied().unwrap_or(*step);
                }
            }
        }
    }
}

/// Wrong images with the same cause, a description of the files, and the clause about their common property.
struct CauseGroup {
    cases: Vec<usize>,
    files: String,
    clause: Option<&'static str>,
}

/// For each set of formats, finds files in `open` with a property that most `open` files and no `known` file have. Removes these
/// files from `open` and returns them in groups.
fn take_scopes(
    search: &Search,
    known: &[usize],
    open: &mut Vec<usize>,
    format_sets: &[Vec<Format>],
) -> Vec<CauseGroup> {
    let witnesses = search.witnesses;
    let format = |w: usize| witnesses[w].case.format();
    // If nearly all failures of these formats are explained, the rest nearly always share some property by chance.
    let is_explained = |w: &&usize| {
        witnesses[**w].failed && open.iter().any(|other| format(*other) == format(**w))
    };
    let is_rest = is_few(open.len(), known.iter().filter(is_explained).count());
    let mut parts = Vec::new();
    for formats in (format_sets.iter()).filter(|_| !search.is_arbitrary && !is_rest) {
        let shared = shared_scope(witnesses, formats, open, known, false);
        let is_rule = |shared: &SharedScope| {
            is_most(shared.cases.len(), open.len()) && shared.is_prevalent(witnesses)
        };
        if let Some(shared) = shared.filter(is_rule) {
            open.retain(|w| !shared.cases.contains(w));
            parts.push(CauseGroup {
                files: files_in_scope(witnesses, &shared),
                // The clause of the step is closer to the cause than the clause of a property.
                clause: match shared.scope {
                    FileScope::Beyond { .. } => shared.scope.clause(),
                    _ => None,
                },
                cases: shared.cases,
            });
        }
    }
    parts
}

fn difference_text(
    search: &Search,
    set: &[MistakeId],
    step: Phase,
    part: &CauseGroup,
) -> Diagnosis {
    let (witnesses, indices) = (search.witnesses, &part.cases[..]);
    let clauses = indices
        .iter()
        .map(|&w| step.clause(witnesses[w].case.format()));
    let clauses: BTreeSet<_> = clauses.collect();
    let first = clauses.first().copied().flatten();
    let clause = match clauses.len() {
        1 => first,
        _ => step.common_clause().or(part.clause).or(first),
    };
    let mut wrong = wrong_channels(search, set, indices);
    wrong.retain(|_| indices.len() >= MIN_SHARING_FILES);
    // Only R, G and B, or Cr and Cb, are wrong in a format with one polynomial.
    let are_colors =
        matches!(wrong.len(), 8 | 9) && !wrong[..6].contains(&true) && wrong.contains(&true);
    let clause = match (step, clause) {
        (Phase::StoredValue, Some("2.7.3/1")) if are_colors => Some("2.7.3/2"),
        (Phase::StoredValue, Some("2.8.1/1")) if are_colors => Some("2.8.1/4"),
        (Phase::FinalValue, _) if are_colors => Some("2.4/9"),
        _ => clause,
    };
    let [effect, fix] = step.effect_and_fix();
    let [_, swap_fix] = Phase::Rearranged.effect_and_fix();
    let format = witnesses[indices[0]].case.format();
    let (effect, fix, clause) = match swapped_channels(search, set, indices, &wrong) {
        Some([first, second]) => {
            let effect = format!("swaps {first} and {second}");
            (effect, swap_fix, Phase::Rearranged.clause(format))
        }
        None => (format!("{effect}{}", channel_text(&wrong)), fix, clause),
    };
    let views = views_phrase(witnesses, indices);
    let text = CauseText {
        effect: format!("{effect}, in {}{views}", part.files),
        fix: fix.to_owned(),
        example: example(search, set, smallest_file(witnesses, indices)),
    };
    Diagnosis::from_description(Category::Difference, witnesses, indices, text).with_clause(clause)
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

/// Returns one flag per channel: true if the channel is wrong in an image of the earliest view. Returns an empty list if the
/// images differ in their number of channels.
pub(in crate::diagnose) fn wrong_channels(
    search: &Search,
    set: &[MistakeId],
    indices: &[usize],
) -> Vec<bool> {
    let pairs = indices.iter().filter_map(|&w| image_pair(search, set, w));
    let mut pairs: Vec<ImagePair> = pairs.collect();
    let first = pairs.iter().map(|pair| pair.view).min();
    pairs.retain(|pair| Some(pair.view) == first);
    let count = pairs.first().map_or(0, |pair| pair.channels);
    if pairs.iter().any(|pair| pair.channels != count) {
        return Vec::new();
    }
    let is_wrong = |channel: usize| pairs.iter().any(|pair| pair.wrong_channels()[channel]);
    (0..count).map(is_wrong).collect()
}

/// Returns the names of the two wrong channels if swapping them corrects all images. Images are compared as in [`image_pair`].
fn swapped_channels(
    search: &Search,
    set: &[MistakeId],
    indices: &[usize],
    wrong: &[bool],
) -> Option<[String; 2]> {
    let channels: Vec<usize> = (0..wrong.len()).filter(|&channel| wrong[channel]).collect();
    let [first, second] = channels[..] else {
        return None;
    };
    let is_swapped = |&w: &usize| {
        let pair = image_pair(search, set, w).filter(|pair| pair.channels == wrong.len());
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

/// Returns text such as ", only in a3" if all other channels are correct.
fn channel_text(wrong: &[bool]) -> String {
    let names: Vec<String> = (0..wrong.len())
        .filter(|&channel| wrong[channel])
        .map(|channel| channel_name(wrong.len(), channel))
        .collect();
    match names.len() {
        0 => String::new(),
        1..=MAX_LISTED if names.len() < wrong.len() => format!(", only in {}", names.join(", ")),
        _ => ChannelSubset::smallest_containing(wrong).describe(),
    }
}

/// Returns the step at which the values of an image first differ. It may be the order of values only if `with_order` is true.
fn first_difference(search: &Search, set: &[MistakeId], w: usize, with_order: bool) -> Phase {
    let witness = &search.witnesses[w];
    let Some(received) = witness.wrong_image() else {
        return Phase::Choice;
    };
    let answer = search.best_answer(w, set);
    let ((Answer::Decoded(frame), _) | (_, Answer::Decoded(frame))) = (&*answer, &witness.expected)
    else {
        return Phase::NoReading;
    };
    let Some(pair) = ImagePair::new(frame, received) else {
        let size = |frame: &Frame| (frame.width, frame.height);
        return match size(frame) == size(received) {
            true => Phase::Channels,
            false => Phase::Size,
        };
    };
    if with_order && is_rearranged(&pair) {
        return Phase::Rearranged;
    }
    let plain = match has_wrong_stored_values(&pair, witness) {
        true => Phase::StoredValue,
        false => Phase::for_view(pair.view),
    };
    if plain == Phase::Color || witness.case.format().coding().is_none() {
        return plain;
    }
    match first_difference_of_planes(&pair, witness) {
        step @ (Phase::Prediction | Phase::Correction | Phase::CorrectedPlane) => step,
        step if pair.view == ViewKind::Raw || plain == Phase::StoredValue => step,
        // A later step may explain the wrong samples of a stream.
        _ => plain,
    }
}

/// Returns true if wrong final values must result from wrong stored values: each final value corresponds to a byte, but in some
/// channel these bytes are not a monotonic function of the correct ones. No mistake in applying scale and bias explains this.
fn has_wrong_stored_values(pair: &ImagePair, witness: &Witness) -> bool {
    let (ViewKind::Coef, Ok(ptm)) = (pair.view, witness.decoded()) else {
        return false;
    };
    let ScaleBias { scale, bias } = ptm.header.scale_bias;
    let polynomials = if pair.channels == 18 { 18 } else { 6 };
    let stored = |values: &[f64], channel: usize| -> Vec<f64> {
        let values = values.iter().skip(channel).step_by(pair.channels);
        let raw = |value: &f64| match channel < polynomials {
            true => value / scale[channel % 6] + bias[channel % 6],
            false => *value,
        };
        values.map(raw).collect()
    };
    let is_byte =
        |value: &f64| (-1e-3..255.5).contains(value) && (value - value.round()).abs() < 1e-3;
    let mut is_reordered = false;
    for channel in 0..pair.channels {
        let [expected, received] = [&pair.expected, &pair.received].map(|all| stored(all, channel));
        if !received.iter().all(is_byte) {
            return false;
        }
        let pairs = expected.iter().zip(&received);
        let mut pairs: Vec<(i64, i64)> = pairs
            .map(|(a, b)| (a.round() as i64, b.round() as i64))
            .collect();
        pairs.sort_unstable();
        let rises = pairs.windows(2).any(|pair| pair[1].1 > pair[0].1);
        let falls = pairs.windows(2).any(|pair| pair[1].1 < pair[0].1);
        is_reordered |= rises && falls;
    }
    is_reordered
}

/// Returns true if an image has the correct values in the wrong order.
fn is_rearranged(pair: &ImagePair) -> bool {
    let sorted = |values: &[f64]| {
        let mut bits: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
        bits.sort_unstable();
        bits
    };
    pair.wrong_samples().len() >= MIN_SUPPORT && sorted(&pair.expected) == sorted(&pair.received)
}

/// Returns the step for a compressed file: [`Phase::Stream`] only if a plane that is neither predicted nor corrected has
/// wrong values, as opposed to correct values in the wrong order.
fn first_difference_of_planes(pair: &ImagePair, witness: &Witness) -> Phase {
    let Some(coded) = witness.model().and_then(|model| model.compressed.as_ref()) else {
        return Phase::StoredValue;
    };
    let wrong = pair.wrong_channels();
    let plain = |plane: &usize| wrong[*plane] && witness.is_plain_plane(*plane);
    let is_corrected = |i: &usize| {
        let (texel, plane) = (i / pair.channels, i % pair.channels);
        let (x, y) = (texel % pair.width, texel / pair.width);
        let stored = (pair.height - 1 - y) * pair.width + x;
        let mut records = coded.planes[plane].records.iter();
        records.any(|&(position, _)| position as usize == stored)
    };
    let reference = |plane: usize| coded.plan.reference(plane);
    // Planes that are predicted from a wrong plane are no evidence.
    let is_root =
        |plane: &usize| wrong[*plane] && reference(*plane).is_none_or(|other| !wrong[other]);
    let roots: Vec<usize> = (0..wrong.len()).filter(is_root).collect();
    // A misread record leaves one texel uncorrected and changes at most one other. Prediction does not affect corrected texels.
    let records = roots.iter().map(|&plane| coded.planes[plane].records.len());
    let mut samples = pair.wrong_samples();
    samples.retain(|i| roots.contains(&(i % pair.channels)));
    if samples.is_empty() {
        Phase::StoredValue
    } else if samples.iter().all(is_corrected) {
        Phase::Correction
    } else if samples.iter().any(is_corrected)
        && records.clone().all(|count| count > 0)
        && samples.len() <= 2 * records.sum::<usize>()
    {
        Phase::CorrectedPlane
    } else if (0..wrong.len()).all(|plane| !wrong[plane] || reference(plane).is_some()) {
        Phase::Prediction
    } else if (0..wrong.len()).any(|plane| plain(&plane)) {
        let is_moved = |plane: usize| is_rearranged(&pair.channel(plane));
        match (0..wrong.len()).filter(plain).all(is_moved) {
            true => Phase::Rearranged,
            false => Phase::Stream,
        }
    } else {
        Phase::StoredValue
    }
}

/// Returns true if the mistake `member` more than halves the number of wrong samples in case `w`, or may explain the crash of the
/// decoder in this case.
pub(in crate::diagnose) fn reduces_wrong_samples(
    search: &Search,
    w: usize,
    set: &[MistakeId],
    member: MistakeId,
) -> bool {
    let witness = &search.witnesses[w];
    let (with, without) = (
        search.best_answer(w, set),
        search.best_answer(w, &without_id(set, member)),
    );
    let (Answer::Decoded(with), Answer::Decoded(without)) = (&*with, &*without) else {
        return false;
    };
    if with == without {
        return false;
    }
    if let Some(received) = witness.wrong_image() {
        let wrong = |answer: &Frame| Some(ImagePair::new(answer, received)?.wrong_samples().len());
        return matches!((wrong(with), wrong(without)), (Some(with), Some(without)) if is_most(without.saturating_sub(with), without));
    }
    // A decoder that reads out of bounds may crash on one file and output wrong values for another.
    let clause = search.mistakes[member].misreading.clause;
    let mut sections = ["2.5", "2.6", "2.8", "2.9"].iter();
    let is_crash = matches!(
        witness.observation.response,
        Response::Violation(Answer::Crashed(_))
    );
    is_crash && sections.any(|section| clause.starts_with(section))
}

/// Returns the received image and the image of a decoder with these mistakes, or `None` if their shapes differ.
pub fn image_pair(search: &Search, set: &[MistakeId], w: usize) -> Option<ImagePair> {
    let received = search.witnesses[w].wrong_image()?;
    match &*search.best_answer(w, set) {
        Answer::Decoded(expected) => ImagePair::new(expected, received),
        _ => None,
    }
}

/// Returns the smallest of these files. Prefers stored and final values to colors.
pub(in crate::diagnose) fn smallest_file(witnesses: &[Witness], indices: &[usize]) -> usize {
    let size = |w: &usize| (witnesses[*w].is_rgb(), witnesses[*w].built.file.len());
    let smallest = indices.iter().copied().min_by_key(size);
    smallest.expect("a diagnosis explains at least one case")
}

/// Describes the first wrong sample in a file that the mistakes in `set` do not explain: its received and expected values, the
/// arithmetic, and the bytes that determine the expected value.
pub(in crate::diagnose) fn example(search: &Search, set: &[MistakeId], w: usize) -> String {
    let witness = &search.witnesses[w];
    let id = &witness.case.id;
    let first = image_pair(search, &[], w).and_then(|mut pair| {
        if let Some(exact) = expected_values(witness, &pair) {
            pair.expected = exact;
        }
        let open = image_pair(search, set, w).map(|pair| pair.wrong_samples());
        let first = first_wrong(&pair, witness, &open.unwrap_or_default())?;
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
    let is_limited =
        pair.view == ViewKind::Rgb && (pair.expected[i] <= 0.0 || pair.expected[i] >= 255.0);
    let limited = is_limited.then_some(", limited to 0…255");
    let limited = limited.unwrap_or_default();
    text.extend(
        format_arithmetic(witness, texel, channel).map(|steps| format!(" = {steps}{limited}")),
    );
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

/// Returns the expected values before rounding.
fn expected_values(witness: &Witness, pair: &ImagePair) -> Option<Vec<f64>> {
    let expected = Expected::new(&witness.built.values, &witness.observation.view)?;
    let is_pair = expected.view != ViewKind::Raw && expected.values.len() == pair.expected.len();
    is_pair.then_some(expected.values)
}
