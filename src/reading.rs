//! The decisions the text asks of its reader.
//!
//! [`Reading::SPEC`] names, for each, the function that stands with its clause in [`mod@crate::decode`] or
//! [`crate::evaluate`]. The flow calls the decision and never asks why it is so: another reading of an open point, or a
//! deliberate mistake, is another function in the same place and nothing else.

use crate::decode::{Input, color_matrix, indices, lookup_table, texels};
use crate::error::Result;
use crate::evaluate;
use crate::ptm::{ColorMatrix, Format, ScaleBias};

/// How a file is read: one decision for each thing the text asks, in the order of the text.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each is documented at the function SPEC names
pub struct Reading {
    // 1.0
    pub(crate) light: fn(lu: f64, lv: f64) -> (f64, f64),
    pub(crate) polynomial: fn(a: &[f64], lu: f64, lv: f64) -> f64,
    // 2.4
    pub(crate) final_coefficient: fn(raw: u8, channel: usize, &ScaleBias) -> f64,
    pub(crate) final_other: fn(raw: u8, channel: usize, &ScaleBias) -> f64,
    // 2.5
    pub(crate) entry_count: fn(&mut Input) -> Result<usize>,
    pub(crate) after_table: fn(&mut Input) -> Result<()>,
    // 2.6
    pub(crate) lum_vector: fn(y: f64, cr: f64, cb: f64) -> [f64; 3],
    pub(crate) lum_matrix: fn(&ColorMatrix) -> [[f64; 4]; 3],
    pub(crate) lum_translation: fn(f64) -> f64,
    // 2.7
    pub(crate) blocks: fn(Format) -> &'static [texels::Block],
    pub(crate) stored_row: fn(Format, part: usize, row: usize, height: usize) -> usize,
    pub(crate) modulate: fn(luminance: f64, color: f64) -> f64,
    pub(crate) clamp: fn(f64) -> f64,
    // 2.8
    pub(crate) index_width: fn(Format, entries: usize, stored: &[u8], texels: usize) -> usize,
    pub(crate) index: fn(stored: &[u8]) -> usize,
    pub(crate) entry: fn(index: usize, entries: usize) -> Option<usize>,
}

impl Reading {
    /// The reading of the reference: the text where it speaks, and the rulings of `spec-cases/rulings.yaml` where it does not.
    pub const SPEC: Reading = Reading {
        light: evaluate::light,
        polynomial: evaluate::polynomial,
        final_coefficient: evaluate::final_coefficient,
        final_other: evaluate::final_other,
        entry_count: lookup_table::entry_count,
        after_table: lookup_table::after_table,
        lum_vector: evaluate::lum_vector,
        lum_matrix: color_matrix::columns_first,
        lum_translation: evaluate::lum_translation,
        blocks: texels::blocks,
        stored_row: texels::bottom_row_first,
        modulate: evaluate::modulate,
        clamp: evaluate::clamp,
        index_width: indices::width,
        index: indices::little_endian,
        entry: indices::entry,
    };

    /// Ruling `lut-newline`, the other reading: one line end stands between the table and the indices.
    #[must_use]
    pub const fn with_newline_after_table(self) -> Reading {
        Reading {
            after_table: lookup_table::newline_after_table,
            ..self
        }
    }

    /// Ruling `lum-vector`, the other reading: the matrix multiplies (Cr, Y, Cb, 1), as the name of the color space runs.
    #[must_use]
    pub const fn with_cr_first(self) -> Reading {
        Reading {
            lum_vector: evaluate::lum_vector_cr_first,
            ..self
        }
    }

    /// Ruling `lum-major`, the other reading: the sixteen numbers stand row after row, as the text prints the matrix.
    #[must_use]
    pub const fn with_rows_first(self) -> Reading {
        Reading {
            lum_matrix: color_matrix::rows_first,
            ..self
        }
    }

    /// Ruling `lum-range`, the other reading: values and translation run from 0 to 1.
    #[must_use]
    pub const fn with_unit_range(self) -> Reading {
        Reading {
            lum_translation: evaluate::lum_translation_unit,
            ..self
        }
    }
}
