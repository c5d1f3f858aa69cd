//! The steps of decoding that a mistake can change.

use std::mem::discriminant;

use super::anatomy::{Anatomy, EditedFile};
use crate::error::Result;
use crate::formula::{Edit, Formula, Stage};
use crate::parts::{Block, Plan, PlaneStream, RawLists, Record};
use crate::ptm::{ColorMatrix, Format, Header, Ptm, ScaleBias};
use crate::reading::{
    Finals, Predictor, ReadIndices, ReadRecords, Reading, Reconstruct, SideInformation,
};

/// Steps by slug, in the order of `spec-cases/misreadings.yaml`. Returns `None` for the slugs of other sections.
pub(super) type Steps = fn(slug: &str) -> Option<At>;

/// The step that a mistake changes, and the function that replaces it.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)] // each decision is documented at its function in `Reading::SPEC`
pub enum At {
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
    /// The vector that the matrix multiplies, for decoders that put Y first or Cr first (ruling `lum-vector`).
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
    /// Changes both JPEG and JPEG-LS planes.
    Predict(fn(&mut [u8], &[u8])),
    Reconstruct(Reconstruct),
    Stream(fn(&PlaneStream) -> Result<Vec<u8>>),
    SideInformation(SideInformation),
    Records(ReadRecords),
    Correct(fn(&mut [u8], &[Record])),
}

impl At {
    /// Applies the mistake to `reading` if it is a decision of [`Reading`].
    pub(crate) fn change(self, reading: Reading) -> Reading {
        let mut other = reading;
        match self {
            At::Bytes(_) | At::Planes(_) | At::Edits(_) => {}
            At::Light(light) => other.light = light,
            At::Polynomial(polynomial) => other.polynomial = polynomial,
            At::FinalCoefficient(coefficient) => other.final_coefficient = coefficient,
            At::Finals(finals) => other.finals = finals,
            At::LumVector(y_first, cr_first) => {
                let [first, ..] = (reading.lum_vector)(1.0, 2.0, 3.0);
                other.lum_vector = if first == 2.0 { cr_first } else { y_first };
            }
            At::LumMatrix(matrix) => other.lum_matrix = matrix,
            At::LumTranslation(translation) => other.lum_translation = translation,
            At::Blocks(blocks) => other.blocks = blocks,
            At::StoredRow(row) => other.stored_row = row,
            At::Modulate(modulate) => other.modulate = modulate,
            At::Clamp(clamp) => other.clamp = clamp,
            At::Indices(indices) => other.indices = indices,
            At::Index(index) => other.index = index,
            At::Entry(entry) => other.entry = entry,
            At::Plan(plan) => other.plan = plan,
            At::Predictor(predictor) => other.predictor = predictor,
            At::Invert(invert) => other.invert = invert,
            At::MotionHalf(half) => other.motion_half = half,
            At::Predict(predict) => (other.predict, other.predict_jpeg_ls) = (predict, predict),
            At::Reconstruct(reconstruct) => other.reconstruct = reconstruct,
            At::Stream(stream) => other.stream = stream,
            At::SideInformation(side) => other.side_information = side,
            At::Records(records) => other.records = records,
            At::Correct(correct) => other.correct = correct,
        }
        other
    }

    /// Returns the stage of decoding that the mistake changes.
    #[must_use]
    pub fn stage(&self) -> Stage {
        match self {
            At::Edits(edits) => {
                let stages = edits.iter().map(|edit| edit.formula.stage());
                stages.min().unwrap_or(Stage::Color)
            }
            At::Bytes(_) => Stage::File,
            At::Planes(_) => Stage::Planes,
            At::FinalCoefficient(_) | At::Finals(_) => Stage::Coefficients,
            At::Light(_)
            | At::Polynomial(_)
            | At::LumVector(..)
            | At::LumMatrix(_)
            | At::LumTranslation(_)
            | At::Modulate(_)
            | At::Clamp(_) => Stage::Color,
            _ => Stage::Decoding,
        }
    }

    /// Returns true if the mistake may refuse a file. Other mistakes only change values.
    #[must_use]
    pub fn may_refuse(&self) -> bool {
        if let At::Edits(edits) = self {
            return edits.iter().any(|edit| edit.formula.may_refuse());
        }
        let only_changes_values = matches!(
            self,
            At::StoredRow(_)
                | At::Predictor(_)
                | At::Invert(_)
                | At::MotionHalf(_)
                | At::Predict(_)
                | At::SideInformation(_)
                | At::Correct(_)
        );
        self.stage() <= Stage::Decoding && !only_changes_values
    }

    /// Returns true if both mistakes change the same step: the bytes, the decoded map, a decision or a formula.
    #[must_use]
    pub fn changes_same_step(&self, other: &At) -> bool {
        let is_edited = matches!(self, At::Edits(_)) || matches!(other, At::Edits(_));
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
            At::Edits(edits) => edits.iter().map(|edit| edit.formula).collect(),
            At::Light(_) => vec![Formula::LightU, Formula::LightV],
            At::Polynomial(_) => vec![Formula::Polynomial],
            At::FinalCoefficient(_) => vec![Formula::FinalCoefficient],
            At::LumMatrix(_) => vec![Formula::MatrixRow],
            At::StoredRow(_) => vec![Formula::StoredRow],
            At::Modulate(_) => vec![Formula::Color],
            At::Clamp(_) => vec![Formula::Shown],
            At::Index(_) => vec![Formula::Index],
            At::Invert(_) => vec![Formula::Inversion],
            At::MotionHalf(_) => vec![Formula::MeanOfTwo, Formula::MeanOfFour],
            At::Predict(_) => vec![Formula::Plane],
            _ => Vec::new(),
        }
    }

    /// Returns true if the mistake changes a decision of [`Reading`]. A decoder makes each decision in only one way.
    #[must_use]
    pub const fn is_decision(&self) -> bool {
        !matches!(self, At::Bytes(_) | At::Planes(_))
    }
}
