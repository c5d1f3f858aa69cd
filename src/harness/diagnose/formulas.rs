//! Wrong pictures that come of one wrong number in a formula.
//!
//! Between stored values and colors stand three formulas of the text: (raw − bias) · scale, the polynomial, and for LUM the
//! matrix. Each number in them is exchanged for others that a slip of the pen may put there, and the picture made anew.

use super::witness::Witness;
use crate::harness::compare::{COLOR, is_close};
use crate::harness::protocol::{Frame, Samples, View};
use crate::ptm::{Planes, ScaleBias, Shape};
use crate::reading::Reading;

/// A formula of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Formula {
    /// 2.4
    Final,
    /// 1.0
    Polynomial,
    /// 2.6
    Matrix,
    /// 2.7.1
    Blocks,
    /// 2.7.3
    Color,
}

impl Formula {
    pub const fn clause(self) -> &'static str {
        match self {
            Formula::Final => "2.4/8",
            Formula::Polynomial => "1.0/1",
            Formula::Matrix => "2.6/4",
            Formula::Blocks => "2.7.1/2",
            Formula::Color => "2.7.3/4",
        }
    }

    /// What to compute.
    pub const fn mend(self) -> &'static str {
        match self {
            Formula::Final => "final value i = (raw value i − bias i) · scale i",
            Formula::Polynomial => "C = a0·u² + a1·v² + a2·u·v + a3·u + a4·v + a5",
            Formula::Matrix => "each color is its row of the matrix times (Y, Cr, Cb, 1)",
            Formula::Blocks => "red, green and blue have a polynomial each, in this order",
            Formula::Color => "color = L · RGB / 255, of each its own",
        }
    }
}

/// What is true of `shown`: the one number that is wrong in a formula, in words.
pub(super) fn slips(witness: &Witness, shown: &Frame) -> Vec<(Formula, String)> {
    if witness.finding.view == View::Raw {
        return Vec::new();
    }
    let Ok(ptm) = witness.decoded() else {
        return Vec::new();
    };
    let reading = &witness.reading;
    let right = Numbers::of(
        &ptm.planes,
        &ptm.header.scale_bias,
        &witness.finding.view,
        reading,
    );
    let slips = right.slips(ptm.planes.shape);
    let telling = slips
        .into_iter()
        .filter(|(_, _, wrong)| wrong.show(&ptm.planes, reading, shown));
    telling.map(|(formula, says, _)| (formula, says)).collect()
}

/// All numbers that stored values are combined with.
#[derive(Clone)]
struct Numbers {
    final_values: ScaleBias,
    /// What the six coefficients are multiplied by; nothing where final values are asked for.
    powers: Option<[f64; 6]>,
    /// u and v.
    light: (f64, f64),
    /// A row for each color.
    matrix: [[f64; 4]; 3],
    /// What the matrix multiplies: for each of its first three columns, which of Y, Cr and Cb, times what, and plus what.
    vector: [(usize, f64, f64); 3],
    /// Of which polynomial, or of which stored color, red, green and blue are made.
    colors: [usize; 3],
}

const COLORS: [&str; 3] = ["red", "green", "blue"];

fn scales(set: &mut ScaleBias) -> &mut [f64; 6] {
    &mut set.scale
}

fn biases(set: &mut ScaleBias) -> &mut [f64; 6] {
    &mut set.bias
}

impl Numbers {
    fn of(planes: &Planes, scale_bias: &ScaleBias, view: &View, reading: &Reading) -> Numbers {
        let light = match view {
            View::Rgb(light) => Some((light.lu, light.lv)),
            _ => None,
        };
        let matrix = match planes.shape {
            Shape::Lum(matrix) => (reading.lum_matrix)(&matrix)
                .map(|[y, cr, cb, t]| [y, cr, cb, (reading.lum_translation)(t)]),
            _ => [[0.0; 4]; 3],
        };
        Numbers {
            final_values: *scale_bias,
            powers: light.map(|(u, v)| [u * u, v * v, u * v, u, v, 1.0]),
            light: light.unwrap_or_default(),
            matrix,
            vector: [0, 1, 2].map(|which| (which, 1.0, 0.0)),
            colors: [0, 1, 2],
        }
    }

    /// Every slip: the formula, what is done in words, and the numbers with it.
    fn slips(&self, shape: Shape) -> Vec<(Formula, String, Numbers)> {
        let mut slips = Vec::new();
        let mut slip = |formula, says: String, change: &dyn Fn(&mut Numbers)| {
            let mut numbers = self.clone();
            change(&mut numbers);
            slips.push((formula, says, numbers));
        };
        let ScaleBias { scale, bias } = self.final_values;
        for i in 0..6 {
            let mut with = |says: String, part: fn(&mut ScaleBias) -> &mut [f64; 6], value: f64| {
                slip(Formula::Final, says, &|numbers| {
                    part(&mut numbers.final_values)[i] = value;
                });
            };
            with(format!("a{i} were not scaled"), scales, 1.0);
            with(
                format!("a{i} were scaled with the wrong sign"),
                scales,
                -scale[i],
            );
            for j in (0..6).filter(|&j| j != i) {
                with(format!("a{i} had the scale of a{j}"), scales, scale[j]);
            }
            with(format!("the bias of a{i} were not subtracted"), biases, 0.0);
            with(format!("the bias of a{i} were added"), biases, -bias[i]);
            for j in (0..6).filter(|&j| j != i) {
                with(format!("a{i} had the bias of a{j}"), biases, bias[j]);
            }
        }
        let Some(powers) = self.powers else {
            return slips;
        };
        let (u, v) = self.light;
        let names = ["u²", "v²", "u·v", "u", "v", "1"];
        let others = [("2·u", 2.0 * u), ("2·v", 2.0 * v), ("u + v", u + v)];
        for (i, right) in names.into_iter().enumerate() {
            let mut times = |says: String, value: f64| {
                slip(Formula::Polynomial, says, &|numbers| {
                    numbers.powers = Some(powers).map(|mut powers| {
                        powers[i] = value;
                        powers
                    });
                });
            };
            times(format!("a{i} were left out"), 0.0);
            times(format!("a{i} were subtracted"), -powers[i]);
            times(format!("a{i} were added twice"), 2.0 * powers[i]);
            times(format!("half of a{i} were added"), powers[i] / 2.0);
            for (name, value) in names.into_iter().zip(powers).chain(others) {
                if name != right {
                    times(
                        format!("a{i} were multiplied by {name} where {right} belongs"),
                        value,
                    );
                }
            }
        }
        let colors = match shape {
            Shape::Rgb => Some(Formula::Blocks),
            Shape::Lrgb => Some(Formula::Color),
            Shape::Lum(_) => None,
        };
        if let Some(formula) = colors {
            for digits in 0..27 {
                let colors = [digits / 9, digits / 3 % 3, digits % 3];
                let [red, green, blue] = colors.map(|color| COLORS[color]);
                let says = format!("red, green and blue were {red}, {green} and {blue}");
                if colors != self.colors {
                    slip(formula, says, &|numbers| numbers.colors = colors);
                }
            }
            return slips;
        }
        let values = ["Y", "Cr", "Cb"];
        for (i, name) in values.into_iter().enumerate() {
            let mut taken = |says: String, term: (usize, f64, f64)| {
                slip(Formula::Matrix, says, &|numbers| numbers.vector[i] = term);
            };
            taken(format!("{name} were left out"), (i, 0.0, 0.0));
            taken(format!("{name} were subtracted"), (i, -1.0, 0.0));
            taken(format!("{name} were 1"), (i, 0.0, 1.0));
            taken(format!("{name} were 128 less"), (i, 1.0, -128.0));
            for (j, other) in values.into_iter().enumerate().filter(|&(j, _)| j != i) {
                taken(format!("{name} were {other}"), (j, 1.0, 0.0));
            }
        }
        for (column, name) in values.into_iter().enumerate() {
            let says = format!("the factors of {name} were 1");
            slip(Formula::Matrix, says, &|numbers| {
                for row in &mut numbers.matrix {
                    row[column] = 1.0;
                }
            });
        }
        let columns = [
            "the factor of Y",
            "the factor of Cr",
            "the factor of Cb",
            "the translation",
        ];
        for row in 0..3 {
            for column in 0..4 {
                let name =
                    |row: usize, column: usize| format!("{} in {}", columns[column], COLORS[row]);
                let own = name(row, column);
                let mut element = |says: String, value: f64| {
                    slip(Formula::Matrix, says, &|numbers| {
                        numbers.matrix[row][column] = value;
                    });
                };
                element(format!("{own} were left out"), 0.0);
                element(
                    format!("{own} had the wrong sign"),
                    -self.matrix[row][column],
                );
                for other in (0..12).filter(|&other| other != 4 * row + column) {
                    let says = format!("{own} were {}", name(other / 4, other % 4));
                    element(says, self.matrix[other / 4][other % 4]);
                }
            }
        }
        slips
    }

    /// Whether these numbers make the picture that was shown.
    fn show(&self, planes: &Planes, reading: &Reading, shown: &Frame) -> bool {
        let width = shown.channels as usize;
        planes.texels().enumerate().all(|(texel, raw)| {
            let made = self.texel(raw, planes.shape, reading);
            let place = texel * width;
            made.len() == width
                && match &shown.samples {
                    Samples::F32(values) => {
                        values.get(place..place + width).is_some_and(|values| {
                            let mut pairs = made.iter().zip(values);
                            pairs.all(|(&made, &shown)| is_close(made, f64::from(shown), 0.0))
                        })
                    }
                    Samples::U8(values) => values.get(place..place + width).is_some_and(|values| {
                        let mut pairs = made.iter().zip(values);
                        pairs.all(|(&made, &shown)| (made - f64::from(shown)).abs() <= COLOR)
                    }),
                }
        })
    }

    /// One texel: its final values, or its color.
    fn texel(&self, raw: &[u8], shape: Shape, reading: &Reading) -> Vec<f64> {
        let finals: Vec<f64> = raw
            .iter()
            .enumerate()
            .map(|(channel, &raw)| match channel < shape.coefficients() {
                true => (reading.final_coefficient)(raw, channel, &self.final_values),
                false => f64::from(raw),
            })
            .collect();
        let Some(powers) = self.powers else {
            return finals;
        };
        let polynomial =
            |a: &[f64]| -> f64 { a.iter().zip(powers).map(|(a, power)| a * power).sum() };
        let color: Vec<f64> = match shape {
            Shape::Rgb => {
                let block = |color: usize| &finals[6 * color..6 * color + 6];
                let colors = self.colors.iter();
                colors.map(|&color| polynomial(block(color))).collect()
            }
            Shape::Lrgb => {
                let luminance = polynomial(&finals[..6]);
                let colors = self.colors.iter();
                colors
                    .map(|&color| (reading.modulate)(luminance, finals[6 + color]))
                    .collect()
            }
            Shape::Lum(_) => {
                let stored = [polynomial(&finals[..6]), finals[6], finals[7]];
                let [y, cr, cb] = self
                    .vector
                    .map(|(which, factor, offset)| stored[which] * factor + offset);
                let [p, q, r] = (reading.lum_vector)(y, cr, cb);
                let rows = self.matrix.iter();
                rows.map(|[m0, m1, m2, t]| m0 * p + m1 * q + m2 * r + t)
                    .collect()
            }
        };
        color.into_iter().map(reading.clamp).collect()
    }
}
