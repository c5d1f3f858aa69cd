//! Open questions of kind *choice* about PTM files, and the dialect of a decoder. Each listed reading of a choice is correct, and
//! a decoder must use one of them throughout a run. A file may therefore have several correct images; the image that a decoder
//! outputs is evidence of its dialect.

use std::sync::Arc;

use crate::decode::Alternative::{
    BorderGray, BorderWrapped, CrFirst, HalvesRoundedDown, InversionAfterMotion, MotionAgainstRows,
    MotionReversed, NoJpegLsOffset, RowsFirst, SideInformationOnlyIfLossy, UnitRange,
};
use crate::protocol::frame::View;
use crate::ptm::Format;
use crate::reading::Reading;
use crate::suite::cases::{Built, Case, DialectImages};
use crate::suite::compare::Expected;
use crate::suite::dialect::{Axis, Choice, Choices, Readings};

const LUM_VECTOR: Readings<Reading> = &[
    ("the matrix multiplies (Y, Cr, Cb, 1)", |_| {}),
    ("the matrix multiplies (Cr, Y, Cb, 1)", |r| r.set(CrFirst)),
];
const LUM_MAJOR: Readings<Reading> = &[
    ("columns first", |_| {}),
    ("rows first", |r| r.set(RowsFirst)),
];
const LUM_RANGE: Readings<Reading> = &[
    ("values and translation from 0 to 255", |_| {}),
    ("values and translation from 0 to 1", |r| r.set(UnitRange)),
];
const MOTION_INVERSION: Readings<Reading> = &[
    ("the reference is inverted, then displaced", |_| {}),
    ("the reference is displaced, then inverted", |r| {
        r.set(InversionAfterMotion);
    }),
];
const MOTION_SIGN: Readings<Reading> = &[
    ("vectors point from a texel to its predictor", |_| {}),
    ("vectors point from the predictor to its texel", |r| {
        r.set(MotionReversed);
    }),
];
const MOTION_VERTICAL: Readings<Reading> = &[
    ("y increases in the order of the stored rows", |_| {}),
    ("y decreases in the order of the stored rows", |r| {
        r.set(MotionAgainstRows);
    }),
];
const MOTION_HALF: Readings<Reading> = &[
    ("means that end in one half are rounded up", |_| {}),
    ("means are rounded down", |r| r.set(HalvesRoundedDown)),
];
const MOTION_BORDER: Readings<Reading> = &[
    ("samples outside a plane repeat its edge", |_| {}),
    ("samples outside a plane come from its opposite side", |r| {
        r.set(BorderWrapped);
    }),
    ("samples outside a plane are 128", |r| r.set(BorderGray)),
];
const JPEG_LS_OFFSET: Readings<Reading> = &[
    ("JPEG-LS residuals are 128 more than the difference", |_| {}),
    ("JPEG-LS residuals are the difference modulo 256", |r| {
        r.set(NoJpegLsOffset);
    }),
];
const SIDE_LOSSLESS: Readings<Reading> = &[
    ("records of lossless files are applied", |_| {}),
    ("records of lossless files are skipped", |r| {
        r.set(SideInformationOnlyIfLossy);
    }),
];

/// All choices that can change an image, in the order of the specification.
pub const CHOICES: Choices<Reading> = Choices(&[
    Choice::new("lum-vector", LUM_VECTOR),
    Choice::new("lum-major", LUM_MAJOR),
    Choice::new("lum-range", LUM_RANGE),
    Choice::new("motion-inversion", MOTION_INVERSION),
    Choice::new("motion-sign", MOTION_SIGN),
    Choice::new("motion-vertical", MOTION_VERTICAL),
    Choice::new("motion-half", MOTION_HALF),
    Choice::new("motion-border", MOTION_BORDER),
    Choice::new("jpeg-ls-offset", JPEG_LS_OFFSET),
    Choice::new("side-lossless", SIDE_LOSSLESS),
]);

/// Returns the choices that affect a case in a view. Most cases are affected by none.
///
/// A choice that is not returned must have no effect on the case: all of its readings produce the same image.
#[must_use]
pub fn relevant_axes(case: &Case, view: &View) -> Vec<Axis> {
    match case.format() {
        Format::Lum if matches!(view, View::Rgb(_)) => {
            CHOICES.axes(&["lum-vector", "lum-major", "lum-range"])
        }
        _ => CHOICES.axes(&case.axes()),
    }
}

/// Returns the correct image for each of the [`Choices::combinations`] of `axes`. The reference's image is known by construction.
///
/// The images are cached with the file, because a suite is run repeatedly.
#[cfg_attr(
    not(unix),
    allow(dead_code, reason = "images are compared only where decoders run")
)]
pub(crate) fn dialect_images(
    built: &Built,
    view: &View,
    reference: Expected,
    axes: &[Axis],
) -> DialectImages {
    let mut known = built.images.lock().expect("no worker panics");
    let make = || {
        let others = CHOICES.combinations(axes).into_iter().skip(1);
        let others = others.map(|dialect| {
            Expected::from_file(&built.file, view, &CHOICES.apply(&dialect, Reading::SPEC))
        });
        Arc::new(std::iter::once(Some(reference)).chain(others).collect())
    };
    Arc::clone(known.entry(view.to_string()).or_insert_with(make))
}
