//! Open questions of kind *choice*, and the dialect of a decoder.
//!
//! Each listed reading of a choice is right, and a decoder must use one of them throughout a run. So a file may have several
//! right images; the image that a decoder shows is evidence of its dialect.

use std::sync::Arc;

use crate::protocol::frame::View;
use crate::ptm::Format;
use crate::reading::Reading;
use crate::suite::cases::{Built, Case, Pictures};
use crate::suite::compare::Expected;
use crate::suite::dialect::{Axis, Choice, Choices};

/// All choices that can change an image, in the order of the text.
pub const CHOICES: Choices<Reading> = Choices(&[
    Choice {
        ruling: "lum-vector",
        readings: &[
            ("the matrix multiplies (Y, Cr, Cb, 1)", |r| r),
            (
                "the matrix multiplies (Cr, Y, Cb, 1)",
                Reading::with_cr_first,
            ),
        ],
    },
    Choice {
        ruling: "lum-major",
        readings: &[
            ("columns first", |r| r),
            ("rows first", Reading::with_rows_first),
        ],
    },
    Choice {
        ruling: "lum-range",
        readings: &[
            ("values and translation from 0 to 255", |r| r),
            (
                "values and translation from 0 to 1",
                Reading::with_unit_range,
            ),
        ],
    },
    Choice {
        ruling: "motion-inversion",
        readings: &[
            ("the reference is inverted, then displaced", |r| r),
            (
                "the reference is displaced, then inverted",
                Reading::with_inversion_after_motion,
            ),
        ],
    },
    Choice {
        ruling: "motion-sign",
        readings: &[
            ("vectors point from a texel to its predictor", |r| r),
            (
                "vectors point from the predictor to its texel",
                Reading::with_motion_minus,
            ),
        ],
    },
    Choice {
        ruling: "motion-vertical",
        readings: &[
            ("y grows along the rows as they are stored", |r| r),
            (
                "y grows against the rows as they are stored",
                Reading::with_motion_against_rows,
            ),
        ],
    },
    Choice {
        ruling: "motion-half",
        readings: &[
            ("means are rounded up at a half", |r| r),
            ("means are rounded down", Reading::with_halves_rounded_down),
        ],
    },
    Choice {
        ruling: "motion-border",
        readings: &[
            ("samples outside a plane repeat its edge", |r| r),
            (
                "samples outside a plane come from its opposite side",
                Reading::with_border_wrapped,
            ),
            ("outside a plane is 128", Reading::with_border_gray),
        ],
    },
    Choice {
        ruling: "jpeg-ls-offset",
        readings: &[
            ("JPEG-LS residuals are 128 more than the difference", |r| r),
            (
                "JPEG-LS residuals are the difference modulo 256",
                Reading::without_jpeg_ls_offset,
            ),
        ],
    },
    Choice {
        ruling: "side-lossless",
        readings: &[
            ("records of lossless files are applied", |r| r),
            (
                "records of lossless files are skipped",
                Reading::with_side_information_only_if_lossy,
            ),
        ],
    },
]);

/// Returns the choices that affect a case in a view; none in most cases.
///
/// A choice that is not listed here must have no effect on the case: its readings all make the same image.
#[must_use]
pub fn relevant_axes(case: &Case, view: &View) -> Vec<Axis> {
    match case.format() {
        Format::Lum if matches!(view, View::Rgb(_)) => {
            CHOICES.axes(&["lum-vector", "lum-major", "lum-range"])
        }
        _ => CHOICES.axes(&case.axes()),
    }
}

/// Returns the right image in every one of [`Choices::combinations`] of `axes`; that of the reference is known by construction.
///
/// They are stored with the file, because a suite is run repeatedly.
#[cfg_attr(
    not(unix),
    allow(dead_code, reason = "pictures are compared where decoders are run")
)]
pub(crate) fn pictures(built: &Built, view: &View, reference: Expected, axes: &[Axis]) -> Pictures {
    let mut known = built.pictures.lock().expect("no worker panics");
    let make = || {
        let others = CHOICES.combinations(axes).into_iter().skip(1);
        let others = others.map(|dialect| {
            Expected::from_file(&built.file, view, &CHOICES.apply(&dialect, Reading::SPEC))
        });
        Arc::new(std::iter::once(Some(reference)).chain(others).collect())
    };
    Arc::clone(known.entry(view.to_string()).or_insert_with(make))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dialect_index_round_trips() {
        let some = CHOICES.axes(&["motion-border", "lum-major", "side-lossless"]);
        let all = CHOICES.combinations(&some);
        assert_eq!(all.len(), 12);
        assert_eq!(all[0], CHOICES.reference());
        for (place, dialect) in all.iter().enumerate() {
            assert_eq!(CHOICES.place(dialect, &some), place);
        }
    }
}
