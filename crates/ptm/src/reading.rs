//! The decisions that the specification leaves to a decoder.
//!
//! A [`Reading`] has one function for each decision. In [`Reading::SPEC`], the reading of the reference, each decision is the
//! function in [`mod@crate::decode`] or [`crate::evaluate`] that implements and explains the clause. The decoder calls only these
//! functions. To change a decision, assign another function to its field: an alternative, which stands beside the function of the
//! reference and answers an open question differently, or a mistake.
//!
//! ```
//! use ptm::decode::predict;
//! use ptm::{Limits, Reading, decode_as};
//!
//! let rounding_down = Reading { motion_half: predict::mean_rounded_down, ..Reading::SPEC };
//! # let file = b"PTM_1.2\nPTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\n\x01\x02\x03\x04\x05\x06rgb";
//! let ptm = decode_as(file, &rounding_down, &Limits::default())?;
//! # Ok::<(), ptm::Error>(())
//! ```

use std::borrow::Cow;

use crate::error::Result;
use crate::input::Input;
use crate::parts::{
    Block, Coded, IndexBlock, LookupTable, Plan, PlaneStream, RawLists, Record, Step,
};
use crate::types::{ColorMatrix, Format, Header, Planes, ScaleBias, Shape, Size};

/// A way to interpret files: one function for each decision, in the order of the specification.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each field is documented at its function in SPEC
pub struct Reading {
    // 1.0
    pub light: fn(lu: f64, lv: f64) -> (f64, f64),
    pub polynomial: fn(a: &[f64], lu: f64, lv: f64) -> f64,
    // 2.4
    pub final_coefficient: fn(raw: u8, channel: usize, &ScaleBias) -> f64,
    pub finals: fn(&ScaleBias, &Planes, &Reading) -> Vec<f64>,
    // 2.5
    pub entry_count: fn(&mut Input) -> Result<usize>,
    pub after_table: fn(&mut Input) -> Result<()>,
    // 2.6
    /// Returns Y as the matrix multiplies it.
    pub lum_luminance: fn(f64) -> f64,
    /// Returns Cr or Cb as the matrix multiplies it.
    pub lum_chroma: fn(stored: f64) -> f64,
    pub lum_values: fn(y: f64, cr: f64, cb: f64) -> [f64; 3],
    pub lum_vector: fn(y: f64, cr: f64, cb: f64) -> [f64; 3],
    pub lum_matrix: fn(&ColorMatrix) -> [[f64; 4]; 3],
    pub lum_translation: fn(f64) -> f64,
    // 2.7
    pub blocks: fn(Format) -> &'static [Block],
    pub stored_row: fn(&Header, row: usize) -> usize,
    pub texel_color: fn(&Shape, texel: &[f64], light: (f64, f64), &Reading) -> [f64; 3],
    /// Returns the luminance that is multiplied by the color.
    pub luminance: fn(f64) -> f64,
    pub modulate: fn(luminance: f64, color: f64) -> f64,
    pub clamp: fn(f64) -> f64,
    // 2.8
    pub indices: for<'a> fn(&LookupTable, Size, &mut Input<'a>) -> Result<IndexBlock<'a>>,
    pub index: fn(stored: &[u8]) -> usize,
    pub entry: fn(index: usize, entries: usize) -> Option<usize>,
    // 2.9.1–2.9.7
    pub plan: fn(&RawLists) -> Result<Plan>,
    // 2.9.2
    pub predictor: for<'a> fn(reference: &'a [u8], &Step, Size, &Reading) -> Cow<'a, [u8]>,
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
    pub reconstruct: fn(&Coded, residuals: Vec<Vec<u8>>, &Reading) -> Result<Vec<Vec<u8>>>,
    pub side_information: for<'a> fn(&Coded<'a>, plane: usize) -> &'a [u8],
    pub records: fn(block: &[u8], at: usize, texels: usize) -> Result<Vec<Record>>,
    pub correct: fn(plane: &mut [u8], &[Record]),
}

impl Reading {
    /// Returns the name of each decision with the address of its function, in the order of the fields.
    #[must_use]
    pub fn decisions(&self) -> Vec<(&'static str, *const ())> {
        macro_rules! addresses {
            ($($name:ident)+) => {{
                // The pattern has no `..`, so that no field can be forgotten.
                let Reading { $($name),+ } = *self;
                vec![$((stringify!($name), $name as *const ())),+]
            }};
        }
        addresses! {
            light polynomial
            final_coefficient finals
            entry_count after_table
            lum_luminance lum_chroma lum_values lum_vector lum_matrix lum_translation
            blocks stored_row texel_color luminance modulate clamp
            indices index entry
            plan
            predictor invert
            motion_sign motion_vertical motion_half motion_border
            predict predict_jpeg_ls
            stream reconstruct side_information records correct
        }
    }

    /// Returns the names of the decisions for which the two readings have different functions.
    #[must_use]
    pub fn differences(&self, other: &Reading) -> Vec<&'static str> {
        let pairs = self.decisions().into_iter().zip(other.decisions());
        let different = pairs.filter(|(one, other)| one.1 != other.1);
        different.map(|((name, _), _)| name).collect()
    }
}
