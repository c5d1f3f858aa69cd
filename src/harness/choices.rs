//! The open questions of kind *choice*, and the dialect a decoder speaks.
//!
//! Each listed reading of a choice is right, and one run must show one of them throughout. A file may have several
//! right pictures then; which of them a decoder shows is evidence of its dialect.

use crate::harness::cases::Case;
use crate::harness::compare::Expected;
use crate::harness::protocol::View;
use crate::ptm::Format;
use crate::reading::Reading;

/// One open question.
pub struct Choice {
    /// The ruling.
    pub ruling: &'static str,
    /// The readings, the reference's first: in words, and as a change to `Reading`.
    pub readings: &'static [(&'static str, fn(Reading) -> Reading)],
}

/// All choices that change a picture, in the order of the text.
pub const CHOICES: &[Choice] = &[
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
];

/// One reading of every choice, by its place in [`CHOICES`].
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Dialect(pub Vec<usize>);

impl Dialect {
    /// The reference's.
    #[must_use]
    pub fn reference() -> Dialect {
        Dialect(vec![0; CHOICES.len()])
    }

    /// Every dialect, the reference's first.
    #[must_use]
    pub fn all() -> Vec<Dialect> {
        CHOICES
            .iter()
            .fold(vec![Dialect(Vec::new())], |all, choice| {
                let longer = |dialect: &Dialect| -> Vec<_> {
                    (0..choice.readings.len())
                        .map(|reading| Dialect([&dialect.0[..], &[reading]].concat()))
                        .collect()
                };
                all.iter().flat_map(longer).collect()
            })
    }

    /// How it reads.
    #[must_use]
    pub fn reading(&self) -> Reading {
        CHOICES
            .iter()
            .zip(&self.0)
            .fold(Reading::SPEC, |reading, (choice, &taken)| {
                (choice.readings[taken].1)(reading)
            })
    }
}

/// The choices that show in a case, asked in a view.
#[must_use]
pub fn concerned(case: &Case, view: &View) -> bool {
    case.format() == Format::Lum && matches!(view, View::Rgb(_))
}

/// The right picture of `file` in every dialect, in the order of [`Dialect::all`]; the reference's is known by construction.
#[must_use]
pub fn pictures(file: &[u8], view: &View, reference: Expected) -> Vec<Option<Expected>> {
    let others = Dialect::all()
        .into_iter()
        .skip(1)
        .map(|dialect| Expected::under(file, view, &dialect.reading()));
    std::iter::once(Some(reference)).chain(others).collect()
}
