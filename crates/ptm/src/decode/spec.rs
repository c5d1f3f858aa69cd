//! The reading of the reference.
//!
//! Each line of [`Reading::SPEC`] maps a decision to the function that implements its clause.

use super::{color_matrix, compressed, indices, lookup_table, planes, predict, texels};
use crate::evaluate::{self, Coefficients, RelitImage};
use crate::reading::Reading;
use crate::types::Ptm;

impl Ptm {
    /// Computes the final coefficients (clause 2.4/8).
    #[must_use]
    pub fn coefficients(&self) -> Coefficients {
        evaluate::compute_coefficients(&self.header.scale_bias, &self.planes, &Reading::SPEC)
    }
}

impl Coefficients {
    /// Computes the image under the light (`lu`, `lv`). Both coordinates range from −1 to 1; +u is right and +v is up.
    #[must_use]
    pub fn evaluate(&self, lu: f64, lv: f64) -> RelitImage {
        evaluate::evaluate(self, lu, lv, &Reading::SPEC)
    }
}

impl Reading {
    /// The reading of the reference: the text, with the rulings of `spec-cases/rulings.yaml` where the text is silent.
    pub const SPEC: Reading = Reading {
        // §1.0: the light, unchanged, and the polynomial
        light: evaluate::light,
        polynomial: evaluate::polynomial,
        // §2.4: (raw − bias) · scale, for coefficients only
        final_coefficient: evaluate::final_coefficient,
        finals: evaluate::final_values,
        // §2.5: the spellings of the count, and no separator after the table
        entry_count: lookup_table::read_entry_count,
        after_table: lookup_table::read_no_separator,
        // §2.6: M · (Y, Cr, Cb, 1)
        lum_luminance: evaluate::luminance,
        lum_chroma: evaluate::lum_chroma,
        lum_values: evaluate::lum_values,
        lum_vector: evaluate::lum_vector,
        lum_matrix: color_matrix::column_major_rows,
        lum_translation: evaluate::lum_translation,
        // §2.7: blocks, rows from the bottom; L · RGB / 255, clamped to 0 … 255 at the end
        blocks: texels::blocks,
        stored_row: texels::bottom_row_first,
        texel_color: evaluate::texel_color,
        luminance: evaluate::luminance,
        modulate: evaluate::modulate,
        clamp: evaluate::clamp,
        // §2.8: one byte or two, low byte first, and no index past the last entry
        indices: indices::read_indices,
        index: indices::little_endian,
        entry: indices::valid_entry,
        // §2.9.1 – 2.9.7: valid lists, and the plan that they describe
        plan: compressed::make_plan,
        // §2.9.2, §2.9.3: the predictor, which is the transformed reference
        predictor: predict::invert_then_displace,
        invert: predict::invert,
        motion_sign: predict::texel_to_predictor,
        motion_vertical: predict::y_along_stored_rows,
        motion_half: predict::mean_rounded_up,
        motion_border: predict::replicate_border,
        // §2.9.5: residual + predictor − 128, in the planes of both codecs
        predict: predict::predict,
        predict_jpeg_ls: predict::predict,
        // §2.9.8: streams, the order of prediction and correction, and records
        stream: planes::decode_stream,
        reconstruct: planes::reconstruct,
        side_information: planes::side_information,
        records: planes::parse_records,
        correct: planes::overwrite_samples,
    };
}
