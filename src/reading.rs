//! The decisions that the specification leaves to a decoder.
//!
//! A [`Reading`] has one function for each decision. In [`Reading::SPEC`], the reading of the reference, each decision is the
//! function in [`mod@crate::decode`] or [`crate::evaluate`] that implements and explains the clause. The decoder calls only these
//! functions. [`Reading::with_alternative`] replaces functions in order to implement another reading of an open question.

use std::borrow::Cow;

use crate::error::Result;
use crate::input::Input;
use crate::parts::{
    Block, Coded, IndexBlock, LookupTable, Plan, PlaneStream, RawLists, Record, Step,
};
use crate::ptm::{ColorMatrix, Format, Header, Planes, ScaleBias, Size};

pub(crate) type Finals = fn(&ScaleBias, &Planes, &Reading) -> Vec<f64>;
pub(crate) type ReadIndices =
    for<'a> fn(&LookupTable, Size, &mut Input<'a>) -> Result<IndexBlock<'a>>;
pub(crate) type Predictor = for<'a> fn(reference: &'a [u8], &Step, Size, &Reading) -> Cow<'a, [u8]>;
pub(crate) type Reconstruct = fn(&Coded, residuals: Vec<Vec<u8>>, &Reading) -> Result<Vec<Vec<u8>>>;
pub(crate) type SideInformation = for<'a> fn(&Coded<'a>, plane: usize) -> &'a [u8];
pub(crate) type ReadRecords = fn(block: &[u8], at: usize, texels: usize) -> Result<Vec<Record>>;

/// A way to interpret files: one function for each decision, in the order of the specification.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each field is documented at its function in SPEC
pub struct Reading {
    // 1.0
    pub(crate) light: fn(lu: f64, lv: f64) -> (f64, f64),
    pub(crate) polynomial: fn(a: &[f64], lu: f64, lv: f64) -> f64,
    // 2.4
    pub(crate) final_coefficient: fn(raw: u8, channel: usize, &ScaleBias) -> f64,
    pub(crate) finals: Finals,
    // 2.5
    pub(crate) entry_count: fn(&mut Input) -> Result<usize>,
    pub(crate) after_table: fn(&mut Input) -> Result<()>,
    // 2.6
    /// Returns Y as the matrix multiplies it.
    pub(crate) lum_luminance: fn(f64) -> f64,
    /// Returns Cr or Cb as the matrix multiplies it.
    pub(crate) lum_chroma: fn(stored: f64) -> f64,
    pub(crate) lum_vector: fn(y: f64, cr: f64, cb: f64) -> [f64; 3],
    pub(crate) lum_matrix: fn(&ColorMatrix) -> [[f64; 4]; 3],
    pub(crate) lum_translation: fn(f64) -> f64,
    // 2.7
    pub(crate) blocks: fn(Format) -> &'static [Block],
    pub(crate) stored_row: fn(&Header, row: usize) -> usize,
    /// Returns the luminance that is multiplied by the color.
    pub(crate) luminance: fn(f64) -> f64,
    pub(crate) modulate: fn(luminance: f64, color: f64) -> f64,
    pub(crate) clamp: fn(f64) -> f64,
    // 2.8
    pub(crate) indices: ReadIndices,
    pub(crate) index: fn(stored: &[u8]) -> usize,
    pub(crate) entry: fn(index: usize, entries: usize) -> Option<usize>,
    // 2.9.1–2.9.7
    pub(crate) plan: fn(&RawLists) -> Result<Plan>,
    // 2.9.2
    pub(crate) predictor: Predictor,
    pub(crate) invert: fn(plane: &mut [u8]),
    // 2.9.3
    pub(crate) motion_sign: fn(displacement: i64) -> i64,
    pub(crate) motion_vertical: fn(my: i64) -> i64,
    pub(crate) motion_half: fn(samples: [u8; 4]) -> u8,
    /// Returns the sample at (x, y). Readings differ only for positions outside the plane.
    pub(crate) motion_border: fn(plane: &[u8], Size, x: i64, y: i64) -> u8,
    // 2.9.5
    pub(crate) predict: fn(residuals: &mut [u8], predictor: &[u8]),
    pub(crate) predict_jpeg_ls: fn(residuals: &mut [u8], predictor: &[u8]),
    // 2.9.8
    pub(crate) stream: fn(&PlaneStream) -> Result<Vec<u8>>,
    pub(crate) reconstruct: Reconstruct,
    pub(crate) side_information: SideInformation,
    pub(crate) records: ReadRecords,
    pub(crate) correct: fn(plane: &mut [u8], &[Record]),
}
