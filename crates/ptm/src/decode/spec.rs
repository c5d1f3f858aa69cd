//! The reading of the reference, and equally correct alternative readings of the open questions.
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
        lum_vector: evaluate::lum_vector,
        lum_matrix: color_matrix::column_major_rows,
        lum_translation: evaluate::lum_translation,
        // §2.7: blocks, rows from the bottom; L · RGB / 255, clamped to 0 … 255 at the end
        blocks: texels::blocks,
        stored_row: texels::bottom_row_first,
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

    /// Returns this reading with one decision replaced.
    #[must_use]
    pub const fn with_alternative(mut self, alternative: Alternative) -> Reading {
        self.set(alternative);
        self
    }

    /// Replaces one decision with another correct reading of an open question.
    pub const fn set(&mut self, alternative: Alternative) {
        match alternative {
            Alternative::NewlineAfterTable => {
                self.after_table = lookup_table::read_newline_separator;
            }
            Alternative::ChromaCentered => self.lum_chroma = evaluate::centered_lum_chroma,
            Alternative::CrFirst => self.lum_vector = evaluate::lum_vector_cr_first,
            Alternative::RowsFirst => self.lum_matrix = color_matrix::row_major_rows,
            Alternative::UnitRange => self.lum_translation = evaluate::scaled_lum_translation,
            Alternative::LumClamped => self.lum_luminance = evaluate::clamped_lum_luminance,
            Alternative::LumLimited => self.lum_luminance = evaluate::clamped_luminance,
            Alternative::LuminanceClamped => self.luminance = evaluate::clamped_luminance,
            Alternative::MotionReversed => self.motion_sign = predict::predictor_to_texel,
            Alternative::MotionAgainstRows => self.motion_vertical = predict::y_against_stored_rows,
            Alternative::HalvesRoundedDown => self.motion_half = predict::mean_rounded_down,
            Alternative::HalvesToEven => self.motion_half = predict::mean_rounded_to_even,
            Alternative::HalvesRoundedUpTwice => {
                self.motion_half = predict::mean_rounded_up_twice;
            }
            Alternative::BorderMirrored => self.motion_border = predict::mirror_border,
            Alternative::BorderWrapped => self.motion_border = predict::wrap_border,
            Alternative::BorderBlack => self.motion_border = predict::black_border,
            Alternative::BorderGray => self.motion_border = predict::gray_border,
            Alternative::InversionAfterMotion => self.predictor = predict::displace_then_invert,
            Alternative::NoJpegLsOffset => self.predict_jpeg_ls = predict::predict_without_offset,
            Alternative::SideInformationOnlyIfLossy => {
                self.side_information = planes::side_information_if_lossy;
            }
        }
    }
}

/// Another correct reading of an open question: an alternative to a ruling of kind *choice* in `spec-cases/rulings.yaml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alternative {
    /// `lut-newline`: one line end separates the table from the indices.
    NewlineAfterTable,
    /// `lum-chroma`: the matrix multiplies Cr − 128 and Cb − 128.
    ChromaCentered,
    /// `lum-vector`: the matrix multiplies (Cr, Y, Cb, 1), in the order given by the name of the color space.
    CrFirst,
    /// `lum-major`: the sixteen numbers are in row-major order, as the matrix is printed in the specification.
    RowsFirst,
    /// `lum-range`: the values and the translation range from 0 to 1.
    UnitRange,
    /// `lum-clamp`: Y is limited to 0…255 before the matrix multiplies it.
    LumClamped,
    /// `lum-clamp`: Y is limited to 255 before the matrix multiplies it.
    LumLimited,
    /// `luminance-clamp`: luminance is limited to 255 before it is multiplied by the color.
    LuminanceClamped,
    /// `motion-sign`: a vector points from the predictor to the texel.
    MotionReversed,
    /// `motion-vertical`: y increases downward in the image, opposite to the order of stored rows.
    MotionAgainstRows,
    /// `motion-half`: means are rounded down.
    HalvesRoundedDown,
    /// `motion-half`: means are rounded to the nearest integer, and halves to the even one.
    HalvesToEven,
    /// `motion-half`: the mean of four is a mean along y of two means along x, and each is rounded up.
    HalvesRoundedUpTwice,
    /// `motion-border`: the plane is mirrored, and its edge sample is repeated.
    BorderMirrored,
    /// `motion-border`: coordinates wrap around to the other side of the plane.
    BorderWrapped,
    /// `motion-border`: samples outside the plane are 0.
    BorderBlack,
    /// `motion-border`: samples outside the plane are 128.
    BorderGray,
    /// `motion-inversion`: the reference is displaced first and then inverted.
    InversionAfterMotion,
    /// `jpeg-ls-offset`: residuals of JPEG-LS planes are added without subtracting 128.
    NoJpegLsOffset,
    /// `side-lossless`: records in lossless JPEG-LS files are skipped.
    SideInformationOnlyIfLossy,
}
