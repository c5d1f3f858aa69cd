//! Formulas that some decoders have in place of those of the text, and that the catalog does not list.

use std::ops::Range;
use std::sync::LazyLock;

use super::formulas::Formula;
use crate::misreadings::At;
use crate::ptm::ColorMatrix;

/// One of them.
pub(in crate::diagnose) struct Variant {
    /// What it does, as a sentence without its subject.
    pub says: &'static str,
    pub formula: Formula,
    /// The decision that is made otherwise.
    pub at: At,
}

/// A sum of six terms, made of the coefficients and of the six powers of the light.
const fn polynomial(says: &'static str, of: fn(&[f64], f64, f64) -> f64) -> Variant {
    Variant {
        says,
        formula: Formula::Polynomial,
        at: At::Polynomial(of),
    }
}

const fn light(says: &'static str, of: fn(f64, f64) -> (f64, f64)) -> Variant {
    Variant {
        says,
        formula: Formula::Light,
        at: At::Light(of),
    }
}

const fn product(says: &'static str, of: fn(f64, f64) -> f64) -> Variant {
    Variant {
        says,
        formula: Formula::Color,
        at: At::Modulate(of),
    }
}

const fn vector(says: &'static str, of: fn(f64, f64, f64) -> [f64; 3]) -> Variant {
    Variant {
        says,
        formula: Formula::Matrix,
        at: At::LumVector(of, of),
    }
}

const fn matrix(says: &'static str, of: fn(&ColorMatrix) -> [[f64; 4]; 3]) -> Variant {
    Variant {
        says,
        formula: Formula::Matrix,
        at: At::LumMatrix(of),
    }
}

const fn limits(says: &'static str, of: fn(f64) -> f64) -> Variant {
    Variant {
        says,
        formula: Formula::Limits,
        at: At::Clamp(of),
    }
}

/// The six terms of the polynomial.
fn terms(a: &[f64], u: f64, v: f64) -> [f64; 6] {
    [
        a[0] * u * u,
        a[1] * v * v,
        a[2] * u * v,
        a[3] * u,
        a[4] * v,
        a[5],
    ]
}

/// The terms added one after the other, with `step` after each sum.
fn added(a: &[f64], u: f64, v: f64, step: fn(f64) -> f64) -> f64 {
    let terms = terms(a, u, v).into_iter();
    terms.fold(0.0, |sum, term| step(sum + term))
}

fn sum(a: &[f64], u: f64, v: f64, term: fn(f64) -> f64) -> f64 {
    terms(a, u, v).map(term).iter().sum()
}

/// The rows of the matrix with columns that begin at these elements.
fn columns(ColorMatrix(m): &ColorMatrix, starts: [usize; 4]) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|row| starts.map(|start| m[(start + row) % 16]))
}

/// A byte read as a signed one.
pub(in crate::diagnose) fn signed_byte(value: f64) -> f64 {
    if value > 127.0 { value - 256.0 } else { value }
}

fn signed_16_bits(value: f64) -> f64 {
    f64::from(value as i64 as i16)
}

/// The sum of the six terms, and what is added to it.
fn sum_and(a: &[f64], u: f64, v: f64, more: f64) -> f64 {
    terms(a, u, v).iter().sum::<f64>() + more
}

/// The sum of the six terms, of other coefficients.
fn sum_of(a: &[f64], u: f64, v: f64, other: fn(f64) -> f64) -> f64 {
    let others: Vec<f64> = a.iter().map(|&a| other(a)).collect();
    terms(&others, u, v).iter().sum()
}

/// The multiple of a number that `rounding` finds.
fn multiple(value: f64, of: i32, rounding: fn(f64) -> f64) -> f64 {
    rounding(value / f64::from(of)) * f64::from(of)
}

/// A number that is added to a color.
fn color_and(color: f64, more: i32) -> f64 {
    (color + f64::from(more)).clamp(0.0, 255.0)
}

macro_rules! sums {
    ($($more:literal)*) => {
        &[$(
            polynomial(concat!("adds ", $more, " to the sum of the six terms"), |a, u, v| {
                sum_and(a, u, v, f64::from($more))
            }),
            polynomial(concat!("subtracts ", $more, " from the sum of the six terms"), |a, u, v| {
                sum_and(a, u, v, -f64::from($more))
            }),
        )*]
    };
}

/// A number added to the polynomial.
static SUMS: &[Variant] = sums!(1 2 128 3 4 5 10);

macro_rules! sums_in_steps {
    ($($step:literal)*) => {
        &[$(
            polynomial(concat!("rounds the sum of the six terms down to a multiple of ", $step), |a, u, v| {
                multiple(sum_and(a, u, v, 0.0), $step, f64::floor)
            }),
            polynomial(concat!("cuts the sum of the six terms to a multiple of ", $step, ", toward 0"), |a, u, v| {
                multiple(sum_and(a, u, v, 0.0), $step, f64::trunc)
            }),
            polynomial(concat!("rounds the sum of the six terms to the nearest multiple of ", $step), |a, u, v| {
                multiple(sum_and(a, u, v, 0.0), $step, f64::round)
            }),
        )*]
    };
}

/// The polynomial in steps.
static SUMS_IN_STEPS: &[Variant] = sums_in_steps!(2 4 5 8);

/// Other coefficients.
static COEFFICIENTS: &[Variant] = &[
    polynomial("halves negative coefficients", |a, u, v| {
        sum_of(a, u, v, |a| if a < 0.0 { a / 2.0 } else { a })
    }),
    polynomial("doubles negative coefficients", |a, u, v| {
        sum_of(a, u, v, |a| if a < 0.0 { a * 2.0 } else { a })
    }),
    polynomial("takes 0 for negative coefficients", |a, u, v| {
        sum_of(a, u, v, |a| a.max(0.0))
    }),
    polynomial("takes coefficients without their sign", |a, u, v| {
        sum_of(a, u, v, f64::abs)
    }),
    polynomial("cuts coefficients to whole numbers", |a, u, v| {
        sum_of(a, u, v, f64::trunc)
    }),
    polynomial("rounds coefficients to whole numbers", |a, u, v| {
        sum_of(a, u, v, f64::round)
    }),
];

macro_rules! colors {
    ($($more:literal)*) => {
        &[$(
            limits(concat!("adds ", $more, " to each color"), |c| color_and(c, $more)),
            limits(concat!("subtracts ", $more, " from each color"), |c| color_and(c, -$more)),
        )*]
    };
}

/// A number added to colors.
static COLORS: &[Variant] = colors!(2 3 4 5 10);

macro_rules! colors_in_steps {
    ($($step:literal)*) => {
        &[$(
            limits(concat!("cuts colors to multiples of ", $step), |c| {
                multiple(c.clamp(0.0, 255.0), $step, f64::floor)
            }),
            limits(concat!("cuts rounded colors to multiples of ", $step), |c| {
                multiple(c.round().clamp(0.0, 255.0), $step, f64::floor)
            }),
            limits(concat!("rounds colors to multiples of ", $step), |c| {
                multiple(c.clamp(0.0, 255.0), $step, f64::round).min(255.0)
            }),
        )*]
    };
}

/// Colors in steps.
static COLORS_IN_STEPS: &[Variant] = colors_in_steps!(4 5 8 10 16);

/// A matrix of which the elements of these columns and rows are changed.
fn changed(
    m: &ColorMatrix,
    of_columns: Range<usize>,
    of_rows: Range<usize>,
    change: fn(f64) -> f64,
) -> [[f64; 4]; 3] {
    let mut rows = columns(m, [0, 4, 8, 12]);
    for row in &mut rows[of_rows] {
        for element in &mut row[of_columns.clone()] {
            *element = change(*element);
        }
    }
    rows
}

macro_rules! elements {
    ($($verb:literal $change:expr;)*) => {
        &[$(
            elements!(of 0..1, $verb, " the factor of Y", $change),
            elements!(of 1..2, $verb, " the factor of Cr", $change),
            elements!(of 2..3, $verb, " the factor of Cb", $change),
            elements!(of 3..4, $verb, " the translation", $change),
            elements!(of 0..3, $verb, " the factors of Y, Cr and Cb", $change),
        )*]
    };
    (of $columns:expr, $verb:literal, $name:literal, $change:expr) => {
        [
            matrix(concat!($verb, $name, " in the matrix"), |m| changed(m, $columns, 0..3, $change)),
            matrix(concat!($verb, $name, " in the matrix for red"), |m| changed(m, $columns, 0..1, $change)),
            matrix(concat!($verb, $name, " in the matrix for green"), |m| changed(m, $columns, 1..2, $change)),
            matrix(concat!($verb, $name, " in the matrix for blue"), |m| changed(m, $columns, 2..3, $change)),
        ]
    };
}

/// Other elements of the matrix.
static ELEMENTS: &[[Variant; 4]] = elements!(
    "halves" |element| element / 2.0;
    "doubles" |element| element * 2.0;
    "leaves out" |_| 0.0;
    "negates" |element| -element;
    "takes 0, where it is negative, for" |element| element.max(0.0);
    "drops the sign of" f64::abs;
    "drops the fraction of" f64::trunc;
    "rounds" f64::round;
    "takes 1 for" |_| 1.0;
    "squares" |element| element * element;
);

macro_rules! ends {
    ($($limit:literal)*) => {
        &[$(
            limits(concat!("shows 0 for colors over ", $limit), |c| {
                if c > f64::from($limit) { 0.0 } else { c.clamp(0.0, 255.0) }
            }),
            limits(concat!("shows 255 for colors below −", $limit), |c| {
                if c < -f64::from($limit) { 255.0 } else { c.clamp(0.0, 255.0) }
            }),
        )*]
    };
}

/// Colors far outside of 0 … 255 that turn into the other end.
static ENDS: &[Variant] = ends!(100 128 256 300 400 500 511 512 767 1000 1023 1024);

/// All of them.
pub(in crate::diagnose) static VARIANTS: LazyLock<Vec<&Variant>> = LazyLock::new(|| {
    let lists = [
        SUMS,
        SUMS_IN_STEPS,
        COEFFICIENTS,
        COLORS,
        COLORS_IN_STEPS,
        ENDS,
        FORMULAS,
    ];
    let elements = ELEMENTS.iter().flatten();
    lists.into_iter().flatten().chain(elements).collect()
});

/// The others.
static FORMULAS: &[Variant] = &[
    limits("shows 0 for colors below 16", |c| {
        if c < 16.0 { 0.0 } else { c.min(255.0) }
    }),
    limits("shows 0 for colors below 10", |c| {
        if c < 10.0 { 0.0 } else { c.min(255.0) }
    }),
    limits("shows 0 for colors below 5", |c| {
        if c < 5.0 { 0.0 } else { c.min(255.0) }
    }),
    limits("shows 255 for colors above 240", |c| {
        if c > 240.0 { 255.0 } else { c.max(0.0) }
    }),
    limits("shows 255 for colors above 250", |c| {
        if c > 250.0 { 255.0 } else { c.max(0.0) }
    }),
    limits("shows 255 for colors above 235", |c| {
        if c > 235.0 { 255.0 } else { c.max(0.0) }
    }),
    polynomial(
        "limits the sum of the three quadratic terms to 0 and above before the others are added",
        |a, u, v| {
            let [uu, vv, uv, u, v, one] = terms(a, u, v);
            (uu + vv + uv).max(0.0) + u + v + one
        },
    ),
    polynomial(
        "limits the sum of the two linear terms to 0 and above before it is added",
        |a, u, v| {
            let [uu, vv, uv, u, v, one] = terms(a, u, v);
            uu + vv + uv + (u + v).max(0.0) + one
        },
    ),
    polynomial(
        "limits the sum of the five terms with u and v to 0 and above before a5 is added",
        |a, u, v| {
            let [uu, vv, uv, u, v, one] = terms(a, u, v);
            (uu + vv + uv + u + v).max(0.0) + one
        },
    ),
    polynomial("limits a5 to 0…255", |a, u, v| {
        let [uu, vv, uv, u, v, one] = terms(a, u, v);
        uu + vv + uv + u + v + one.clamp(0.0, 255.0)
    }),
    polynomial("limits a5 to 0 and above", |a, u, v| {
        let [uu, vv, uv, u, v, one] = terms(a, u, v);
        uu + vv + uv + u + v + one.max(0.0)
    }),
    polynomial("limits each term to 0 and above", |a, u, v| {
        sum(a, u, v, |term| term.max(0.0))
    }),
    polynomial("adds the terms without their signs", |a, u, v| {
        sum(a, u, v, f64::abs)
    }),
    polynomial("limits each term to 0…255", |a, u, v| {
        sum(a, u, v, |term| term.clamp(0.0, 255.0))
    }),
    polynomial("cuts each term to a whole number", |a, u, v| {
        sum(a, u, v, f64::trunc)
    }),
    polynomial("rounds each term to a whole number", |a, u, v| {
        sum(a, u, v, f64::round)
    }),
    polynomial("limits the sum to 0…255 after each term", |a, u, v| {
        added(a, u, v, |sum| sum.clamp(0.0, 255.0))
    }),
    polynomial(
        "limits the sum to 0 and above after each term",
        |a, u, v| added(a, u, v, |sum| sum.max(0.0)),
    ),
    polynomial(
        "cuts the sum to a whole number after each term",
        |a, u, v| added(a, u, v, f64::trunc),
    ),
    polynomial("adds the terms in signed 16 bits", |a, u, v| {
        added(a, u, v, signed_16_bits)
    }),
    polynomial("adds the terms in one byte", |a, u, v| {
        added(a, u, v, |sum| sum.rem_euclid(256.0))
    }),
    polynomial("multiplies a2 by u + v", |a, u, v| {
        let [uu, vv, _, u1, v1, one] = terms(a, u, v);
        uu + vv + a[2] * (u + v) + u1 + v1 + one
    }),
    polynomial("multiplies a2 by u · v twice", |a, u, v| {
        let [uu, vv, uv, u1, v1, one] = terms(a, u, v);
        uu + vv + uv * u * v + u1 + v1 + one
    }),
    polynomial("multiplies a0 and a1 by u² + v²", |a, u, v| {
        let [_, _, uv, u1, v1, one] = terms(a, u, v);
        (a[0] + a[1]) * (u * u + v * v) + uv + u1 + v1 + one
    }),
    polynomial(
        "multiplies the quadratic terms by u and v once more",
        |a, u, v| {
            let [uu, vv, uv, u1, v1, one] = terms(a, u, v);
            uu * u + vv * v + uv + u1 + v1 + one
        },
    ),
    polynomial(
        "takes the polynomial's root before it is shown",
        |a, u, v| {
            let [uu, vv, uv, u, v, one] = terms(a, u, v);
            (uu + vv + uv + u + v + one).max(0.0).sqrt()
        },
    ),
    light("shortens lights longer than 1 to 1", |u, v| {
        let length = u.hypot(v).max(1.0);
        (u / length, v / length)
    }),
    light(
        "makes the light as long as 1 in the plane of u and v",
        |u, v| {
            let length = u.hypot(v);
            if length > 0.0 {
                (u / length, v / length)
            } else {
                (u, v)
            }
        },
    ),
    light(
        "divides u and v by their distance from (0, 0, 1)",
        |u, v| {
            let length = (u * u + v * v + 1.0).sqrt();
            (u / length, v / length)
        },
    ),
    light("takes u and v as numbers from −127 to 127", |u, v| {
        ((u * 127.0).round() / 127.0, (v * 127.0).round() / 127.0)
    }),
    light("cuts u and v to numbers from −127 to 127", |u, v| {
        ((u * 127.0).trunc() / 127.0, (v * 127.0).trunc() / 127.0)
    }),
    light("cuts u and v to steps of 1/128", |u, v| {
        ((u * 128.0).trunc() / 128.0, (v * 128.0).trunc() / 128.0)
    }),
    light("keeps one decimal of u and v", |u, v| {
        ((u * 10.0).round() / 10.0, (v * 10.0).round() / 10.0)
    }),
    light("cuts u and v after one decimal", |u, v| {
        ((u * 10.0).trunc() / 10.0, (v * 10.0).trunc() / 10.0)
    }),
    light("takes u and v from 0…1 to −1…1", |u, v| {
        (2.0 * u - 1.0, 2.0 * v - 1.0)
    }),
    light("takes u and v from −1…1 to 0…1", |u, v| {
        (f64::midpoint(u, 1.0), f64::midpoint(v, 1.0))
    }),
    light("takes u and v for azimuth and elevation", |u, v| {
        (u.cos() * v.cos(), u.sin() * v.cos())
    }),
    product("multiplies luminance by color in signed 16 bits", |l, c| {
        signed_16_bits(l.trunc() * c) / 255.0
    }),
    product("multiplies luminance by color in 16 bits", |l, c| {
        f64::from((l.trunc() * c) as i64 as u16) / 255.0
    }),
    product(
        "multiplies luminance, 0 at the least, by color in 16 bits, and drops the fraction of the quotient",
        |l, c| f64::from((l.trunc().max(0.0) * c) as i64 as u16 / 255),
    ),
    product(
        "cuts color / 255 to a whole number before it multiplies",
        |l, c| l * (c / 255.0).trunc(),
    ),
    product(
        "cuts luminance / 255 to a whole number before it multiplies",
        |l, c| (l / 255.0).trunc() * c,
    ),
    product("rounds luminance / 255 to two decimals", |l, c| {
        (l / 255.0 * 100.0).round() / 100.0 * c
    }),
    product("rounds color / 255 to multiples of 1/16", |l, c| {
        l * (c / 255.0 * 16.0).round() / 16.0
    }),
    product("rounds color / 255 to one decimal", |l, c| {
        l * (c / 255.0 * 10.0).round() / 10.0
    }),
    product("rounds color / 255 to two decimals", |l, c| {
        l * (c / 255.0 * 100.0).round() / 100.0
    }),
    product(
        "divides luminance · color by 256 where luminance is over 255",
        |l, c| l * c / if l > 255.0 { 256.0 } else { 255.0 },
    ),
    product(
        "divides luminance · color by 128 where luminance is below 64",
        |l, c| l * c / if l < 64.0 { 128.0 } else { 255.0 },
    ),
    product("divides luminance · color by 128", |l, c| l * c / 128.0),
    product("divides luminance · color by 100", |l, c| l * c / 100.0),
    product("divides luminance · color by 250", |l, c| l * c / 250.0),
    product("divides luminance · color by 252", |l, c| l * c / 252.0),
    product("divides luminance · color by 258", |l, c| l * c / 258.0),
    product("divides luminance · color by 260", |l, c| l * c / 260.0),
    product("divides luminance · color by 254", |l, c| l * c / 254.0),
    product(
        "multiplies the square of luminance / 255 by the color",
        |l, c| (l / 255.0) * (l / 255.0) * c,
    ),
    product(
        "multiplies the square root of luminance / 255 by the color",
        |l, c| (l.max(0.0) / 255.0).sqrt() * c,
    ),
    product("adds luminance and color", |l, c| l + c),
    product("adds luminance and color and subtracts 255", |l, c| {
        l + c - 255.0
    }),
    product("adds luminance and color and subtracts 128", |l, c| {
        l + c - 128.0
    }),
    product("takes the mean of luminance and color", |l, c| {
        f64::midpoint(l, c)
    }),
    product("takes the smaller of luminance and color", f64::min),
    product(
        "screens luminance and color: 255 − (255 − L) · (255 − C) / 255",
        |l, c| 255.0 - (255.0 - l) * (255.0 - c) / 255.0,
    ),
    product("takes a color of 0 for 255, and shows luminance", |l, c| {
        if c == 0.0 { l } else { l * c / 255.0 }
    }),
    product(
        "shows luminance where a color is 255, and 0 elsewhere",
        |l, c| {
            if c == 255.0 { l } else { 0.0 }
        },
    ),
    product("takes a color of 0 for 1", |l, c| l * c.max(1.0) / 255.0),
    product(
        "divides luminance · color by 256 where it is over 32767",
        |l, c| {
            let product = l * c;
            if product > 32767.0 {
                product / 256.0
            } else {
                product / 255.0
            }
        },
    ),
    product("takes luminance without its sign", |l, c| {
        l.abs() * c / 255.0
    }),
    product("multiplies by 256 less the color", |l, c| {
        l * (256.0 - c) / 255.0
    }),
    product("multiplies by 255 less the color", |l, c| {
        l * (255.0 - c) / 255.0
    }),
    vector("limits Y to 255 before the matrix", |y, cr, cb| {
        [y.min(255.0), cr, cb]
    }),
    vector("limits Y to 0 and above before the matrix", |y, cr, cb| {
        [y.max(0.0), cr, cb]
    }),
    vector(
        "rounds Y to a whole number before the matrix",
        |y, cr, cb| [y.round(), cr, cb],
    ),
    vector("takes Y without its sign", |y, cr, cb| [y.abs(), cr, cb]),
    vector("multiplies Cr and Cb by Y / 255", |y, cr, cb| {
        [y, cr * y / 255.0, cb * y / 255.0]
    }),
    vector("multiplies Cr and Cb by Y", |y, cr, cb| [y, cr * y, cb * y]),
    vector("adds Y to Cr and Cb", |y, cr, cb| [y, cr + y, cb + y]),
    vector("subtracts Y from Cr and Cb", |y, cr, cb| {
        [y, cr - y, cb - y]
    }),
    vector("subtracts 127 from Cr and Cb", |y, cr, cb| {
        [y, cr - 127.0, cb - 127.0]
    }),
    vector("subtracts 127.5 from Cr and Cb", |y, cr, cb| {
        [y, cr - 127.5, cb - 127.5]
    }),
    vector("subtracts 128 from Y, Cr and Cb", |y, cr, cb| {
        [y - 128.0, cr - 128.0, cb - 128.0]
    }),
    vector("subtracts 16 from Y", |y, cr, cb| [y - 16.0, cr, cb]),
    vector("divides Y by 255", |y, cr, cb| [y / 255.0, cr, cb]),
    vector("divides Cr and Cb by 256", |y, cr, cb| {
        [y, cr / 256.0, cb / 256.0]
    }),
    vector("doubles Cr and Cb", |y, cr, cb| [y, 2.0 * cr, 2.0 * cb]),
    vector("takes Cr as a signed byte", |y, cr, cb| {
        [y, signed_byte(cr), cb]
    }),
    vector("takes Cb as a signed byte", |y, cr, cb| {
        [y, cr, signed_byte(cb)]
    }),
    vector("takes Cr for Cb", |y, cr, _| [y, cr, cr]),
    vector("takes Cb for Cr", |y, _, cb| [y, cb, cb]),
    matrix(
        "adds the translation to Y, Cr and Cb before the matrix",
        |m| {
            columns(m, [0, 4, 8, 12])
                .map(|[y, cr, cb, _]| [y, cr, cb, y * m.0[12] + cr * m.0[13] + cb * m.0[14]])
        },
    ),
    matrix("takes the column of Y one element too late", |m| {
        columns(m, [1, 4, 8, 12])
    }),
    matrix("takes the column of Cr one element too early", |m| {
        columns(m, [0, 3, 8, 12])
    }),
    matrix("takes the column of Cr one element too late", |m| {
        columns(m, [0, 5, 8, 12])
    }),
    matrix("takes the column of Cb one element too early", |m| {
        columns(m, [0, 4, 7, 12])
    }),
    matrix("takes the column of Cb one element too late", |m| {
        columns(m, [0, 4, 9, 12])
    }),
    matrix("takes the translation one element too early", |m| {
        columns(m, [0, 4, 8, 11])
    }),
    matrix("takes the translation one element too late", |m| {
        columns(m, [0, 4, 8, 13])
    }),
    matrix("takes columns of three elements", |m| {
        columns(m, [0, 3, 6, 9])
    }),
    matrix(
        "takes columns of three elements, and the translation where it is",
        |m| columns(m, [0, 3, 6, 12]),
    ),
    matrix("takes the columns in reverse order", |m| {
        columns(m, [12, 8, 4, 0])
    }),
    matrix("takes the rows of the matrix in reverse order", |m| {
        let [red, green, blue] = columns(m, [0, 4, 8, 12]);
        [blue, green, red]
    }),
    limits("shows 0 for colors over 255", |value| {
        if value > 255.0 { 0.0 } else { value.max(0.0) }
    }),
    limits("shows 255 for colors below 0", |value| {
        if value < -0.5 {
            255.0
        } else {
            value.min(255.0)
        }
    }),
    limits("limits colors to 254", |value| value.clamp(0.0, 254.0)),
    limits("limits colors to 1 and above", |value| {
        value.clamp(1.0, 255.0)
    }),
    limits("limits colors to 235", |value| value.clamp(0.0, 235.0)),
    limits("limits colors to 16…235", |value| {
        value.clamp(16.0, 235.0)
    }),
    limits(
        "limits colors at 255 and lets those below 0 wrap around",
        |value| {
            if value < 0.0 {
                value.rem_euclid(256.0).min(255.0)
            } else {
                value.min(255.0)
            }
        },
    ),
    limits(
        "limits colors at 0 and lets those over 255 wrap around",
        |value| value.max(0.0).rem_euclid(256.0).min(255.0),
    ),
    limits("shows colors below 0 without their sign", |value| {
        value.abs().min(255.0)
    }),
];

#[cfg(test)]
mod tests {
    use super::sum_and;
    use crate::diagnose::tests::first_cause;
    use crate::reading::Reading;

    #[test]
    fn a_limit_in_the_middle_of_a_formula_is_told() {
        let reading = Reading {
            polynomial: |a, u, v| {
                let linear = a[3] * u + a[4] * v + a[5].clamp(0.0, 255.0);
                a[0] * u * u + a[1] * v * v + a[2] * u * v + linear
            },
            ..Reading::SPEC
        };
        let told = first_cause(reading, |case| !case.format().is_compressed());
        assert!(told.contains("limits a5 to 0…255"), "{told}");
    }

    #[test]
    fn a_light_within_limits_and_a_sum_with_a_constant_are_told() {
        let limited = Reading {
            light: |u, v| (u.clamp(-0.7, 0.7), v.clamp(-0.7, 0.7)),
            ..Reading::SPEC
        };
        let more = Reading {
            polynomial: |a, u, v| sum_and(a, u, v, 2.0),
            ..Reading::SPEC
        };
        let default = Reading {
            light: |u, v| {
                if (u, v) == (0.0, 0.0) {
                    (0.5, 0.5)
                } else {
                    (u, v)
                }
            },
            ..Reading::SPEC
        };
        for (reading, says) in [
            (limited, "u and v were limited to ±0.7"),
            (default, "the light (0, 0) were (0.5, 0.5)"),
            (more, "adds 2 to the sum of the six terms"),
        ] {
            let told = first_cause(reading, |case| !case.format().is_compressed());
            assert!(told.contains(says), "{says}: {told}");
        }
    }
}
