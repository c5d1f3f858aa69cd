//! Colors that are computed otherwise than the text says, with one or several slips in one expression.

use super::formulas::Formula;
use super::grid::{self, Places};
use super::variants::signed_byte;
use crate::evaluate::{Coefficients, evaluate};
use crate::protocol::frame::Light;
use crate::ptm::{ColorMatrix, Shape};
use crate::reading::Reading;

/// Something that stands in an expression, in words and as a function of what is right there.
type Part = (&'static str, fn(f64) -> f64);

/// What is taken for the luminance L.
const LUMINANCES: &[Part] = &[
    ("L", |l| l),
    ("(L, at most 255,)", |l| l.min(255.0)),
    ("(L, at least 0,)", |l| l.max(0.0)),
    ("(L, limited to 0…255,)", |l| l.clamp(0.0, 255.0)),
    ("|L|", f64::abs),
    ("(L, rounded,)", f64::round),
    ("(L, cut to a whole number,)", f64::trunc),
    ("(L as a byte)", |l| l.trunc().rem_euclid(256.0)),
    ("(L / 255, cut to a whole number, · 255)", |l| {
        (l / 255.0).trunc() * 255.0
    }),
    ("(255 − L)", |l| 255.0 - l),
];

/// What is taken for the color of the texel.
const COLORS: &[Part] = &[
    ("RGB", |c| c),
    ("(255 − RGB)", |c| 255.0 - c),
    ("(256 − RGB)", |c| 256.0 - c),
    ("(RGB + 1)", |c| c + 1.0),
    ("(RGB − 1)", |c| c - 1.0),
    ("(RGB − 128)", |c| c - 128.0),
    ("(RGB + 128)", |c| c + 128.0),
    ("(RGB as a signed byte)", signed_byte),
    ("(RGB, at most 127,)", |c| c.min(127.0)),
    ("(2 · RGB)", |c| 2.0 * c),
    ("(RGB without its lowest bit)", |c| (c / 2.0).floor() * 2.0),
];

/// What the product is divided by.
const DIVISORS: &[Part] = &[
    (" / 255", |p| p / 255.0),
    (" / 256", |p| p / 256.0),
    (" / 254", |p| p / 254.0),
    (" / 128", |p| p / 128.0),
    (" / 127", |p| p / 127.0),
    (" / 127.5", |p| p / 127.5),
    (" / 100", |p| p / 100.0),
    (" / 512", |p| p / 512.0),
];

/// What becomes of the quotient.
const QUOTIENTS: &[Part] = &[
    ("", |q| q),
    (", plus 1", |q| q + 1.0),
    (", less 1", |q| q - 1.0),
    (", without its sign", f64::abs),
];

/// What a computed color is multiplied by before it becomes a byte.
const FACTORS: &[Part] = &[
    ("it", |c| c),
    ("it · 255 / 256", |c| c * 255.0 / 256.0),
    ("it · 256 / 255", |c| c * 256.0 / 255.0),
    ("it · 254 / 255", |c| c * 254.0 / 255.0),
    ("it, less 1,", |c| c - 1.0),
    ("it, plus 1,", |c| c + 1.0),
];

/// What becomes of colors below 0.
const SIGNS: &[Part] = &[
    ("", |c| c),
    (" without its sign", f64::abs),
    (", at least 0,", |c| c.max(0.0)),
    (", at least 1,", |c| c.max(1.0)),
];

/// How it is made a whole number.
const ROUNDINGS: &[Part] = &[
    (" rounded", f64::round),
    (" rounded down", f64::floor),
    (" rounded up", f64::ceil),
    (" cut to a whole number", f64::trunc),
    (" rounded twice, first to tenths,", |c| {
        ((c * 10.0).round() / 10.0).round()
    }),
    (" rounded to an even number", |c| (c / 2.0).round() * 2.0),
];

/// What becomes of colors above 255, and of negative ones that are still there.
const TOPS: &[Part] = &[
    (" and limited to 0…255", |c| c.clamp(0.0, 255.0)),
    (", its lowest eight bits", |c| c.rem_euclid(256.0)),
    (", modulo 255", |c| c.rem_euclid(255.0)),
    (" and limited to 0…254", |c| c.clamp(0.0, 254.0)),
    (", and 0 beyond 0…255", |c| {
        if (0.0..=255.0).contains(&c) { c } else { 0.0 }
    }),
    (", and 255 beyond 0…255", |c| {
        if (0.0..=255.0).contains(&c) { c } else { 255.0 }
    }),
    (" and limited to 1…255", |c| c.clamp(1.0, 255.0)),
    (", limited to 0…510 and halved", |c| {
        c.clamp(0.0, 510.0) / 2.0
    }),
];

/// What is taken for Y.
const YS: &[Part] = &[
    ("Y", |y| y),
    ("(Y limited to 0…255)", |y| y.clamp(0.0, 255.0)),
    ("(Y, at least 0)", |y| y.max(0.0)),
    ("(Y rounded)", f64::round),
    ("(Y cut to a whole number)", f64::trunc),
    ("|Y|", f64::abs),
    ("(Y − 16)", |y| y - 16.0),
    ("(Y − 128)", |y| y - 128.0),
    ("Y / 255", |y| y / 255.0),
];

/// What is taken for Cr and Cb.
const CHROMAS: &[Part] = &[
    ("Cr, Cb", |c| c),
    ("Cr − 128, Cb − 128", |c| c - 128.0),
    ("Cr − 127, Cb − 127", |c| c - 127.0),
    ("Cr − 127.5, Cb − 127.5", |c| c - 127.5),
    ("128 − Cr, 128 − Cb", |c| 128.0 - c),
    ("Cr, Cb as signed bytes", signed_byte),
    ("Cr / 255, Cb / 255", |c| c / 255.0),
    ("2 · Cr, 2 · Cb", |c| 2.0 * c),
    ("Cr / 2, Cb / 2", |c| c / 2.0),
];

/// A row of the matrix and its translation; the translations of all rows; and Y: what is added last.
type Translation = (&'static str, fn([f64; 4], [f64; 3], f64) -> f64);

const TRANSLATIONS: &[Translation] = &[
    ("", |row, _, _| row[3]),
    (", without the translation", |_, _, _| 0.0),
    (", with the translation subtracted", |row, _, _| -row[3]),
    (
        ", with the translation added to Y, Cr and Cb before",
        |row, t, _| row[0] * t[0] + row[1] * t[1] + row[2] * t[2],
    ),
    (
        ", with the translation of each color added to Y, Cr and Cb before",
        |row, _, _| (row[0] + row[1] + row[2]) * row[3],
    ),
    (
        ", with the translation subtracted from Y, Cr and Cb before",
        |row, t, _| -(row[0] * t[0] + row[1] * t[1] + row[2] * t[2]),
    ),
    (", with the translation times 255", |row, _, _| {
        row[3] * 255.0
    }),
    (", with the translation divided by 255", |row, _, _| {
        row[3] / 255.0
    }),
    (", with the translation times Y", |row, _, y| row[3] * y),
    (", with the translation twice", |row, _, _| 2.0 * row[3]),
    (", with the translation of red for all", |_, t, _| t[0]),
    (", with the translation of blue for all", |_, t, _| t[2]),
];

/// The order of the values that the matrix is multiplied with.
const ORDERS: &[(&str, [usize; 3])] = &[
    ("", [0, 1, 2]),
    (", Cr and Cb exchanged", [0, 2, 1]),
    (", in the order Cr, Y, Cb", [1, 0, 2]),
    (", in the order Cr, Cb, Y", [1, 2, 0]),
    (", in the order Cb, Cr, Y", [2, 1, 0]),
];

/// What the matrix is read as.
type Rows = (&'static str, fn(&ColorMatrix, &Reading) -> [[f64; 4]; 3]);

const MATRICES: &[Rows] = &[
    ("", |matrix, reading| (reading.lum_matrix)(matrix)),
    (", the matrix read row by row", |ColorMatrix(m), _| {
        [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| m[row * 4 + column]))
    }),
    (
        ", the matrix read row by row but for the translation",
        |ColorMatrix(m), _| {
            [0, 1, 2].map(|row| [m[row * 4], m[row * 4 + 1], m[row * 4 + 2], m[12 + row]])
        },
    ),
];

/// Another way to a color: what stands in each part of an expression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum ColorRule {
    /// [`LUMINANCES`], [`COLORS`], [`DIVISORS`] and [`QUOTIENTS`]: L · RGB / 255.
    Product(Places<4>),
    /// [`YS`], [`CHROMAS`], [`ORDERS`], [`MATRICES`] and [`TRANSLATIONS`]: the matrix times (Y, Cr, Cb, 1).
    Matrix(Places<5>),
    /// [`FACTORS`], [`SIGNS`], [`ROUNDINGS`] and [`TOPS`]: the byte of a color.
    Byte(Places<4>),
    /// What is left of a color goes into the next.
    Carried(Carried),
}

/// Where what is left of one color goes into the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::diagnose) enum Carried {
    /// The sum of a polynomial goes on in that of the next color.
    Polynomials,
    /// The sum of a row of the matrix goes on in the next row.
    Rows,
    /// Red stands in the place of Y, and green in that of Cr, when the next row is multiplied.
    Vector,
}

impl ColorRule {
    /// All of them.
    pub fn all() -> impl Iterator<Item = ColorRule> {
        let products = [
            LUMINANCES.len(),
            COLORS.len(),
            DIVISORS.len(),
            QUOTIENTS.len(),
        ];
        let matrices = [
            YS.len(),
            CHROMAS.len(),
            ORDERS.len(),
            MATRICES.len(),
            TRANSLATIONS.len(),
        ];
        let bytes = [FACTORS.len(), SIGNS.len(), ROUNDINGS.len(), TOPS.len()];
        (grid::all(products).map(ColorRule::Product))
            .chain(grid::all(matrices).map(ColorRule::Matrix))
            .chain(grid::all(bytes).map(ColorRule::Byte))
            .chain([Carried::Polynomials, Carried::Rows, Carried::Vector].map(ColorRule::Carried))
    }

    /// The colors of all texels under a light, not rounded unless that is part of the rule.
    pub fn colors(self, finals: &Coefficients, light: &Light, reading: &Reading) -> Vec<f64> {
        let (u, v) = (reading.light)(light.lu, light.lv);
        let texels = || finals.values.chunks_exact(finals.shape.channels());
        let luminance = |texel: &[f64]| (reading.polynomial)(&texel[..6], u, v);
        match (self, finals.shape) {
            (ColorRule::Product(places), Shape::Lrgb) => {
                let color = |texel: &[f64]| {
                    let l = luminance(texel);
                    [texel[6], texel[7], texel[8]].map(|color| product(places, l, color))
                };
                texels().flat_map(color).map(reading.clamp).collect()
            }
            (ColorRule::Matrix(places), Shape::Lum(matrix)) => {
                let rows = MATRICES[places[3]].1(&matrix, reading);
                let color = |texel: &[f64]| {
                    multiplied(
                        places,
                        rows,
                        luminance(texel),
                        [texel[6], texel[7]],
                        reading,
                    )
                };
                texels().flat_map(color).map(reading.clamp).collect()
            }
            (ColorRule::Byte([factor, sign, rounding, top]), _) => {
                let unlimited = Reading {
                    clamp: |value| value,
                    ..*reading
                };
                let colors = evaluate(finals, light.lu, light.lv, &unlimited).values;
                let parts = [FACTORS[factor], SIGNS[sign], ROUNDINGS[rounding], TOPS[top]];
                let byte = |color: f64| parts.iter().fold(color, |color, (_, part)| part(color));
                colors
                    .into_iter()
                    .map(|color| byte(color).clamp(0.0, 255.0))
                    .collect()
            }
            (ColorRule::Carried(Carried::Polynomials), Shape::Rgb)
            | (ColorRule::Carried(Carried::Rows), Shape::Lum(_)) => {
                let unlimited = Reading {
                    clamp: |value| value,
                    ..*reading
                };
                let mut colors = evaluate(finals, light.lu, light.lv, &unlimited).values;
                for color in colors.chunks_exact_mut(3) {
                    color[1] += color[0];
                    color[2] += color[1];
                }
                colors.into_iter().map(reading.clamp).collect()
            }
            (ColorRule::Carried(Carried::Vector), Shape::Lum(matrix)) => {
                let rows = (reading.lum_matrix)(&matrix);
                let color =
                    |texel: &[f64]| in_place(rows, luminance(texel), [texel[6], texel[7]], reading);
                texels().flat_map(color).map(reading.clamp).collect()
            }
            _ => evaluate(finals, light.lu, light.lv, reading).values,
        }
    }

    /// As a sentence without its subject.
    pub fn says(self) -> String {
        match self {
            ColorRule::Product([luminance, color, divisor, quotient]) => format!(
                "computes a color as {} · {}{}{}",
                LUMINANCES[luminance].0,
                COLORS[color].0,
                DIVISORS[divisor].0,
                QUOTIENTS[quotient].0
            ),
            ColorRule::Matrix([y, chroma, order, matrix, translation]) => format!(
                "computes a color as the matrix times ({}, {}, 1){}{}{}",
                YS[y].0,
                CHROMAS[chroma].0,
                ORDERS[order].0,
                MATRICES[matrix].0,
                TRANSLATIONS[translation].0
            ),
            ColorRule::Byte([factor, sign, rounding, top]) => format!(
                "shows a color as {}{}{}{}",
                FACTORS[factor].0, SIGNS[sign].0, ROUNDINGS[rounding].0, TOPS[top].0
            )
            .replace(",,", ","),
            ColorRule::Carried(carried) => match carried {
                Carried::Polynomials => "adds the polynomial of a color to that of the color before: green is red + green, blue is red + green + blue",
                Carried::Rows => "adds the row of the matrix of a color to that of the color before: green is red + green, blue is red + green + blue",
                Carried::Vector => "multiplies by the matrix in place: for green, red stands in the place of Y, and for blue, green in that of Cr",
            }
            .to_owned(),
        }
    }

    /// The formula that is another.
    pub const fn formula(self) -> Formula {
        match self {
            ColorRule::Product(_) => Formula::Color,
            ColorRule::Matrix(_) | ColorRule::Carried(Carried::Rows | Carried::Vector) => {
                Formula::Matrix
            }
            ColorRule::Byte(_) => Formula::Limits,
            ColorRule::Carried(Carried::Polynomials) => Formula::Polynomial,
        }
    }
}

fn product([luminance, color, divisor, quotient]: Places<4>, l: f64, stored: f64) -> f64 {
    let product = LUMINANCES[luminance].1(l) * COLORS[color].1(stored);
    QUOTIENTS[quotient].1(DIVISORS[divisor].1(product))
}

fn multiplied(
    [y, chroma, order, _, translation]: Places<5>,
    rows: [[f64; 4]; 3],
    luminance: f64,
    stored: [f64; 2],
    reading: &Reading,
) -> [f64; 3] {
    let y = YS[y].1(luminance);
    let [cr, cb] = stored.map(CHROMAS[chroma].1);
    let right = (reading.lum_vector)(y, cr, cb);
    let [p, q, r] = ORDERS[order].1.map(|which| right[which]);
    let translations = rows.map(|row| (reading.lum_translation)(row[3]));
    rows.map(|[m0, m1, m2, t]| {
        let row = [m0, m1, m2, (reading.lum_translation)(t)];
        m0 * p + m1 * q + m2 * r + TRANSLATIONS[translation].1(row, translations, y)
    })
}

/// The matrix times (Y, Cr, Cb, 1), each color written over the value that it was made of.
fn in_place(
    rows: [[f64; 4]; 3],
    luminance: f64,
    [cr, cb]: [f64; 2],
    reading: &Reading,
) -> [f64; 3] {
    let mut values = (reading.lum_vector)(luminance, cr, cb);
    for (i, [m0, m1, m2, t]) in rows.into_iter().enumerate() {
        let [p, q, r] = values;
        values[i] = m0 * p + m1 * q + m2 * r + (reading.lum_translation)(t);
    }
    values
}

#[cfg(test)]
mod tests {
    use crate::diagnose::tests::first_cause;
    use crate::ptm::Format;
    use crate::reading::Reading;

    #[test]
    fn several_slips_in_a_product_are_told_as_one_expression() {
        let reading = Reading {
            modulate: |l, c| l.min(255.0) * (255.0 - c) / 128.0,
            ..Reading::SPEC
        };
        let told = first_cause(reading, |case| !case.format().is_compressed());
        assert!(
            told.contains("(L, at most 255,) · (255 − RGB) / 128"),
            "{told}"
        );
    }

    #[test]
    fn several_slips_on_the_way_to_a_byte_are_told_as_one_expression() {
        let reading = Reading {
            clamp: |color| ((color.abs() * 255.0 / 256.0 + 0.5).floor() as i64 & 255) as f64,
            ..Reading::SPEC
        };
        let told = first_cause(reading, |case| !case.format().is_compressed());
        let says = "it · 255 / 256 without its sign rounded, its lowest eight bits";
        assert!(told.contains(says), "{told}");
    }

    #[test]
    fn several_slips_before_the_matrix_are_told_as_one_expression() {
        let reading = Reading {
            lum_vector: |y, cr, cb| [y.max(0.0), cb - 128.0, cr - 128.0],
            ..Reading::SPEC
        };
        let told = first_cause(reading, |case| case.format() == Format::Lum);
        let says = "((Y, at least 0), Cr − 128, Cb − 128, 1), Cr and Cb exchanged";
        assert!(told.contains(says), "{told}");
    }
}
