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
use crate::types::{ColorMatrix, Format, Header, Planes, ScaleBias, Size};

/// Computes the final values of all texels: coefficients, and colors or chroma.
pub type Finals = fn(&ScaleBias, &Planes, &Reading) -> Vec<f64>;
/// Reads the indices of a map of the given size.
pub type ReadIndices = for<'a> fn(&LookupTable, Size, &mut Input<'a>) -> Result<IndexBlock<'a>>;
/// Computes the predictor of a plane from its reference.
pub type Predictor = for<'a> fn(reference: &'a [u8], &Step, Size, &Reading) -> Cow<'a, [u8]>;
/// Computes the planes, indexed by plane, from the residuals of their streams, which are in the order of decoding.
pub type Reconstruct = fn(&Coded, residuals: Vec<Vec<u8>>, &Reading) -> Result<Vec<Vec<u8>>>;
/// Returns the side information of a plane.
pub type SideInformation = for<'a> fn(&Coded<'a>, plane: usize) -> &'a [u8];
/// Reads the records of a block of side information at offset `at` of the file.
pub type ReadRecords = fn(block: &[u8], at: usize, texels: usize) -> Result<Vec<Record>>;

/// A way to interpret files: one function for each decision, in the order of the specification.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each field is documented at its function in SPEC
pub struct Reading {
    // 1.0
    pub light: fn(lu: f64, lv: f64) -> (f64, f64),
    pub polynomial: fn(a: &[f64], lu: f64, lv: f64) -> f64,
    // 2.4
    pub final_coefficient: fn(raw: u8, channel: usize, &ScaleBias) -> f64,
    pub finals: Finals,
    // 2.5
    pub entry_count: fn(&mut Input) -> Result<usize>,
    pub after_table: fn(&mut Input) -> Result<()>,
    // 2.6
    /// Returns Y as the matrix multiplies it.
    pub lum_luminance: fn(f64) -> f64,
    /// Returns Cr or Cb as the matrix multiplies it.
    pub lum_chroma: fn(stored: f64) -> f64,
    pub lum_vector: fn(y: f64, cr: f64, cb: f64) -> [f64; 3],
    pub lum_matrix: fn(&ColorMatrix) -> [[f64; 4]; 3],
    pub lum_translation: fn(f64) -> f64,
    // 2.7
    pub blocks: fn(Format) -> &'static [Block],
    pub stored_row: fn(&Header, row: usize) -> usize,
    /// Returns the luminance that is multiplied by the color.
    pub luminance: fn(f64) -> f64,
    pub modulate: fn(luminance: f64, color: f64) -> f64,
    pub clamp: fn(f64) -> f64,
    // 2.8
    pub indices: ReadIndices,
    pub index: fn(stored: &[u8]) -> usize,
    pub entry: fn(index: usize, entries: usize) -> Option<usize>,
    // 2.9.1–2.9.7
    pub plan: fn(&RawLists) -> Result<Plan>,
    // 2.9.2
    pub predictor: Predictor,
    pub invert: fn(plane: &mut [u8]),
    // 2.9.3
    pub motion_sign: fn(displacement: i64) -> i64,
    pub motion_vertical: fn(my: i64) -> i64,
    pub motion_half: fn(samples: [u8; 4]) -> u8,
    /// Returns the sample at (x, y). Readings differ only for positions outside the plane.
    pub motion_border: fn(plane: &[u8], Size, x: i64, y: i64) -> u8,
    // 2.9.5
    pub predict: fn(residuals: &mut [u8], predictor: &[u8]),
    pub predict_jpeg_ls: fn(residuals: &mut [u8], predictor: &[u8]),
    // 2.9.8
    pub stream: fn(&PlaneStream) -> Result<Vec<u8>>,
    pub reconstruct: Reconstruct,
    pub side_information: SideInformation,
    pub records: ReadRecords,
    pub correct: fn(plane: &mut [u8], &[Record]),
}
