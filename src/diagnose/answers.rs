//! The answer of a decoder that makes some mistakes to one file.

use std::borrow::Cow;

use super::mistake::{ChannelSubset, Mistake};
use super::tuning::{MAX_SAMPLE, MIN_SUPPORT, ROUNDING_SLACK};
use super::witness::{Witness, alike, applies, is_after_decoding};
use crate::kit::parallel::in_parallel;
use crate::misreadings::{self, At, Misreading, Stage};
use crate::protocol::frame::{Answer, Samples, View};
use crate::ptm::Ptm;
use crate::session::observation::Response;

/// The clauses about the position of a record.
const POSITIONS: [&str; 2] = ["2.9.8/5", "2.9.8/6"];

impl Witness<'_> {
    /// Returns the answer of a decoder with these mistakes.
    pub fn answer(&self, mistakes: &[&Mistake]) -> Cow<'_, Answer> {
        let made = mistakes.iter().filter(|mistake| mistake.scope.holds(self));
        let (whole, in_part): (Vec<&Mistake>, Vec<&Mistake>) = made
            .copied()
            .partition(|mistake| mistake.channels == ChannelSubset::All);
        let mut misreadings: Vec<&Misreading> =
            whole.iter().map(|mistake| mistake.misreading).collect();
        let mut answer = self.answer_of_listed(&misreadings);
        for mistake in in_part {
            misreadings.push(mistake.misreading);
            let with = self.answer_of_listed(&misreadings);
            mistake.channels.replace(answer.to_mut(), &with);
            misreadings.pop();
        }
        answer
    }

    /// Returns the response if it is the colors that these mistakes produce, rounded or truncated to bytes. This comparison is
    /// stricter than the tolerance, so it also separates mistakes with small effects.
    pub fn shown_by(&self, mistakes: &[&Mistake], made: &Answer) -> Option<Answer> {
        let (View::Rgb(light), Some(shown), Answer::Decoded(made)) =
            (&self.observation.view, self.shown(), made)
        else {
            return None;
        };
        let is_in_part = |mistake: &&Mistake| mistake.channels != ChannelSubset::All;
        if !self.failed || mistakes.iter().any(is_in_part) || !alike(shown, made) {
            return None;
        }
        let made = mistakes.iter().filter(|mistake| mistake.scope.holds(self));
        let made: Vec<&Misreading> = made.map(|mistake| mistake.misreading).collect();
        let (ptm, reading) = match made.iter().all(|mistake| is_after_decoding(mistake)) {
            true => {
                let reading = misreadings::misread(&made, self.reading);
                (self.decoded().as_ref().ok()?.clone(), reading)
            }
            false => misreadings::read(&made, self.reading, &self.built.file).ok()?,
        };
        let colors = misreadings::colors(&made, &reading, &ptm, light);
        let Samples::U8(bytes) = &shown.samples else {
            return None;
        };
        let is_all = |is: fn(f64, f64) -> bool| {
            colors
                .iter()
                .zip(bytes)
                .all(|(&color, &byte)| is(color, f64::from(byte)))
        };
        let is_rounded = is_all(|color, byte| (color - byte).abs() <= 0.5 + ROUNDING_SLACK);
        let is_cut_off = || {
            is_all(|color, byte| (-ROUNDING_SLACK..1.0 + ROUNDING_SLACK).contains(&(color - byte)))
        };
        (is_rounded || is_cut_off()).then(|| Answer::Decoded(shown.clone()))
    }

    /// Returns the image that a decoder with these mistakes shows for stored values.
    pub fn show(&self, mistakes: &[&Mistake], ptm: &Ptm) -> Answer {
        let made = mistakes.iter().filter(|mistake| mistake.scope.holds(self));
        let made: Vec<&Misreading> = made.map(|mistake| mistake.misreading).collect();
        let reading = misreadings::misread(&made, self.reading);
        misreadings::show(&made, &reading, ptm, &self.observation.view)
    }

    /// Returns true if the file was refused and these mistakes move a record outside its plane. The catalog ignores these records;
    /// many decoders refuse them.
    pub fn refuses_positions(&self, mistakes: &[&Mistake]) -> bool {
        let mut readers = mistakes.iter().filter_map(|mistake| {
            let misreading = mistake.misreading;
            match misreading.at {
                At::Records(read) if POSITIONS.contains(&misreading.clause) => Some(read),
                _ => None,
            }
        });
        if !matches!(self.observation.response, Response::Rejected) {
            return false;
        }
        let Some(model) = self.model() else {
            let clauses = &self.case.clauses;
            return readers.next().is_some()
                && clauses
                    .iter()
                    .any(|clause| POSITIONS.contains(&&clause[..]));
        };
        let bytes =
            |&(position, value): &(u32, u8)| position.to_be_bytes().into_iter().chain([value]);
        let planes = model.compressed.iter().flat_map(|coded| &coded.planes);
        let blocks = planes.map(|plane| plane.records.iter().flat_map(bytes).collect());
        let blocks: Vec<Vec<u8>> = blocks.collect();
        readers.any(|read| {
            let is_fewer = |block: &Vec<u8>| {
                let records = read(block, 0, model.size.texels());
                records.is_ok_and(|records| records.len() * 5 < block.len())
            };
            blocks.iter().any(is_fewer)
        })
    }

    /// Returns true if the mistake can change the answer.
    pub fn concerns(&self, mistake: &Mistake) -> bool {
        let misreading = mistake.misreading;
        let last = match &self.observation.view {
            View::Raw => Stage::Planes,
            View::Coef => Stage::Coefficients,
            View::Rgb(_) => Stage::Color,
        };
        let is_used = match misreading.at {
            At::Edits(edits) => edits
                .iter()
                .any(|edit| edit.formula.is_used_by(self.case.format())),
            _ => applies(misreading, &self.built.file),
        };
        is_used && misreading.at.stage() <= last && mistake.scope.holds(self)
    }

    /// Returns true if the mistake can explain the response. A mistake that only changes values explains no refusal.
    pub fn could_be(&self, mistake: &Mistake) -> bool {
        let refused = !matches!(self.observation.response, Response::Image { .. });
        self.concerns(mistake) && (!refused || mistake.misreading.at.may_refuse())
    }
}

/// Returns true if a misreading gives the responses that show the decoder's reading of the open questions.
pub(super) fn could_be_misread(witnesses: &[Witness], threads: usize) -> bool {
    let gives = |witness: &Witness, answer: &Answer| match witness.observation.response {
        Response::Rejected => *answer == Answer::Rejected,
        _ => *answer == witness.right,
    };
    let is_telling = |witness: &&Witness| !witness.failed && !gives(witness, witness.unmistaken());
    let telling = witnesses.iter().filter(is_telling).take(MAX_SAMPLE);
    let telling: Vec<&Witness> = telling.collect();
    let mistakes: Vec<Mistake> = misreadings::all().map(Mistake::everywhere).collect();
    let reproduced = in_parallel(mistakes.len(), threads, &|_, _| (), &|at| {
        let mistake = &mistakes[at];
        let is_reproduced = |witness: &&&Witness| {
            witness.concerns(mistake) && gives(witness, &witness.answer(&[mistake]))
        };
        telling.iter().filter(is_reproduced).count()
    });
    let most = reproduced.into_iter().max().unwrap_or_default();
    most >= MIN_SUPPORT.min(telling.len())
}
