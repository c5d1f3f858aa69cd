//! The reading of the reference, and the other readings of the open points.
//!
//! Each line of [`Reading::SPEC`] maps a decision to the function that implements its clause. Each
//! constructor after it exchanges one of them for another reading of a ruling of kind *choice* in
//! `spec-cases/rulings.yaml`. All readings are equally correct.

use super::{color_matrix, compressed, indices, lookup_table, planes, predict, texels};
use crate::evaluate::{self, Coefficients, Picture};
use crate::ptm::Ptm;
use crate::reading::Reading;

impl Ptm {
    /// Returns the final coefficients (clause 2.4/8).
    #[must_use]
    pub fn coefficients(&self) -> Coefficients {
        evaluate::apply(&self.header.scale_bias, &self.planes, &Reading::SPEC)
    }
}

impl Coefficients {
    /// Returns the image under the light (`lu`, `lv`), each from −1 to 1: +u to the right, +v up.
    #[must_use]
    pub fn evaluate(&self, lu: f64, lv: f64) -> Picture {
        evaluate::evaluate(self, lu, lv, &Reading::SPEC)
    }
}

impl Reading {
    /// The reading of the reference: the text, and the rulings of `spec-cases/rulings.yaml` where the text is silent.
    pub const SPEC: Reading = Reading {
        // §1.0: the light, unchanged, and the polynomial in it
        light: evaluate::light,
        polynomial: evaluate::polynomial,
        // §2.4: (raw − bias) · scale, for coefficients only
        final_coefficient: evaluate::final_coefficient,
        finals: evaluate::finals,
        // §2.5: the spelling of the count; nothing follows the table
        entry_count: lookup_table::entry_count,
        after_table: lookup_table::after_table,
        // §2.6: M · (Y, Cr, Cb, 1)
        lum_vector: evaluate::lum_vector,
        lum_matrix: color_matrix::columns_first,
        lum_translation: evaluate::lum_translation,
        // §2.7: blocks, rows from the bottom; L · RGB / 255, clamped to 0 … 255 at the end
        blocks: texels::blocks,
        stored_row: texels::bottom_row_first,
        modulate: evaluate::modulate,
        clamp: evaluate::clamp,
        // §2.8: one byte or two, low byte first, and no index past the last entry
        indices: indices::one_or_two_bytes,
        index: indices::little_endian,
        entry: indices::entry,
        // §2.9.1 – 2.9.7: valid lists, and the plan that they describe
        plan: compressed::plan,
        // §2.9.2, §2.9.3: the predictor, a transformed reference
        predictor: predict::inverted_then_moved,
        invert: predict::invert,
        motion_sign: predict::sign_plus,
        motion_vertical: predict::along_stored_rows,
        motion_half: predict::mean_half_up,
        motion_border: predict::border_edge,
        // §2.9.5: residual + predictor − 128, in the planes of both codecs
        predict: predict::predict,
        predict_jpeg_ls: predict::predict,
        // §2.9.8: streams, the order of prediction and correction, and what a record is
        stream: planes::stream,
        reconstruct: planes::reconstruct,
        side_information: planes::side_information,
        records: planes::records,
        correct: planes::overwrite,
    };

    /// Ruling `lut-newline`, the other reading: one line end separates the table from the indices.
    #[must_use]
    pub const fn with_newline_after_table(self) -> Reading {
        Reading {
            after_table: lookup_table::newline_after_table,
            ..self
        }
    }

    /// Ruling `lum-vector`, the other reading: the matrix multiplies (Cr, Y, Cb, 1), the order in the color space's name.
    #[must_use]
    pub const fn with_cr_first(self) -> Reading {
        Reading {
            lum_vector: evaluate::lum_vector_cr_first,
            ..self
        }
    }

    /// Ruling `lum-major`, the other reading: the sixteen numbers are row-major, as the text prints the matrix.
    #[must_use]
    pub const fn with_rows_first(self) -> Reading {
        Reading {
            lum_matrix: color_matrix::rows_first,
            ..self
        }
    }

    /// Ruling `lum-range`, the other reading: values and translation range from 0 to 1.
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

    /// Ruling `motion-vertical`, the other reading: y grows downward in the image, against the order of the stored rows.
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
            motion_half: predict::mean_half_down,
            ..self
        }
    }

    /// Ruling `motion-border`, another reading: outside the plane it wraps around to the other side.
    #[must_use]
    pub const fn with_border_wrapped(self) -> Reading {
        Reading {
            motion_border: predict::border_wrapped,
            ..self
        }
    }

    /// Ruling `motion-border`, a third reading: samples outside the plane are 128.
    #[must_use]
    pub const fn with_border_gray(self) -> Reading {
        Reading {
            motion_border: predict::border_gray,
            ..self
        }
    }

    /// Ruling `motion-inversion`, the other reading: the reference is displaced first and then inverted.
    #[must_use]
    pub const fn with_inversion_after_motion(self) -> Reading {
        Reading {
            predictor: predict::moved_then_inverted,
            ..self
        }
    }

    /// Ruling `jpeg-ls-offset`, the other reading: residuals of JPEG-LS planes are added without subtracting 128.
    #[must_use]
    pub const fn without_jpeg_ls_offset(self) -> Reading {
        Reading {
            predict_jpeg_ls: predict::predict_without_offset,
            ..self
        }
    }

    /// Ruling `side-lossless`, the other reading: records of lossless JPEG-LS files are skipped.
    #[must_use]
    pub const fn with_side_information_only_if_lossy(self) -> Reading {
        Reading {
            side_information: planes::side_information_if_lossy,
            ..self
        }
    }
}
