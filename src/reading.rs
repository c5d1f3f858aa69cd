//! The decisions the text asks of its reader.
//!
//! [`Reading::SPEC`] names, for each, the function that stands with its clause in [`mod@crate::decode`] or
//! [`crate::evaluate`]. The flow calls the decision and never asks why it is so: another reading of an open point, or a
//! deliberate mistake, is another function in the same place and nothing else.

use std::borrow::Cow;

use crate::codec;
use crate::decode::compressed::{self, Plan, RawLists, Step};
use crate::decode::planes::{self, Coded};
use crate::decode::{Input, color_matrix, indices, lookup_table, predict, texels};
use crate::error::Result;
use crate::evaluate;
use crate::ptm::{ColorMatrix, Format, ScaleBias, Size};

type Predictor = for<'a> fn(reference: &'a [u8], &Step, Size, &Reading) -> Cow<'a, [u8]>;
type Stream =
    fn(Format, plane: usize, stream: &[u8], Size) -> std::result::Result<Vec<u8>, codec::Error>;
type Records = fn(block: &[u8], at: usize, texels: usize) -> Result<Vec<(u32, u8)>>;

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
    // 2.9.1–2.9.7
    pub(crate) plan: fn(&RawLists) -> Result<Plan>,
    // 2.9.2
    pub(crate) predictor: Predictor,
    pub(crate) invert: fn(plane: &mut [u8]),
    // 2.9.3
    pub(crate) motion_sign: fn(displacement: i64) -> i64,
    pub(crate) motion_vertical: fn(my: i64) -> i64,
    pub(crate) motion_half: fn(samples: [u8; 4]) -> u8,
    pub(crate) motion_border: fn(at: i64, length: u32) -> Option<usize>,
    // 2.9.5
    pub(crate) predict: fn(Format, residuals: &mut [u8], predictor: &[u8]),
    // 2.9.8
    pub(crate) reconstruct: fn(&Coded, &Reading) -> Result<Vec<Vec<u8>>>,
    pub(crate) stream: Stream,
    pub(crate) side_counts: fn(Format, parameter: i64) -> bool,
    pub(crate) records: Records,
    pub(crate) mend: fn(plane: &mut [u8], records: &[(u32, u8)]),
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
        plan: compressed::plan,
        predictor: predict::inverted_then_moved,
        invert: predict::invert,
        motion_sign: predict::sign_plus,
        motion_vertical: predict::along_stored_rows,
        motion_half: predict::half_up,
        motion_border: predict::border_edge,
        predict: predict::predict,
        #[cfg(not(feature = "parallel"))]
        reconstruct: planes::reconstruct,
        #[cfg(feature = "parallel")]
        reconstruct: planes::reconstruct_in_parallel,
        stream: planes::stream,
        side_counts: planes::side_always,
        records: planes::records,
        mend: planes::overwrite,
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

    /// Ruling `motion-sign`, the other reading: a vector points from the predictor to the texel.
    #[must_use]
    pub const fn with_motion_minus(self) -> Reading {
        Reading {
            motion_sign: predict::sign_minus,
            ..self
        }
    }

    /// Ruling `motion-vertical`, the other reading: y grows downwards in the picture, against the rows as they are stored.
    #[must_use]
    pub const fn with_motion_against_rows(self) -> Reading {
        Reading {
            motion_vertical: predict::against_stored_rows,
            ..self
        }
    }

    /// Ruling `motion-half`, the other reading: means are rounded down.
    #[must_use]
    pub const fn with_halves_rounded_down(self) -> Reading {
        Reading {
            motion_half: predict::half_down,
            ..self
        }
    }

    /// Ruling `motion-border`, another reading: outside the plane it begins again at the other side.
    #[must_use]
    pub const fn with_border_wrapped(self) -> Reading {
        Reading {
            motion_border: predict::border_wrapped,
            ..self
        }
    }

    /// Ruling `motion-border`, a third reading: outside the plane is 128.
    #[must_use]
    pub const fn with_border_grey(self) -> Reading {
        Reading {
            motion_border: predict::border_grey,
            ..self
        }
    }

    /// Ruling `motion-inversion`, the other reading: the reference is displaced first and inverted then.
    #[must_use]
    pub const fn with_inversion_after_motion(self) -> Reading {
        Reading {
            predictor: predict::moved_then_inverted,
            ..self
        }
    }

    /// Ruling `jpeg-ls-offset`, the other reading: residuals of JPEG-LS planes are added without taking 128 off.
    #[must_use]
    pub const fn without_jpeg_ls_offset(self) -> Reading {
        Reading {
            predict: predict::predict_jpeg_ls_without_offset,
            ..self
        }
    }

    /// Ruling `side-lossless`, the other reading: records of lossless JPEG-LS files are stepped over.
    #[must_use]
    pub const fn with_side_information_only_if_lossy(self) -> Reading {
        Reading {
            side_counts: planes::side_if_lossy,
            ..self
        }
    }
}
