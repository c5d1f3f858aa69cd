//! Computes how a decoder that makes certain mistakes answers a case.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use super::mistake::{ChannelSubset, Mistake};
use super::tuning::{ROUNDING_SLACK, is_few, is_third};
use super::witness::{
    Agreement, Witness, applies_to_file, equal_up_to_rounding, is_after_decoding, is_same_value,
};
use ptm::error::Error;
use ptm::{Ptm, Reading};
use ptm_mistakes::formula::{self, Edit, Edits, Formula, Outside, final_values};
use ptm_mistakes::{Change, Misreading, Stage};
use ptm_suite::protocol::frame::{Answer, Frame, Samples, View};
use ptm_suite::verdicts::observation::Response;

/// Rounding error of colors computed in double precision.
const TINY: f64 = 1e-6;

impl Witness<'_> {
    /// Returns the answer of a decoder that makes these `mistakes`.
    pub fn answer(&self, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let (whole, partial) = self.in_scope(mistakes);
        if partial.is_empty() {
            return self.answer_of_misreadings(&whole);
        }
        let (file, decoded) = (&self.built.file, self.decoded().as_ref().ok());
        Cow::Owned(self.answer_to(self.reading, file, decoded, &whole, &partial))
    }

    /// Returns the answer of a decoder that makes these mistakes to a request for `file`, in this reading.
    pub fn answer_in(&self, reading: Reading, file: &[u8], mistakes: &[&Mistake]) -> Answer {
        let (whole, partial) = self.in_scope(mistakes);
        self.answer_to(reading, file, None, &whole, &partial)
    }

    /// Returns the mistakes that affect the format of the file in all channels, and those that affect some channels.
    fn in_scope<'m>(
        &self,
        mistakes: &[&'m Mistake],
    ) -> (Vec<&'static Misreading>, Vec<&'m Mistake>) {
        let in_scope = mistakes
            .iter()
            .filter(|mistake| mistake.affects(self.case.format()));
        let (whole, partial): (Vec<&Mistake>, Vec<&Mistake>) = in_scope
            .copied()
            .partition(|mistake| mistake.channels == ChannelSubset::All);
        let whole = whole.iter().map(|mistake| mistake.misreading);
        (whole.collect(), partial)
    }

    /// Returns the answer of a decoder that makes the mistakes in `whole` in all channels, and those in `partial` in some. Stored
    /// values, final values and colors are computed one after the other, and each mistake changes only its channels of the first
    /// that it affects. `decoded` is the map in `file` under `reading`, if it is known.
    fn answer_to(
        &self,
        reading: Reading,
        file: &[u8],
        decoded: Option<&Ptm>,
        whole: &[&Misreading],
        partial: &[&Mistake],
    ) -> Answer {
        if partial.is_empty() {
            return ptm_mistakes::answer(whole, reading, file, &self.observation.view);
        }
        let unchanged = reading;
        let stored_values = |mistakes: &[&Misreading]| {
            let (ptm, reading) = read(mistakes, unchanged, file, decoded)?;
            Ok((ptm_mistakes::stored_values(mistakes, &ptm), reading))
        };
        let (mut ptm, reading) = match stored_values(whole) {
            Ok(read) => read,
            Err(error) => return ptm_mistakes::refusal_answer(error),
        };
        let shape = ptm.planes.shape;
        let (channels, view) = (shape.channels(), &self.observation.view);
        let with = |mistake: &Mistake| [whole, &[mistake.misreading]].concat();
        let of_stage = |stages: RangeInclusive<Stage>| {
            let all = partial.iter().copied();
            all.filter(move |mistake| stages.contains(&mistake.misreading.stage()))
        };
        for mistake in of_stage(Stage::File..=Stage::Planes) {
            match stored_values(&with(mistake)) {
                Ok((other, _)) => {
                    let samples = &mut ptm.planes.samples;
                    mistake
                        .channels
                        .replace(channels, samples, &other.planes.samples);
                }
                Err(error) => return ptm_mistakes::refusal_answer(error),
            }
        }
        let decisions = |mistakes: &[&Misreading]| {
            let reading = ptm_mistakes::apply_to_reading(mistakes, unchanged);
            (reading, ptm_mistakes::formula_edits(mistakes))
        };
        let frame = |samples| Answer::Decoded(Frame::of_map(&ptm, view, samples));
        if *view == View::Raw {
            return frame(Samples::U8(ptm.planes.samples.clone()));
        }
        let edits = ptm_mistakes::formula_edits(whole);
        let mut finals = final_values(&ptm, &reading, Edits(&edits));
        for mistake in of_stage(Stage::Coefficients..=Stage::Coefficients) {
            let (reading, edits) = decisions(&with(mistake));
            let other = final_values(&ptm, &reading, Edits(&edits)).values;
            mistake
                .channels
                .replace(channels, &mut finals.values, &other);
        }
        let View::Rgb(light) = view else {
            let floats = formula::floats(finals.values, Edits(&edits));
            return frame(view.kind().samples(&floats));
        };
        let image = |reading: &Reading, edits: &[&Edit]| {
            formula::image(&finals, light.lu, light.lv, reading, Edits(edits)).values
        };
        let mut colors = image(&reading, &edits);
        for mistake in of_stage(Stage::Color..=Stage::Color) {
            let (reading, edits) = decisions(&with(mistake));
            mistake
                .channels
                .replace(3, &mut colors, &image(&reading, &edits));
        }
        frame(view.kind().samples(&colors))
    }

    /// Returns the image of a decoder that reads outside the data without noticing. It may find nothing there, so that later values
    /// move up, if this gives the response. Otherwise, what it finds may be anything, so these samples are those of the response. Returns
    /// `None` if no edited position can be outside, or if less than a third of the wrong
    /// samples are inside.
    pub fn answer_beyond_data(&self, mistakes: &[&Mistake]) -> Option<Answer> {
        let (whole, partial) = self.in_scope(mistakes);
        if !partial.is_empty() || !mistakes.iter().any(|mistake| edits_position(mistake)) {
            return None;
        }
        if !matches!(self.observation.response, Response::Image { .. }) {
            return None;
        }
        let answer = |outside| {
            let (file, view) = (&self.built.file, &self.observation.view);
            ptm_mistakes::answer_with(&whole, self.reading, file, view, outside)
        };
        let moved = answer(Outside::Nothing);
        if !self.failed && moved == self.expected {
            return Some(moved);
        }
        let [Answer::Decoded(image), Answer::Decoded(other)] =
            [0, u8::MAX].map(|byte| answer(Outside::Byte(byte)))
        else {
            return None;
        };
        if image.shape() != other.shape() {
            return None;
        }
        let [values, others] = [&image, &other].map(|frame| frame.samples.to_reals());
        let is_inside = |i: usize| is_same_value(values[i], others[i]);
        // If nothing is inside, all values are 0.
        let inside = (0..values.len()).filter(|&i| is_inside(i)).count();
        let wrong = self.wrong_samples(&image)?;
        if self.failed
            && inside > 0
            && is_third(inside, wrong.len())
            && self.agreement(&moved) == Agreement::Image
        {
            return Some(moved);
        }
        self.with_values_inside(&image, is_inside)
    }

    /// Returns the image of a decoder that, for some colors, takes values of a channel outside the texel. They may be anything, so
    /// these colors are those of a wrong image. `made` is the image of a decoder that takes those of another texel. Returns `None` if
    /// no edited channel is outside the texel, or if less than a third of the wrong samples are of other colors.
    pub fn answer_beyond_texel(&self, mistakes: &[&Mistake], made: &Answer) -> Option<Answer> {
        let (whole, partial) = self.in_scope(mistakes);
        // Values from outside the texel do not make all colors correct.
        let may_be_any = partial.is_empty() && self.failed;
        let (View::Rgb(_), true, Answer::Decoded(image)) =
            (&self.observation.view, may_be_any, made)
        else {
            return None;
        };
        let edits = ptm_mistakes::formula_edits(&whole);
        let inside = formula::colors_inside_texel(&self.case.format().shape(), Edits(&edits));
        if inside == [true; 3] {
            return None;
        }
        self.with_values_inside(image, |i| inside[i % 3])
    }

    /// Returns the response, with the samples of `image` that satisfy `is_inside`. Returns `None` if the shapes differ, or if less
    /// than a third of the wrong samples are inside.
    fn with_values_inside(
        &self,
        image: &Frame,
        is_inside: impl Fn(usize) -> bool,
    ) -> Option<Answer> {
        let wrong = self.wrong_samples(image)?;
        let inside = wrong.iter().filter(|&&i| is_inside(i)).count();
        if !wrong.is_empty() && (inside == 0 || !is_third(inside, wrong.len())) {
            return None;
        }
        let Answer::Decoded(right) = &self.expected else {
            return None;
        };
        let received = self.wrong_image().unwrap_or(right);
        let [values, received] = [image, received].map(|frame| frame.samples.to_reals());
        let value = |i: usize| if is_inside(i) { values[i] } else { received[i] };
        let all: Vec<f64> = (0..values.len()).map(value).collect();
        let samples = self.observation.view.kind().samples(&all);
        let shape = [image.width, image.height, image.channels];
        Some(Answer::Decoded(Frame::exact(image.view, shape, samples)))
    }

    /// Returns the wrong samples of the response, or `None` if it does not have the shape of the correct image and of `image`.
    fn wrong_samples(&self, image: &Frame) -> Option<Vec<usize>> {
        let Answer::Decoded(right) = &self.expected else {
            return None;
        };
        let received = self.wrong_image().unwrap_or(right);
        let have_shape = [image, right]
            .iter()
            .all(|one| one.shape() == received.shape());
        let [right, received] = [right, received].map(|frame| frame.samples.to_reals());
        let wrong = |&i: &usize| !is_same_value(received[i], right[i]);
        have_shape.then(|| (0..right.len()).filter(wrong).collect())
    }

    pub fn misreadings_in_scope(&self, mistakes: &[&Mistake]) -> Vec<&'static Misreading> {
        let in_scope = mistakes
            .iter()
            .filter(|mistake| mistake.affects(self.case.format()));
        in_scope.map(|mistake| mistake.misreading).collect()
    }

    /// Returns the response if its colors equal those that the mistakes produce after rounding or truncation to bytes. This
    /// comparison is stricter than the tolerance, so it also distinguishes mistakes with small effects.
    pub fn matching_colors(&self, mistakes: &[&Mistake], made: &Answer) -> Option<Answer> {
        let (view @ View::Rgb(_), Some(actual), Answer::Decoded(made)) =
            (&self.observation.view, self.wrong_image(), made)
        else {
            return None;
        };
        let is_partial = |mistake: &&Mistake| mistake.channels != ChannelSubset::All;
        if !self.failed || mistakes.iter().any(is_partial) || !equal_up_to_rounding(actual, made) {
            return None;
        }
        let misreadings = self.misreadings_in_scope(mistakes);
        let (file, decoded) = (&self.built.file, self.decoded().as_ref().ok());
        let (ptm, reading) = read(&misreadings, self.reading, file, decoded).ok()?;
        let colors = ptm_mistakes::unrounded_values(&misreadings, &reading, &ptm, view);
        let Samples::U8(bytes) = &actual.samples else {
            return None;
        };
        let pairs = colors.iter().zip(bytes);
        let differences = pairs.map(|(color, &byte)| color - f64::from(byte));
        let differences: Vec<f64> = differences.collect();
        // Arithmetic in single precision moves few colors across the limit; in double precision, hardly any.
        let are_within = |from: f64, to: f64| {
            let is_near = |d: &f64| (from - ROUNDING_SLACK..to + ROUNDING_SLACK).contains(d);
            let is_beyond = |d: &&f64| !(from - TINY..=to + TINY).contains(*d);
            let beyond = differences.iter().filter(is_beyond).count();
            differences.iter().all(is_near) && is_few(beyond, differences.len() + 1)
        };
        let is_rounded_or_truncated = are_within(-0.5, 0.5) || are_within(0.0, 1.0 - 2.0 * TINY);
        is_rounded_or_truncated.then(|| Answer::Decoded(actual.clone()))
    }

    /// Returns the image that a decoder with `mistakes` outputs for the stored values in `ptm`.
    pub fn render_stored_values(&self, mistakes: &[&Mistake], ptm: &Ptm) -> Answer {
        let misreadings = self.misreadings_in_scope(mistakes);
        let reading = ptm_mistakes::apply_to_reading(&misreadings, self.reading);
        ptm_mistakes::render(&misreadings, &reading, ptm, &self.observation.view)
    }

    /// Returns true if `mistake` can change the answer to this case.
    pub fn can_affect(&self, mistake: &Mistake) -> bool {
        let misreading = mistake.misreading;
        let last = match &self.observation.view {
            View::Raw => Stage::Planes,
            View::Coef => Stage::Coefficients,
            View::Rgb(_) => Stage::Color,
        };
        let is_used = match misreading.change {
            Change::Edits(edits) => edits.iter().any(|edit| {
                edit.formula.is_used_by(self.case.format())
                    && (last == Stage::Coefficients || !edit.formula.is_only_for_final_values())
            }),
            _ => applies_to_file(misreading, &self.unused_sections),
        };
        is_used && misreading.stage() <= last && mistake.affects(self.case.format())
    }

    /// Returns true if the response can contradict `mistake`, whose answer agrees with it in this way.
    ///
    /// A decoder may compare the size of the file with what the header requires before it computes positions, and check texels that
    /// it does not show, so its refusal of a file that the reference refuses does not contradict an edited position or order of
    /// texels. Nor does a wrong image where the position is outside the data: a decoder may read there without noticing.
    pub fn can_contradict(&self, mistake: &Mistake, agreement: Agreement) -> bool {
        let is_refused = matches!(self.observation.response, Response::Rejected);
        let is_refusable = is_refused && !matches!(self.expected, Answer::Decoded(_));
        let is_outside = self.failed && agreement == Agreement::Contradiction;
        let is_position = edits_position(mistake);
        let is_neutral = is_refusable && (is_position || edits_order_of_texels(mistake))
            || is_outside && is_position;
        !is_neutral
    }

    /// Returns true if `mistake` can explain the response. A mistake that only changes values cannot explain a refusal.
    pub fn can_explain(&self, mistake: &Mistake) -> bool {
        let refused = !matches!(self.observation.response, Response::Image { .. });
        self.can_affect(mistake) && (!refused || mistake.misreading.may_refuse())
    }
}

/// Returns the map in `file` as a decoder with these mistakes reads it, and its reading. `decoded` is the map under `reading`, if it is
/// known.
fn read<'a>(
    mistakes: &[&Misreading],
    reading: Reading,
    file: &[u8],
    decoded: Option<&'a Ptm>,
) -> Result<(Cow<'a, Ptm>, Reading), Option<Error>> {
    let are_after_decoding = mistakes.iter().all(|mistake| is_after_decoding(mistake));
    if let Some(ptm) = decoded.filter(|_| are_after_decoding) {
        let reading = ptm_mistakes::apply_to_reading(mistakes, reading);
        return Ok((Cow::Borrowed(ptm), reading));
    }
    let (ptm, reading) = ptm_mistakes::read(mistakes, reading, file)?;
    Ok((Cow::Owned(ptm), reading))
}

/// Returns true if the mistake is an edit of the texel that is shown at a position of the image.
fn edits_order_of_texels(mistake: &Mistake) -> bool {
    let formulas = mistake.misreading.formulas();
    let orders = [
        Formula::StoredRow,
        Formula::StoredColumn,
        Formula::StoredTexel,
    ];
    formulas.iter().any(|formula| orders.contains(formula))
}

/// Returns true if the mistake is an edit of a position.
fn edits_position(mistake: &Mistake) -> bool {
    matches!(mistake.misreading.change, Change::Edits(_)) && mistake.misreading.may_refuse()
}
