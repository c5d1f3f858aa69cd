//! Open questions of kind *choice* about PTM files, and the dialect of a decoder. Each listed reading of a choice is correct, and
//! a decoder must use one of them throughout a run. A file may therefore have several correct images; the image that a decoder
//! outputs is evidence of its dialect.

use std::sync::Arc;

use crate::cases::{Built, Case};
use crate::compare::Expected;
use crate::dialect::{Axis, Choice, Choices, Dialect, Readings};
use crate::protocol::frame::{Light, View};
use crate::values::Values;
use ptm::Format;
use ptm::decode::{color_matrix, planes, predict};
use ptm::evaluate::{self, polynomial};
use ptm::reading::Reading;

const LUM_VECTOR: Readings<Reading> = &[
    ("the matrix multiplies (Y, Cr, Cb, 1)", |_| {}),
    ("the matrix multiplies (Cr, Y, Cb, 1)", |r| {
        r.lum_vector = evaluate::lum_vector_cr_first;
    }),
];
const LUM_MAJOR: Readings<Reading> = &[
    ("columns first", |_| {}),
    ("rows first", |r| {
        r.lum_matrix = color_matrix::row_major_rows;
    }),
];
const LUM_RANGE: Readings<Reading> = &[
    ("values and translation from 0 to 255", |_| {}),
    ("values and translation from 0 to 1", |r| {
        r.lum_translation = evaluate::scaled_lum_translation;
    }),
];
const LUM_CHROMA: Readings<Reading> = &[
    ("the matrix multiplies Cr and Cb as stored", |_| {}),
    ("the matrix multiplies Cr − 128 and Cb − 128", |r| {
        r.lum_chroma = evaluate::centered_lum_chroma;
    }),
];
const LUM_CLAMP: Readings<Reading> = &[
    ("Y is not clamped", |_| {}),
    ("Y is clamped to 0…255", |r| {
        r.lum_luminance = evaluate::clamped_lum_luminance;
    }),
    ("Y is limited to 255", |r| {
        r.lum_luminance = evaluate::clamped_luminance;
    }),
];
const LUMINANCE_CLAMP: Readings<Reading> = &[
    ("luminance is not clamped", |_| {}),
    ("luminance is clamped to 255", |r| {
        r.luminance = evaluate::clamped_luminance;
    }),
];
const MOTION_INVERSION: Readings<Reading> = &[
    ("the reference is inverted, then displaced", |_| {}),
    ("the reference is displaced, then inverted", |r| {
        r.predictor = predict::displace_then_invert;
    }),
];
const MOTION_SIGN: Readings<Reading> = &[
    ("vectors point from a texel to its predictor", |_| {}),
    ("vectors point from the predictor to its texel", |r| {
        r.motion_sign = predict::predictor_to_texel;
    }),
];
const MOTION_VERTICAL: Readings<Reading> = &[
    ("y increases in the order of the stored rows", |_| {}),
    ("y decreases in the order of the stored rows", |r| {
        r.motion_vertical = predict::y_against_stored_rows;
    }),
];
const MOTION_HALF: Readings<Reading> = &[
    ("means that end in one half are rounded up", |_| {}),
    ("means are rounded down", |r| {
        r.motion_half = predict::mean_rounded_down;
    }),
    ("means that end in one half are rounded to even", |r| {
        r.motion_half = predict::mean_rounded_to_even;
    }),
    ("means are rounded up along x, and then along y", |r| {
        r.motion_half = predict::mean_rounded_up_twice;
    }),
];
const MOTION_BORDER: Readings<Reading> = &[
    ("samples outside a plane repeat its edge", |_| {}),
    ("samples outside a plane come from its opposite side", |r| {
        r.motion_border = predict::wrap_border;
    }),
    ("samples outside a plane are 128", |r| {
        r.motion_border = predict::gray_border;
    }),
    ("samples outside a plane are 0", |r| {
        r.motion_border = predict::black_border;
    }),
    (
        "samples outside a plane mirror it, with its edge repeated",
        |r| {
            r.motion_border = predict::mirror_border;
        },
    ),
];
const JPEG_LS_OFFSET: Readings<Reading> = &[
    ("JPEG-LS residuals are 128 more than the difference", |_| {}),
    ("JPEG-LS residuals are the difference modulo 256", |r| {
        r.predict_jpeg_ls = predict::predict_without_offset;
    }),
];
const SIDE_LOSSLESS: Readings<Reading> = &[
    ("records of lossless files are applied", |_| {}),
    ("records of lossless files are skipped", |r| {
        r.side_information = planes::side_information_if_lossy;
    }),
];

/// All choices that can change an image, in the order of the specification.
pub const CHOICES: Choices<Reading> = Choices(&[
    Choice::new("lum-vector", LUM_VECTOR),
    Choice::new("lum-major", LUM_MAJOR),
    Choice::new("lum-range", LUM_RANGE),
    Choice::new("lum-chroma", LUM_CHROMA),
    Choice::new("lum-clamp", LUM_CLAMP),
    Choice::new("luminance-clamp", LUMINANCE_CLAMP),
    Choice::new("motion-inversion", MOTION_INVERSION),
    Choice::new("motion-sign", MOTION_SIGN),
    Choice::new("motion-vertical", MOTION_VERTICAL),
    Choice::new("motion-half", MOTION_HALF),
    Choice::new("motion-border", MOTION_BORDER),
    Choice::new("jpeg-ls-offset", JPEG_LS_OFFSET),
    Choice::new("side-lossless", SIDE_LOSSLESS),
]);

/// Returns the choices that affect a case with these values in a view. Most cases are affected by none.
///
/// A choice that is not returned must have no effect on the case: all of its readings produce the same image.
#[must_use]
pub fn relevant_axes(case: &Case, values: &Values, view: &View) -> Vec<Axis> {
    let mut rulings = case.axes();
    if let View::Rgb(light) = view {
        if case.format() == Format::Lum {
            rulings.extend(["lum-vector", "lum-major", "lum-range", "lum-chroma"]);
        }
        let clamp = match case.format().channels() {
            8 => "lum-clamp",
            9 => "luminance-clamp",
            _ => return CHOICES.axes(&rulings),
        };
        // Under another reading of motion, luminance may leave the range although it does not under the reference's.
        if !case.axes().is_empty() || is_changed_by_clamp(values, light) {
            rulings.push(clamp);
        }
    }
    CHOICES.axes(&rulings)
}

/// Returns true if clamping the luminance before it is used can change the color of a texel.
fn is_changed_by_clamp(values: &Values, light: &Light) -> bool {
    let Some(coefficients) = Expected::new(values, &View::Coef) else {
        return false;
    };
    let mut texels = coefficients.values.chunks_exact(coefficients.channels);
    texels.any(|texel| {
        let luminance = polynomial(texel, light.lu, light.lv);
        match &texel[6..] {
            // Without a color in between, the final clamp makes up for the missing one.
            [red, green, blue] => {
                luminance > 255.0
                    && [red, green, blue]
                        .iter()
                        .any(|&&color| color > 0.0 && color < 255.0)
            }
            _ => !(0.0..=255.0).contains(&luminance),
        }
    })
}

/// Returns the correct image in a dialect that differs from that of the reference, or `None` if the file is refused in it.
///
/// The image of the reference is known by construction; the others are decoded, and only when a decoder needs them. They are
/// cached with the file, because a suite is run repeatedly.
pub(crate) fn dialect_image(
    built: &Built,
    view: &View,
    axes: &[Axis],
    dialect: &Dialect,
) -> Option<Arc<Expected>> {
    let key = (view.to_string(), CHOICES.combination_index(dialect, axes));
    let mut known = built.images.lock().expect("no worker panics");
    let make = || {
        let reading = CHOICES.apply(dialect, Reading::SPEC);
        let image = Expected::from_file(&built.file, view, &reading);
        // The reference refuses some of the damaged files that other decoders may read.
        let from_legal = || Expected::from_file(built.legal.as_ref()?, view, &reading);
        let image = image.or_else(from_legal)?;
        // No reading makes the result depend more on the inverse DCT than that of the reference.
        let slack = Expected::new(&built.values, view)?.slack;
        Some(Arc::new(Expected { slack, ..image }))
    };
    known.entry(key).or_insert_with(make).clone()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clauses::rulings;

    #[test]
    fn other_readings_change_exactly_the_step_that_their_ruling_names() {
        let rulings = rulings().expect("the rulings load");
        for choice in CHOICES.iter() {
            let ruling = rulings.iter().find(|ruling| ruling.id == choice.ruling);
            let ruling = ruling.expect(choice.ruling);
            let [(_, reference), others @ ..] = choice.readings else {
                panic!("{} has no readings", choice.ruling);
            };
            assert_eq!(changed_steps(*reference), [""; 0], "{}", choice.ruling);
            assert_eq!(others.len(), ruling.alternatives.len(), "{}", choice.ruling);
            for (words, change) in others {
                let step = ruling.step.as_deref().expect(choice.ruling);
                assert_eq!(changed_steps(*change), [step], "{words}");
            }
        }
    }

    fn changed_steps(change: fn(&mut Reading)) -> Vec<&'static str> {
        let mut reading = Reading::SPEC;
        change(&mut reading);
        reading.differences(&Reading::SPEC)
    }
}
