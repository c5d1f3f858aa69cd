//! Computes how a decoder that makes certain mistakes answers a case.

use std::borrow::Cow;

use super::mistake::{ChannelSubset, Mistake};
use super::tuning::{MAX_SAMPLE, MIN_SUPPORT, ROUNDING_SLACK};
use super::witness::{Witness, can_affect_file, equal_up_to_rounding, is_after_decoding};
use ptm::Ptm;
use ptm_mistakes::{Change, Misreading, Stage};
use ptm_suite::kit::parallel::map_in_parallel;
use ptm_suite::protocol::frame::{Answer, Samples, View};
use ptm_suite::verdicts::observation::Response;

/// Clauses about the positions in records of side information.
const POSITION_CLAUSES: [&str; 2] = ["2.9.8/5", "2.9.8/6"];

impl Witness<'_> {
    /// Returns the answer of a decoder that makes these `mistakes`.
    pub fn answer(&self, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let in_scope = mistakes
            .iter()
            .filter(|mistake| mistake.scope.contains(self));
        let (whole, partial): (Vec<&Mistake>, Vec<&Mistake>) = in_scope
            .copied()
            .partition(|mistake| mistake.channels == ChannelSubset::All);
        let mut misreadings: Vec<&Misreading> =
            whole.iter().map(|mistake| mistake.misreading).collect();
        let mut answer = self.answer_of_misreadings(&misreadings);
        for mistake in partial {
            misreadings.push(mistake.misreading);
            let changed = self.answer_of_misreadings(&misreadings);
            mistake.channels.replace(answer.to_mut(), &changed);
            misreadings.pop();
        }
        answer
    }

    fn misreadings_in_scope(&self, mistakes: &[&Mistake]) -> Vec<&'static Misreading> {
        let in_scope = mistakes
            .iter()
            .filter(|mistake| mistake.scope.contains(self));
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
        let (ptm, reading) = match misreadings.iter().all(|mistake| is_after_decoding(mistake)) {
            true => {
                let reading = ptm_mistakes::apply_to_reading(&misreadings, self.reading);
                (self.decoded().as_ref().ok()?.clone(), reading)
            }
            false => ptm_mistakes::read(&misreadings, self.reading, &self.built.file).ok()?,
        };
        let colors = ptm_mistakes::unrounded_values(&misreadings, &reading, &ptm, view);
        let Samples::U8(bytes) = &actual.samples else {
            return None;
        };
        let pairs = colors.iter().zip(bytes);
        let mut differences = pairs.map(|(color, &byte)| color - f64::from(byte));
        let is_rounded = |d: f64| d.abs() <= 0.5 + ROUNDING_SLACK;
        let is_truncated = |d: f64| (-ROUNDING_SLACK..1.0 + ROUNDING_SLACK).contains(&d);
        (differences.clone().all(is_rounded) || differences.all(is_truncated))
            .then(|| Answer::Decoded(actual.clone()))
    }

    /// Returns the image that a decoder with `mistakes` outputs for the stored values in `ptm`.
    pub fn render_stored_values(&self, mistakes: &[&Mistake], ptm: &Ptm) -> Answer {
        let misreadings = self.misreadings_in_scope(mistakes);
        let reading = ptm_mistakes::apply_to_reading(&misreadings, self.reading);
        ptm_mistakes::render(&misreadings, &reading, ptm, &self.observation.view)
    }

    /// Returns true if the decoder refused the file and the mistakes move a record outside its plane. The misreadings ignore such
    /// records, but many decoders refuse such files.
    pub fn refuses_positions(&self, mistakes: &[&Mistake]) -> bool {
        let mut readers = mistakes.iter().filter_map(|mistake| {
            let misreading = mistake.misreading;
            let reads_records = misreading.step.is_some_and(|step| step.name == "records");
            (reads_records && POSITION_CLAUSES.contains(&misreading.clause))
                .then(|| ptm_mistakes::apply_to_reading(&[misreading], self.reading).records)
        });
        if !matches!(self.observation.response, Response::Rejected) {
            return false;
        }
        let Some(model) = self.model() else {
            let mut clauses = self.case.clauses.iter();
            let is_about = clauses.any(|clause| POSITION_CLAUSES.contains(&&clause[..]));
            return readers.next().is_some() && is_about;
        };
        let bytes =
            |&(position, value): &(u32, u8)| position.to_be_bytes().into_iter().chain([value]);
        let planes = model.compressed.iter().flat_map(|coded| &coded.planes);
        let blocks = planes.map(|plane| plane.records.iter().flat_map(bytes).collect());
        let blocks: Vec<Vec<u8>> = blocks.collect();
        readers.any(|read| {
            let loses_records = |block: &Vec<u8>| {
                let records = read(block, 0, model.size.texels());
                records.is_ok_and(|records| records.len() * 5 < block.len())
            };
            blocks.iter().any(loses_records)
        })
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
            Change::Edits(edits) => edits
                .iter()
                .any(|edit| edit.formula.is_used_by(self.case.format())),
            _ => can_affect_file(misreading, &self.built.file),
        };
        is_used && misreading.stage() <= last && mistake.scope.contains(self)
    }

    /// Returns true if `mistake` can explain the response. A mistake that only changes values cannot explain a refusal.
    pub fn can_explain(&self, mistake: &Mistake) -> bool {
        let refused = !matches!(self.observation.response, Response::Image { .. });
        self.can_affect(mistake) && (!refused || mistake.misreading.may_refuse())
    }
}

/// Returns true if a single misreading reproduces the responses from which the decoder's choices were inferred.
pub(super) fn has_simple_explanation(
    witnesses: &[Witness],
    catalog: &[&'static Misreading],
    threads: usize,
) -> bool {
    let reproduces = |witness: &Witness, answer: &Answer| match witness.observation.response {
        Response::Rejected => *answer == Answer::Rejected,
        _ => *answer == witness.expected,
    };
    let is_informative =
        |witness: &&Witness| !witness.failed && !reproduces(witness, witness.correct_answer());
    let informative = witnesses.iter().filter(is_informative).take(MAX_SAMPLE);
    let informative: Vec<&Witness> = informative.collect();
    let mistakes: Vec<Mistake> = catalog.iter().copied().map(Mistake::unscoped).collect();
    let counts = map_in_parallel(mistakes.len(), threads, &|_, _| (), &|i| {
        let mistake = &mistakes[i];
        let is_reproduced = |witness: &&&Witness| {
            witness.can_affect(mistake) && reproduces(witness, &witness.answer(&[mistake]))
        };
        informative.iter().filter(is_reproduced).count()
    });
    let max = counts.into_iter().max().unwrap_or_default();
    max >= MIN_SUPPORT.min(informative.len())
}
