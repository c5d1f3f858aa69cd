//! Finds the step at which wrong images first differ from those of a decoder that makes the mistakes found so far.
//!
//! A single image leaves several steps possible, so the images of a family are classified together: those of one uncompressed
//! format, or of the formats with the same coding, which share their streams.

use std::collections::BTreeSet;

use super::image_pair::{ImagePair, image_pair};
use super::scope::files_of;
use super::search::{MistakeId, MistakeSet, Search};
use super::tuning::{MIN_SHARING_FILES, MIN_SUPPORT, is_most, is_substantial};
use super::witness::Witness;
use ptm::{Coding, Format, ScaleBias};
use ptm_generate::planes::Compressed;
use ptm_suite::protocol::frame::{Answer, Frame, ViewKind};

/// The step at which the values of an image first differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Step {
    Size,
    Channels,
    SampleType,
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

impl Step {
    /// Returns the last step that affects the values in a view.
    fn for_view(view: ViewKind) -> Step {
        match view {
            ViewKind::Raw => Step::StoredValue,
            ViewKind::Coef => Step::FinalValue,
            ViewKind::Rgb => Step::Color,
        }
    }

    /// Returns true if a mistake in this step may explain a wrong image that does not reveal the step itself.
    fn can_explain(self, witness: &Witness) -> bool {
        let coded = witness.model().and_then(|model| model.compressed.as_ref());
        // Final values reveal whether planes are predicted and corrected.
        let coded = coded.filter(|_| witness.is_rgb());
        let is_identity = |pair: &ScaleBias| pair.scale == [1.0; 6] && pair.bias == [0.0; 6];
        match self {
            Step::Prediction => coded.is_some_and(|coded| coded.plan.predicts()),
            Step::Correction | Step::CorrectedPlane => coded
                .is_some_and(|coded| coded.planes.iter().any(|plane| !plane.records.is_empty())),
            Step::FinalValue => {
                !matches!(witness.decoded(), Ok(ptm) if is_identity(&ptm.header.scale_bias))
            }
            // A shape, or a reading of the whole file, shows in every image.
            Step::Size | Step::Channels | Step::SampleType | Step::Choice | Step::NoReading => {
                false
            }
            _ => true,
        }
    }
}

/// Returns the step of each wrong image in `left`.
pub(super) fn steps(search: &Search, set: &MistakeSet, left: &[usize]) -> Vec<(usize, Step)> {
    let alone = search.par_map(left, |&w| first_difference(search, set, w, true));
    let alone: Vec<(usize, Step)> = left.iter().copied().zip(alone).collect();
    let coding = |w: usize| search.witnesses[w].case.format().coding();
    let is_plain_wrong = alone
        .iter()
        .any(|&(w, step)| step == Step::StoredValue && coding(w).is_none());
    let open = search.unexplained(set);
    let families = families();
    let is_color_wrong = families.iter().any(|formats| {
        let members = files_of(search.witnesses, left, formats);
        !members.is_empty() && members.iter().all(|&w| search.witnesses[w].is_rgb())
    });
    let mut steps = Vec::new();
    for formats in families {
        let family = Family::new(search, set, &formats, &alone, &open, is_plain_wrong);
        steps.extend(family.steps(is_color_wrong));
    }
    steps
}

/// Returns the families: each uncompressed format, and the formats of each coding.
fn families() -> Vec<Vec<Format>> {
    let plain = Format::ALL.into_iter().filter(|one| one.coding().is_none());
    let coded = [Coding::Jpeg, Coding::JpegLs].map(|coding| {
        let all = Format::ALL.into_iter();
        all.filter(|one| one.coding() == Some(coding)).collect()
    });
    plain.map(|one| vec![one]).chain(coded).collect()
}

/// The wrong images of a family, and what they have in common.
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is an independent fact about the images"
)]
struct Family<'a> {
    search: &'a Search<'a>,
    set: &'a MistakeSet,
    /// The images, and the step that each reveals alone.
    images: Vec<(usize, Step)>,
    /// True if the right values in the wrong order are no coincidence.
    is_rearranged: bool,
    /// True if all images of stored values are correct.
    are_stored_values_right: bool,
    /// The step of images with wrong values in planes that are not predicted.
    early: Step,
    /// True if wrong planes that are not predicted outnumber wrong predicted planes, which follow from them.
    are_predictions_late: bool,
    /// True if wrong planes without records outnumber the images with wrong values only in corrected planes.
    are_corrections_late: bool,
    /// True if many images have wrong values at other texels of corrected planes.
    are_corrected_planes_wrong: bool,
    /// Number of open wrong images, and of images of legal files, by view.
    wrong: [usize; 3],
    all: [usize; 3],
}

impl<'a> Family<'a> {
    fn new(
        search: &'a Search<'a>,
        set: &'a MistakeSet,
        formats: &[Format],
        alone: &[(usize, Step)],
        open: &[usize],
        is_plain_wrong: bool,
    ) -> Family<'a> {
        let witnesses = search.witnesses;
        let is_member = |w: usize| formats.contains(&witnesses[w].case.format());
        let mut images = alone.to_vec();
        images.retain(|&(w, _)| is_member(w));
        let count = |step: Step| images.iter().filter(|image| image.1 == step).count();
        let ordered = images.iter().filter(|image| image.1 >= Step::Rearranged);
        let streams = count(Step::Stream);
        let [predictions, planes] = [Step::Prediction, Step::CorrectedPlane].map(count);
        let corrections = planes + count(Step::Correction);
        let others = streams + count(Step::Rearranged) + count(Step::StoredValue);
        let is_stream = !is_plain_wrong
            && formats[0].coding().is_some()
            && is_substantial(streams, others + predictions + corrections);
        let legal: Vec<usize> = (0..witnesses.len())
            .filter(|&w| is_member(w) && witnesses[w].is_image_of_legal_file())
            .collect();
        let with_view = |cases: &[usize], view: ViewKind| {
            let has_view = |w: &&usize| witnesses[**w].observation.view.kind() == view;
            cases.iter().filter(has_view).count()
        };
        let mut wrong = open.to_vec();
        wrong.retain(|w| legal.contains(w));
        let raw = |failed: bool| {
            (0..witnesses.len())
                .filter(move |&w| is_member(w) && witnesses[w].failed == failed)
                .filter(|&w| witnesses[w].observation.view.kind() == ViewKind::Raw)
        };
        let right_raw = raw(false).filter(|&w| witnesses[w].is_image_of_legal_file());
        Family {
            search,
            set,
            is_rearranged: is_most(count(Step::Rearranged), ordered.count()),
            are_stored_values_right: raw(true).next().is_none()
                && right_raw.count() >= MIN_SHARING_FILES,
            early: if is_stream {
                Step::Stream
            } else {
                Step::StoredValue
            },
            are_predictions_late: others > predictions,
            are_corrections_late: others > corrections,
            are_corrected_planes_wrong: is_substantial(planes, corrections),
            wrong: ViewKind::ALL.map(|view| with_view(&wrong, view)),
            all: ViewKind::ALL.map(|view| with_view(&legal, view)),
            images,
        }
    }

    /// Returns the step of each image. Images in later views follow those in earlier views, but colors do not if `is_color_wrong`: in
    /// another family, only colors are wrong, so these may be wrong for the same reason.
    fn steps(&self, is_color_wrong: bool) -> Vec<(usize, Step)> {
        let mut steps: Vec<(usize, Step)> = Vec::new();
        let mut known: [BTreeSet<Step>; 3] = Default::default();
        for (index, view) in ViewKind::ALL.into_iter().enumerate() {
            for &(w, alone) in &self.images {
                let witness = &self.search.witnesses[w];
                if witness.observation.view.kind() != view {
                    continue;
                }
                let mut step = self.step_in_view(w, alone);
                if step >= Step::FinalValue
                    && !(is_color_wrong && witness.is_rgb())
                    && let Some(earlier) = self.explaining_view(index)
                    && !are_stored_values_as_expected(self.search, self.set, w)
                {
                    let mut before = known[earlier].iter().rev();
                    step = before
                        .find(|before| before.can_explain(witness))
                        .copied()
                        .unwrap_or(step);
                }
                known[index].insert(step);
                steps.push((w, step));
            }
        }
        steps
    }

    /// Returns the step of an image, apart from other views.
    fn step_in_view(&self, w: usize, alone: Step) -> Step {
        let witness = &self.search.witnesses[w];
        let step = match alone {
            Step::Rearranged if !self.is_rearranged => {
                match first_difference(self.search, self.set, w, false) {
                    Step::Rearranged => Step::StoredValue,
                    step => step,
                }
            }
            step => step,
        };
        let is_stored = (Step::Stream..=Step::StoredValue).contains(&step);
        if is_stored
            && self.are_stored_values_right
            && witness.observation.view.kind() == ViewKind::Coef
        {
            return Step::FinalValue;
        }
        match step {
            Step::Stream | Step::StoredValue => self.early,
            Step::Prediction if self.are_predictions_late => self.early,
            Step::Correction | Step::CorrectedPlane if self.are_corrections_late => self.early,
            Step::Correction if self.are_corrected_planes_wrong => Step::CorrectedPlane,
            step => step,
        }
    }

    /// Returns the first earlier view whose wrong images explain those in the view at `index`: it has more than half as many wrong
    /// images, and at least half the share.
    fn explaining_view(&self, index: usize) -> Option<usize> {
        (0..index).find(|&earlier| {
            self.wrong[earlier] >= MIN_SHARING_FILES
                && is_most(self.wrong[earlier], self.wrong[index])
                && 2 * self.wrong[earlier] * self.all[index]
                    >= self.wrong[index] * self.all[earlier]
        })
    }
}

/// Returns the step at which the values of an image first differ, as far as it alone reveals the step. It may be the order of
/// values only if `with_order` is true.
fn first_difference(search: &Search, set: &[MistakeId], w: usize, with_order: bool) -> Step {
    let witness = &search.witnesses[w];
    let Some(received) = witness.wrong_image() else {
        return Step::Choice;
    };
    let answer = search.best_answer(w, set);
    let ((Answer::Decoded(frame), _) | (_, Answer::Decoded(frame))) = (&*answer, &witness.expected)
    else {
        return Step::NoReading;
    };
    let Some(pair) = ImagePair::new(witness, frame, received) else {
        let size = |frame: &Frame| (frame.width, frame.height);
        return if size(frame) != size(received) {
            Step::Size
        } else if frame.channels != received.channels {
            Step::Channels
        } else {
            Step::SampleType
        };
    };
    if with_order && is_rearranged(&pair) {
        return Step::Rearranged;
    }
    let plain = match has_wrong_stored_values(&pair, witness) {
        true => Step::StoredValue,
        false => Step::for_view(pair.view),
    };
    if plain == Step::Color || witness.case.format().coding().is_none() {
        return plain;
    }
    let planes = WrongPlanes::new(&pair, witness);
    let of_planes = planes.map(|planes| planes.first_difference());
    match of_planes.unwrap_or(Step::StoredValue) {
        step @ (Step::Prediction | Step::Correction | Step::CorrectedPlane) => step,
        step if pair.view == ViewKind::Raw || plain == Step::StoredValue => step,
        // A later step may explain the wrong samples of a stream.
        _ => plain,
    }
}

/// Returns true if wrong final values cannot result from wrong stored values: each is off by less than half of what another byte
/// would change.
fn are_stored_values_as_expected(search: &Search, set: &[MistakeId], w: usize) -> bool {
    let pair = image_pair(search, set, w).filter(|pair| pair.view == ViewKind::Coef);
    let (Some(pair), Ok(ptm)) = (pair, search.witnesses[w].decoded()) else {
        return false;
    };
    let polynomials = if pair.channels == 18 { 18 } else { 6 };
    let step = |channel: usize| match channel < polynomials {
        true => ptm.header.scale_bias.scale[channel % 6].abs(),
        false => 1.0,
    };
    let is_small =
        |i: usize| (pair.received[i] - pair.expected[i]).abs() < step(i % pair.channels) / 2.0;
    pair.wrong_samples().into_iter().all(is_small)
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
pub(super) fn is_rearranged(pair: &ImagePair) -> bool {
    let sorted = |values: &[f64]| {
        let mut bits: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
        bits.sort_unstable();
        bits
    };
    pair.wrong_samples().len() >= MIN_SUPPORT && sorted(&pair.expected) == sorted(&pair.received)
}

/// The wrong planes in the stored or final values of a compressed file.
struct WrongPlanes<'a> {
    pair: &'a ImagePair,
    coded: &'a Compressed,
    samples: Vec<usize>,
    wrong: Vec<bool>,
}

impl<'a> WrongPlanes<'a> {
    /// Returns `None` for a file without a model of its planes.
    fn new(pair: &'a ImagePair, witness: &'a Witness) -> Option<WrongPlanes<'a>> {
        let coded = witness.model()?.compressed.as_ref()?;
        let samples = pair.wrong_samples();
        let mut wrong = vec![false; pair.channels];
        for i in &samples {
            wrong[i % pair.channels] = true;
        }
        Some(WrongPlanes {
            pair,
            coded,
            samples,
            wrong,
        })
    }

    /// Returns the wrong planes.
    fn planes(&self) -> impl Iterator<Item = usize> {
        (0..self.wrong.len()).filter(|&plane| self.wrong[plane])
    }

    fn is_predicted(&self, plane: usize) -> bool {
        self.coded.plan.reference(plane).is_some()
    }

    /// Returns the wrong planes that are neither predicted nor corrected.
    fn plain_planes(&self) -> impl Iterator<Item = usize> {
        let is_plain = |plane: &usize| !self.is_predicted(*plane) && self.record_count(*plane) == 0;
        self.planes().filter(is_plain)
    }

    fn record_count(&self, plane: usize) -> usize {
        self.coded.planes[plane].records.len()
    }

    /// Returns the wrong planes that are not predicted from a wrong plane. Those that are show nothing.
    fn roots(&self) -> Vec<usize> {
        let is_wrong = |reference: usize| self.wrong[reference];
        let is_root = |plane: &usize| !self.coded.plan.reference(*plane).is_some_and(is_wrong);
        self.planes().filter(is_root).collect()
    }

    /// Returns the wrong samples of the roots.
    fn samples_of_roots(&self) -> impl Iterator<Item = usize> {
        let roots = self.roots();
        let is_of_root = move |i: &usize| roots.contains(&(i % self.pair.channels));
        self.samples.iter().copied().filter(is_of_root)
    }

    /// Returns true if side information corrects a sample.
    fn is_corrected(&self, i: usize) -> bool {
        let pair = self.pair;
        let (texel, plane) = (i / pair.channels, i % pair.channels);
        let (x, y) = (texel % pair.width, texel / pair.width);
        let stored = (pair.height - 1 - y) * pair.width + x;
        let mut records = self.coded.planes[plane].records.iter();
        records.any(|&(position, _)| position as usize == stored)
    }

    /// Returns true if the wrong values are where a mistake in a step shows: in predicted planes only, or only at texels or in planes
    /// with records and in planes predicted from them, or in some plain plane, or there in another order.
    fn are_of(&self, step: Step) -> bool {
        match step {
            Step::Prediction => self.planes().all(|plane| self.is_predicted(plane)),
            Step::Correction => self.samples_of_roots().all(|i| self.is_corrected(i)),
            Step::CorrectedPlane => self
                .roots()
                .iter()
                .all(|&plane| self.record_count(plane) > 0),
            Step::Stream => self.plain_planes().next().is_some(),
            Step::Rearranged => {
                let is_moved = |plane: usize| is_rearranged(&self.pair.channel(plane));
                self.are_of(Step::Stream) && self.plain_planes().all(is_moved)
            }
            _ => true,
        }
    }

    /// Returns the step at which the values first differ: [`Step::Stream`] only if a plane that is neither predicted nor corrected
    /// has wrong values, as opposed to correct values in the wrong order.
    fn first_difference(&self) -> Step {
        let roots = self.roots();
        let records = roots.iter().map(|&plane| self.record_count(plane));
        if roots.is_empty() {
            Step::StoredValue
        } else if self.are_of(Step::Correction) {
            Step::Correction
        } else if self.are_of(Step::CorrectedPlane)
            && self.samples_of_roots().any(|i| self.is_corrected(i))
            // A misread record leaves one texel uncorrected and changes at most one other.
            && self.samples_of_roots().count() <= 2 * records.sum::<usize>()
        {
            Step::CorrectedPlane
        } else if self.are_of(Step::Prediction) {
            Step::Prediction
        } else if self.are_of(Step::Rearranged) {
            Step::Rearranged
        } else if self.are_of(Step::Stream) {
            Step::Stream
        } else {
            Step::StoredValue
        }
    }
}

/// Returns true if the values in each of these images that differ from those of a decoder with the mistakes in `set` are where a
/// mistake in `step` shows. Colors do not show it, so there must be other images.
pub(super) fn are_differences_of(
    search: &Search,
    set: &[MistakeId],
    step: Step,
    cases: &[usize],
) -> bool {
    let cases = cases.iter().map(|&w| (w, &search.witnesses[w]));
    let mut values = cases.filter(|(_, witness)| !witness.is_rgb()).peekable();
    values.peek().is_some()
        && values.all(|(w, witness)| {
            let is_of_step = |pair: &ImagePair| {
                WrongPlanes::new(pair, witness).is_some_and(|planes| planes.are_of(step))
            };
            image_pair(search, set, w).as_ref().is_some_and(is_of_step)
        })
}

/// Returns one flag per channel: true if the channel is wrong in an image of the earliest view. Returns an empty list if the
/// images differ in their number of channels.
pub(super) fn wrong_channels(search: &Search, set: &[MistakeId], indices: &[usize]) -> Vec<bool> {
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
