//! The steps of decoding that a mistake can change.

use std::mem::discriminant;

use super::anatomy::{Anatomy, EditedFile};
use crate::formula::{Edit, Formula, Stage};
use ptm::error::Result;
use ptm::parts::{Block, Plan, PlaneStream, RawLists, Record};
use ptm::reading::{
    Finals, Predictor, ReadIndices, ReadRecords, Reading, Reconstruct, SideInformation,
};
use ptm::{ColorMatrix, Format, Header, Ptm, ScaleBias};

/// Function that returns the step for a slug in one section, or `None` for other slugs. Slugs are in `misreadings.yaml` order.
pub type Steps = fn(slug: &str) -> Option<Hook>;

/// The step that a mistake changes, and the function that replaces it.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // each decision is documented at its function in `Reading::SPEC`
pub enum Hook {
    /// Changes the bytes of the file.
    Bytes(fn(&Anatomy) -> EditedFile),
    /// Changes the decoded map.
    Planes(fn(&mut Ptm)),
    /// Edits formulas.
    Edits(&'static [Edit]),
    // 1.0 (all variants from here are decisions of `Reading`, with the same types)
    Light(fn(f64, f64) -> (f64, f64)),
    Polynomial(fn(&[f64], f64, f64) -> f64),
    // 2.4
    FinalCoefficient(fn(u8, usize, &ScaleBias) -> f64),
    Finals(Finals),
    // 2.6
    /// Changes the vector that the matrix multiplies. Contains one function for decoders that put Y first and one for decoders
    /// that put Cr first (ruling `lum-vector`).
    LumVector(fn(f64, f64, f64) -> [f64; 3], fn(f64, f64, f64) -> [f64; 3]),
    LumMatrix(fn(&ColorMatrix) -> [[f64; 4]; 3]),
    LumTranslation(fn(f64) -> f64),
    // 2.7
    Blocks(fn(Format) -> &'static [Block]),
    StoredRow(fn(&Header, usize) -> usize),
    Modulate(fn(f64, f64) -> f64),
    Clamp(fn(f64) -> f64),
    // 2.8
    Indices(ReadIndices),
    Index(fn(&[u8]) -> usize),
    Entry(fn(usize, usize) -> Option<usize>),
    // 2.9
    Plan(fn(&RawLists) -> Result<Plan>),
    Predictor(Predictor),
    Invert(fn(&mut [u8])),
    MotionHalf(fn([u8; 4]) -> u8),
    /// Changes the sum of residual and predictor in both JPEG and JPEG-LS planes.
    Predict(fn(&mut [u8], &[u8])),
    Reconstruct(Reconstruct),
    Stream(fn(&PlaneStream) -> Result<Vec<u8>>),
    SideInformation(SideInformation),
    Records(ReadRecords),
    Correct(fn(&mut [u8], &[Record])),
}

impl Hook {
    /// Applies the mistake to `reading` if the mistake changes a decision of [`Reading`].
    pub(crate) fn apply_to(self, reading: Reading) -> Reading {
        let mut other = reading;
        match self {
            Hook::Bytes(_) | Hook::Planes(_) | Hook::Edits(_) => {}
            Hook::Light(light) => other.light = light,
            Hook::Polynomial(polynomial) => other.polynomial = polynomial,
            Hook::FinalCoefficient(coefficient) => other.final_coefficient = coefficient,
            Hook::Finals(finals) => other.finals = finals,
            Hook::LumVector(y_first, cr_first) => {
                let [first, ..] = (reading.lum_vector)(1.0, 2.0, 3.0);
                other.lum_vector = if first == 2.0 { cr_first } else { y_first };
            }
            Hook::LumMatrix(matrix) => other.lum_matrix = matrix,
            Hook::LumTranslation(translation) => other.lum_translation = translation,
            Hook::Blocks(blocks) => other.blocks = blocks,
            Hook::StoredRow(row) => other.stored_row = row,
            Hook::Modulate(modulate) => other.modulate = modulate,
            Hook::Clamp(clamp) => other.clamp = clamp,
            Hook::Indices(indices) => other.indices = indices,
            Hook::Index(index) => other.index = index,
            Hook::Entry(entry) => other.entry = entry,
            Hook::Plan(plan) => other.plan = plan,
            Hook::Predictor(predictor) => other.predictor = predictor,
            Hook::Invert(invert) => other.invert = invert,
            Hook::MotionHalf(half) => other.motion_half = half,
            Hook::Predict(predict) => (other.predict, other.predict_jpeg_ls) = (predict, predict),
            Hook::Reconstruct(reconstruct) => other.reconstruct = reconstruct,
            Hook::Stream(stream) => other.stream = stream,
            Hook::SideInformation(side) => other.side_information = side,
            Hook::Records(records) => other.records = records,
            Hook::Correct(correct) => other.correct = correct,
        }
        other
    }

    /// Returns the stage of decoding that the mistake changes.
    #[must_use]
    pub fn stage(&self) -> Stage {
        match self {
            Hook::Edits(edits) => {
                let stages = edits.iter().map(|edit| edit.formula.stage());
                stages.min().unwrap_or(Stage::Color)
            }
            Hook::Bytes(_) => Stage::File,
            Hook::Planes(_) => Stage::Planes,
            Hook::FinalCoefficient(_) | Hook::Finals(_) => Stage::Coefficients,
            Hook::Light(_)
            | Hook::Polynomial(_)
            | Hook::LumVector(..)
            | Hook::LumMatrix(_)
            | Hook::LumTranslation(_)
            | Hook::Modulate(_)
            | Hook::Clamp(_) => Stage::Color,
            _ => Stage::Decoding,
        }
    }

    /// Returns true if the mistake may cause a refusal. Other mistakes only change values.
    #[must_use]
    pub fn may_refuse(&self) -> bool {
        if let Hook::Edits(edits) = self {
            return edits.iter().any(|edit| edit.formula.may_refuse());
        }
        let only_changes_values = matches!(
            self,
            Hook::StoredRow(_)
                | Hook::Predictor(_)
                | Hook::Invert(_)
                | Hook::MotionHalf(_)
                | Hook::Predict(_)
                | Hook::SideInformation(_)
                | Hook::Correct(_)
        );
        self.stage() <= Stage::Decoding && !only_changes_values
    }

    /// Returns true if both mistakes change the same step: the bytes, the decoded map, a decision or a formula.
    #[must_use]
    pub fn changes_same_step(&self, other: &Hook) -> bool {
        let is_edited = matches!(self, Hook::Edits(_)) || matches!(other, Hook::Edits(_));
        match is_edited {
            // Two mistakes that edit different formulas change different steps.
            true => !self.formulas().is_empty() && self.formulas() == other.formulas(),
            false => discriminant(self) == discriminant(other),
        }
    }

    /// Returns the formulas that the mistake changes.
    #[must_use]
    pub fn formulas(&self) -> Vec<Formula> {
        match self {
            Hook::Edits(edits) => edits.iter().map(|edit| edit.formula).collect(),
            Hook::Light(_) => vec![Formula::LightU, Formula::LightV],
            Hook::Polynomial(_) => vec![Formula::Polynomial],
            Hook::FinalCoefficient(_) => vec![Formula::FinalCoefficient],
            Hook::LumMatrix(_) => vec![Formula::MatrixRow],
            Hook::StoredRow(_) => vec![Formula::StoredRow],
            Hook::Modulate(_) => vec![Formula::Color],
            Hook::Clamp(_) => vec![Formula::Rendering],
            Hook::Index(_) => vec![Formula::Index],
            Hook::Invert(_) => vec![Formula::Inversion],
            Hook::MotionHalf(_) => vec![Formula::MeanOfTwo, Formula::MeanOfFour],
            Hook::Predict(_) => vec![Formula::Plane],
            _ => Vec::new(),
        }
    }

    /// Returns true if the mistake changes a decision of [`Reading`] or edits formulas. A decoder makes each decision in only one
    /// way.
    #[must_use]
    pub const fn is_decision(&self) -> bool {
        !matches!(self, Hook::Bytes(_) | Hook::Planes(_))
    }
}
