//! Wrong numbers in the formulas of the text.
//!
//! Between stored values and colors stand three formulas: (raw − bias) · scale, the polynomial, and for LUM the matrix. Each
//! number in them is exchanged for others that a slip may put there, and the picture computed again. Where several numbers
//! of the polynomial are wrong at once, least squares over the texels say what each coefficient was multiplied by.

use std::f64::consts::FRAC_PI_2;

use crate::protocol::frame::{Frame, Samples, View};
use crate::ptm::{Planes, Ptm, ScaleBias, Shape};
use crate::reading::Reading;
use crate::suite::compare::{COLOR, is_close};

/// A formula of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::diagnose) enum Formula {
    /// 2.4
    Final,
    /// 1.0
    Light,
    /// 1.0
    Polynomial,
    /// 2.6
    Matrix,
    /// 2.7.1
    Blocks,
    /// 2.7.3
    Color,
    /// 2.7.3
    Limits,
}

impl Formula {
    pub const fn clause(self) -> &'static str {
        match self {
            Formula::Final => "2.4/8",
            Formula::Light => "1.0/2",
            Formula::Polynomial => "1.0/1",
            Formula::Matrix => "2.6/4",
            Formula::Blocks => "2.7.1/2",
            Formula::Color => "2.7.3/4",
            Formula::Limits => "2.7.3/5",
        }
    }

    /// What to compute.
    pub const fn fix(self) -> &'static str {
        match self {
            Formula::Final => "final value i = (raw value i − bias i) · scale i",
            Formula::Light => {
                "use u and v as they are given, with sign and fraction: +u points to the right, +v up"
            }
            Formula::Polynomial => "C = a0·u² + a1·v² + a2·u·v + a3·u + a4·v + a5",
            Formula::Matrix => "each color is its row of the matrix times (Y, Cr, Cb, 1)",
            Formula::Blocks => "red, green and blue have a polynomial each, in this order",
            Formula::Color => "color = L · RGB / 255, of each its own",
            Formula::Limits => "limit colors to 0…255, at the very end and nowhere else",
        }
    }
}

/// A wrong number: in which formula, in words, and all numbers with it.
type Slip = (Formula, String, Numbers);

/// All numbers that stored values are combined with.
#[derive(Clone)]
pub(in crate::diagnose) struct Numbers {
    final_values: ScaleBias,
    /// What the six coefficients are multiplied by; nothing where final values are asked for.
    powers: Option<[f64; 6]>,
    /// u and v.
    light: (f64, f64),
    polynomial: fn(&[f64], f64, f64) -> f64,
    /// A row for each color.
    matrix: [[f64; 4]; 3],
    /// What the matrix multiplies: for each of its first three columns, which of Y, Cr and Cb, times what, and plus what.
    vector: [(usize, f64, f64); 3],
    /// The color that luminance and a stored color make.
    modulate: fn(f64, f64) -> f64,
    /// Of which polynomial, or of which stored color, red, green and blue are made.
    colors: [usize; 3],
    /// The coefficient that every polynomial takes from one of the three, and from which.
    borrowed: Option<(usize, usize)>,
}

const COLORS: [&str; 3] = ["red", "green", "blue"];
const POWERS: [&str; 6] = ["u²", "v²", "u·v", "u", "v", "1"];

impl Numbers {
    pub fn of(planes: &Planes, scale_bias: &ScaleBias, view: &View, reading: &Reading) -> Numbers {
        let light = match view {
            View::Rgb(light) => Some((reading.light)(light.lu, light.lv)),
            _ => None,
        };
        let matrix = match planes.shape {
            Shape::Lum(matrix) => (reading.lum_matrix)(&matrix)
                .map(|[y, cr, cb, t]| [y, cr, cb, (reading.lum_translation)(t)]),
            _ => [[0.0; 4]; 3],
        };
        let power = |i: usize, u, v| {
            let mut unit = [0.0; 6];
            unit[i] = 1.0;
            (reading.polynomial)(&unit, u, v)
        };
        Numbers {
            final_values: *scale_bias,
            powers: light.map(|(u, v)| [0, 1, 2, 3, 4, 5].map(|i| power(i, u, v))),
            polynomial: reading.polynomial,
            light: light.unwrap_or_default(),
            matrix,
            vector: [0, 1, 2].map(|which| (which, 1.0, 0.0)),
            modulate: reading.modulate,
            colors: [0, 1, 2],
            borrowed: None,
        }
    }

    /// These numbers with the slips of these names, one after the other.
    pub fn with(&self, names: &[&str], shape: Shape) -> Numbers {
        names.iter().fold(self.clone(), |numbers, name| {
            let slips = numbers.slips(shape);
            let found = slips.into_iter().find(|(_, says, _)| says == name);
            found.map_or(numbers, |(.., wrong)| wrong)
        })
    }

    /// These numbers with one of them changed.
    fn changed(&self, change: impl FnOnce(&mut Numbers)) -> Numbers {
        let mut numbers = self.clone();
        change(&mut numbers);
        numbers
    }

    /// Every slip.
    pub fn slips(&self, shape: Shape) -> Vec<Slip> {
        let mut slips = self.slips_of_finals();
        if let Some(powers) = self.powers {
            slips.extend(self.slips_of_light());
            slips.extend(self.slips_of_powers(powers));
            match shape {
                Shape::Rgb => {
                    slips.extend(self.slips_of_colors(Formula::Blocks));
                    slips.extend(self.slips_of_blocks());
                }
                Shape::Lrgb => {
                    slips.extend(self.slips_of_colors(Formula::Color));
                    slips.extend(self.slips_of_modulation());
                }
                Shape::Lum(_) => {
                    slips.extend(self.slips_of_vector());
                    slips.extend(self.slips_of_matrix());
                }
            }
        }
        slips
    }

    fn slips_of_finals(&self) -> Vec<Slip> {
        let ScaleBias { scale, bias } = self.final_values;
        let scaled = |i: usize, says: String, value: f64| {
            let wrong = self.changed(|numbers| numbers.final_values.scale[i] = value);
            (Formula::Final, says, wrong)
        };
        let biased = |i: usize, says: String, value: f64| {
            let wrong = self.changed(|numbers| numbers.final_values.bias[i] = value);
            (Formula::Final, says, wrong)
        };
        let of = |i: usize| {
            let mut slips = vec![
                scaled(i, format!("a{i} were not scaled"), 1.0),
                scaled(
                    i,
                    format!("a{i} were scaled with the wrong sign"),
                    -scale[i],
                ),
                scaled(i, format!("a{i} were divided by its scale"), 1.0 / scale[i]),
                scaled(i, format!("a{i} were scaled twice"), scale[i] * scale[i]),
                biased(i, format!("the bias of a{i} were not subtracted"), 0.0),
                biased(i, format!("the bias of a{i} were added"), -bias[i]),
                biased(
                    i,
                    format!("the bias of a{i} were subtracted twice"),
                    2.0 * bias[i],
                ),
                biased(
                    i,
                    format!("a{i} were scaled before its bias is subtracted"),
                    bias[i] / scale[i],
                ),
            ];
            for j in (0..6).filter(|&j| j != i) {
                slips.push(scaled(i, format!("a{i} had the scale of a{j}"), scale[j]));
                slips.push(biased(i, format!("a{i} had the bias of a{j}"), bias[j]));
            }
            slips
        };
        (0..6).flat_map(of).collect()
    }

    fn slips_of_light(&self) -> Vec<Slip> {
        let (u, v) = self.light;
        let changes: [(&str, fn(f64) -> f64); 13] = [
            ("|w|", f64::abs),
            ("−w", |w| -w),
            ("0", |_| 0.0),
            ("1", |_| 1.0),
            ("2·w", |w| 2.0 * w),
            ("w / 2", |w| w / 2.0),
            ("(w + 1) / 2", |w| f64::midpoint(w, 1.0)),
            ("w², with the sign of w", |w| w * w.abs()),
            ("w, but 0 for w < 0", |w| w.max(0.0)),
            ("1 − w", |w| 1.0 - w),
            ("sin(w)", f64::sin),
            ("sin(w · 90°)", |w| (w * FRAC_PI_2).sin()),
            ("the arc sine of w", f64::asin),
        ];
        let one = |name: &str, of: &str| name.replace('w', of);
        let mut lights: Vec<(String, (f64, f64))> = Vec::new();
        for (name, change) in changes {
            lights.push((format!("u were {}", one(name, "u")), (change(u), v)));
            lights.push((format!("v were {}", one(name, "v")), (u, change(v))));
            lights.push((
                format!("u were {} and v were {}", one(name, "u"), one(name, "v")),
                (change(u), change(v)),
            ));
        }
        lights.extend(lights_together(u, v));
        let slip = |(says, (u, v)): (String, (f64, f64))| {
            let power = |i: usize| {
                let mut unit = [0.0; 6];
                unit[i] = 1.0;
                (self.polynomial)(&unit, u, v)
            };
            let wrong =
                self.changed(|numbers| numbers.powers = Some([0, 1, 2, 3, 4, 5].map(power)));
            (Formula::Light, says, wrong)
        };
        lights.into_iter().map(slip).collect()
    }

    fn slips_of_powers(&self, powers: [f64; 6]) -> Vec<Slip> {
        let (u, v) = self.light;
        let others = [
            ("2·u", 2.0 * u),
            ("2·v", 2.0 * v),
            ("u + v", u + v),
            ("u − v", u - v),
            ("|u|", u.abs()),
            ("|v|", v.abs()),
            ("|u·v|", (u * v).abs()),
            ("2·|u·v|", 2.0 * (u * v).abs()),
            ("u² + v²", u * u + v * v),
            ("u³", u * u * u),
            ("v³", v * v * v),
        ];
        let times = |i: usize, says: String, value: f64| {
            let wrong = self.changed(|numbers| {
                numbers.powers = Some(powers).map(|mut powers| {
                    powers[i] = value;
                    powers
                });
            });
            (Formula::Polynomial, says, wrong)
        };
        let of = |i: usize| {
            let mut slips = vec![
                times(i, format!("a{i} were left out"), 0.0),
                times(i, format!("a{i} were subtracted"), -powers[i]),
                times(i, format!("a{i} were added twice"), 2.0 * powers[i]),
                times(i, format!("half of a{i} were added"), powers[i] / 2.0),
            ];
            for (name, value) in POWERS.into_iter().zip(powers).chain(others) {
                if name != POWERS[i] {
                    let says =
                        format!("a{i} were multiplied by {name} where {} belongs", POWERS[i]);
                    slips.push(times(i, says, value));
                }
            }
            slips
        };
        let mut slips: Vec<Slip> = (0..6).flat_map(of).collect();
        for (i, j) in (0..36).map(|pair| (pair / 6, pair % 6)) {
            if i != j {
                let mut taken = powers;
                taken[j] += taken[i];
                taken[i] = 0.0;
                let says = format!(
                    "a{j} were multiplied by {} too, in place of a{i}",
                    POWERS[i]
                );
                let wrong = self.changed(|numbers| numbers.powers = Some(taken));
                slips.push((Formula::Polynomial, says, wrong));
            }
        }
        slips
    }

    fn slips_of_blocks(&self) -> Vec<Slip> {
        let all = (0..18).map(|channel| (channel % 6, channel / 6));
        all.map(|(i, color)| {
            let says = format!("a{i} of every color were a{i} of {}", COLORS[color]);
            let wrong = self.changed(|numbers| numbers.borrowed = Some((i, color)));
            (Formula::Blocks, says, wrong)
        })
        .collect()
    }

    fn slips_of_colors(&self, formula: Formula) -> Vec<Slip> {
        let all = (0..27).map(|digits| [digits / 9, digits / 3 % 3, digits % 3]);
        all.filter(|&colors| colors != self.colors)
            .map(|colors| {
                let [red, green, blue] = colors.map(|color| COLORS[color]);
                let says = format!("red, green and blue were {red}, {green} and {blue}");
                (
                    formula,
                    says,
                    self.changed(|numbers| numbers.colors = colors),
                )
            })
            .collect()
    }

    fn slips_of_modulation(&self) -> Vec<Slip> {
        let products: [(&str, fn(f64, f64) -> f64); 9] = [
            ("L alone", |l, _| l),
            ("the stored color alone", |_, c| c),
            ("L² · RGB / 255²", |l, c| l * l * c / 65025.0),
            ("L · RGB² / 255²", |l, c| l * c * c / 65025.0),
            ("L · RGB / 128", |l, c| l * c / 128.0),
            ("L · RGB / 100", |l, c| l * c / 100.0),
            ("L + RGB", |l, c| l + c),
            ("the mean of L and RGB", f64::midpoint),
            ("L, clamped to 0…255, · RGB / 255", |l, c| {
                l.clamp(0.0, 255.0) * c / 255.0
            }),
        ];
        let slip = |(says, modulate): (&str, _)| {
            let wrong = self.changed(|numbers| numbers.modulate = modulate);
            (Formula::Color, format!("a color were {says}"), wrong)
        };
        products.into_iter().map(slip).collect()
    }

    fn slips_of_vector(&self) -> Vec<Slip> {
        let values = ["Y", "Cr", "Cb"];
        let mut slips = Vec::new();
        for (i, name) in values.into_iter().enumerate() {
            let mut taken = |says: String, term: (usize, f64, f64)| {
                let wrong = self.changed(|numbers| numbers.vector[i] = term);
                slips.push((Formula::Matrix, says, wrong));
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
            let wrong = self.changed(|numbers| {
                for row in &mut numbers.matrix {
                    row[column] = 1.0;
                }
            });
            slips.push((
                Formula::Matrix,
                format!("the factors of {name} were 1"),
                wrong,
            ));
            for (other, of) in values
                .into_iter()
                .enumerate()
                .filter(|&(other, _)| other != column)
            {
                let wrong = self.changed(|numbers| {
                    for row in &mut numbers.matrix {
                        row[column] = row[other];
                    }
                });
                let says = format!("the factors of {name} were those of {of}");
                slips.push((Formula::Matrix, says, wrong));
            }
        }
        slips
    }

    fn slips_of_matrix(&self) -> Vec<Slip> {
        let columns = [
            "the factor of Y",
            "the factor of Cr",
            "the factor of Cb",
            "the translation",
        ];
        let name = |row: usize, column: usize| format!("{} in {}", columns[column], COLORS[row]);
        let mut slips = Vec::new();
        for place in 0..12 {
            let (row, column) = (place / 4, place % 4);
            let mut element = |says: String, value: f64| {
                let wrong = self.changed(|numbers| numbers.matrix[row][column] = value);
                slips.push((Formula::Matrix, says, wrong));
            };
            let own = name(row, column);
            element(format!("{own} were left out"), 0.0);
            element(
                format!("{own} had the wrong sign"),
                -self.matrix[row][column],
            );
            for other in (0..12).filter(|&other| other != place) {
                let says = format!("{own} were {}", name(other / 4, other % 4));
                element(says, self.matrix[other / 4][other % 4]);
            }
        }
        slips
    }

    /// Whether these numbers make the picture that was received.
    pub fn make(&self, planes: &Planes, reading: &Reading, received: &Frame) -> bool {
        let width = received.channels as usize;
        let texels = planes.size.texels();
        let is_near = |made: &[f64], place: usize| match &received.samples {
            Samples::F32(values) => {
                let mut pairs = made.iter().zip(&values[place..place + width]);
                pairs.all(|(&made, &value)| is_close(made, f64::from(value), 0.0))
            }
            Samples::U8(values) => {
                let mut pairs = made.iter().zip(&values[place..place + width]);
                pairs.all(|(&made, &value)| (made - f64::from(value)).abs() <= COLOR)
            }
        };
        let count = match &received.samples {
            Samples::F32(values) => values.len(),
            Samples::U8(values) => values.len(),
        };
        count == texels * width
            && planes.texels().enumerate().all(|(texel, raw)| {
                let made = self.texel(raw, planes.shape, reading);
                made.len() == width && is_near(&made, texel * width)
            })
    }

    /// The final values or colors that these numbers make, not rounded.
    pub fn values(&self, planes: &Planes, reading: &Reading) -> Vec<f64> {
        let texels = planes.texels();
        texels
            .flat_map(|raw| self.texel(raw, planes.shape, reading))
            .collect()
    }

    /// The picture that these numbers make.
    pub fn frame(&self, planes: &Planes, reading: &Reading, view: &View) -> Frame {
        let values = self.values(planes, reading).into_iter();
        let (channels, samples) = match view {
            View::Rgb(_) => (
                3,
                Samples::U8(values.map(|value| value.round() as u8).collect()),
            ),
            _ => (
                planes.shape.channels() as u32,
                Samples::F32(values.map(|value| value as f32).collect()),
            ),
        };
        Frame {
            view: view.name(),
            width: planes.size.width,
            height: planes.size.height,
            channels,
            samples,
            lossy: false,
        }
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
                let block = |&color: &usize| {
                    let mut block = finals[6 * color..6 * color + 6].to_vec();
                    if let Some((i, other)) = self.borrowed {
                        block[i] = finals[6 * other + i];
                    }
                    polynomial(&block)
                };
                self.colors.iter().map(block).collect()
            }
            Shape::Lrgb => {
                let luminance = polynomial(&finals[..6]);
                let colors = self.colors.iter();
                colors
                    .map(|&color| (self.modulate)(luminance, finals[6 + color]))
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

/// Limits of u and v, and of the length of a light, that decoders have.
const LIMITS: [f64; 9] = [0.25, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9, 0.95, 0.99];

/// What decoders take where no light is given, and then for a light of 0 too.
const DEFAULTS: [(f64, f64); 10] = [
    (0.5, 0.5),
    (0.5, 0.0),
    (0.0, 0.5),
    (1.0, 0.0),
    (0.0, 1.0),
    (1.0, 1.0),
    (0.7, 0.7),
    (-0.5, 0.5),
    (0.3, 0.3),
    (0.1, 0.1),
];

/// Lights in whose place u and v are changed together, in words and as numbers.
fn lights_together(u: f64, v: f64) -> Vec<(String, (f64, f64))> {
    let cut = |x: f64, parts: f64| (x * parts).trunc() / parts;
    let rounded = |x: f64, parts: f64| (x * parts).round() / parts;
    let length = u.hypot(v).max(f64::MIN_POSITIVE);
    let height = (1.0 - u * u - v * v).max(0.0).sqrt();
    let longer = (1.0 + u * u + v * v).sqrt();
    let mut lights = vec![
        ("u were v and v were u".to_owned(), (v, u)),
        ("u were v".to_owned(), (v, v)),
        ("v were u".to_owned(), (u, u)),
        (
            "the light (u, v) had length 1".to_owned(),
            (u / length, v / length),
        ),
        (
            "the light were divided by √(u² + v² + 1)".to_owned(),
            (u / longer, v / longer),
        ),
        (
            "the light were multiplied by √(1 − u² − v²)".to_owned(),
            (u * height, v * height),
        ),
    ];
    for least in [0.01, 0.02, 0.03, 0.05, 0.1] {
        let dead = |x: f64| if x.abs() < least { 0.0 } else { x };
        let says = |what: &str| format!("{what} 0 where they are less than {least} from it");
        lights.push((says("u and v were"), (dead(u), dead(v))));
        let says = |what: &str| format!("{what} 0 where it is less than {least} from it");
        lights.push((says("u were"), (dead(u), v)));
        lights.push((says("v were"), (u, dead(v))));
    }
    for factor in [2.0, 1.5] {
        let more = |x: f64| (x * factor).min(1.0);
        let says = |which: &str| format!("{which} {factor} times what they are, 1 at the most");
        lights.push((says("u and v were"), (more(u), more(v))));
        let says = |which: &str| format!("{which} were {factor} times what it is, 1 at the most");
        lights.push((says("u"), (more(u), v)));
        lights.push((says("v"), (u, more(v))));
    }
    for (decimals, parts) in [
        ("one decimal", 10.0),
        ("two decimals", 100.0),
        ("three decimals", 1000.0),
    ] {
        let says = |how: &str| format!("u and v were {how} {decimals}");
        lights.push((says("cut off after"), (cut(u, parts), cut(v, parts))));
        lights.push((says("rounded to"), (rounded(u, parts), rounded(v, parts))));
    }
    lights.extend(stepped_lights(u, v));
    lights.extend(limited_lights(u, v));
    lights.extend(DEFAULTS.map(|(a, b)| {
        let light = if (u, v) == (0.0, 0.0) { (a, b) } else { (u, v) };
        (format!("the light (0, 0) were ({a}, {b})"), light)
    }));
    lights
}

/// Lights of which u, v or both are made multiples of a step.
fn stepped_lights(u: f64, v: f64) -> Vec<(String, (f64, f64))> {
    let mut lights = Vec::new();
    for parts in [8, 16, 20, 32, 64, 127, 128, 255, 256] {
        let says = |how: &str| format!("{how} multiples of 1/{parts}");
        let parts = f64::from(parts);
        let cut = |x: f64| (x * parts).trunc() / parts;
        let rounded = |x: f64| (x * parts).round() / parts;
        let floored = |x: f64| (x * parts).floor() / parts;
        let ways: [(&str, (f64, f64)); 3] = [
            ("cut to", (cut(u), cut(v))),
            ("rounded to", (rounded(u), rounded(v))),
            ("rounded down to", (floored(u), floored(v))),
        ];
        for (how, (cut_u, cut_v)) in ways {
            lights.push((format!("u and v were {}", says(how)), (cut_u, cut_v)));
            lights.push((format!("u were {}", says(how)), (cut_u, v)));
            lights.push((format!("v were {}", says(how)), (u, cut_v)));
        }
    }
    lights
}

/// Lights that are kept within limits.
fn limited_lights(u: f64, v: f64) -> Vec<(String, (f64, f64))> {
    let length = u.hypot(v).max(f64::MIN_POSITIVE);
    let mut lights = Vec::new();
    for most in LIMITS {
        let within = |x: f64| x.clamp(-most, most);
        let shorter = (most / length).min(1.0);
        let whole = (most / length).floor().min(1.0);
        lights.extend([
            (
                format!("u and v were limited to ±{most}"),
                (within(u), within(v)),
            ),
            (format!("u were limited to ±{most}"), (within(u), v)),
            (format!("v were limited to ±{most}"), (u, within(v))),
            (format!("u were {most} at the most"), (u.min(most), v)),
            (format!("v were {most} at the most"), (u, v.min(most))),
            (format!("u were −{most} at the least"), (u.max(-most), v)),
            (format!("v were −{most} at the least"), (u, v.max(-most))),
            (
                format!("a light (u, v) longer than {most} were brought to that length"),
                (u * shorter, v * shorter),
            ),
            (
                format!("a light (u, v) longer than {most} were (0, 0)"),
                (u * whole, v * whole),
            ),
        ]);
    }
    lights
}

/// Single slips that make the picture that was received.
pub(in crate::diagnose) fn single_slips(
    ptm: &Ptm,
    view: &View,
    reading: &Reading,
    received: &Frame,
) -> Vec<(Formula, String)> {
    if *view == View::Raw {
        return Vec::new();
    }
    let right = Numbers::of(&ptm.planes, &ptm.header.scale_bias, view, reading);
    let slips = right.slips(ptm.planes.shape).into_iter();
    slips
        .filter(|(.., wrong)| wrong.make(&ptm.planes, reading, received))
        .map(|(formula, says, _)| (formula, says))
        .collect()
}

/// Fewest texels for least squares.
const TEXELS: usize = 10;
/// Terms that may be wrong at once, and candidates for each.
const TERMS: usize = 4;

/// Slips of several terms of the polynomial at once that make the picture: solved by least squares for what each
/// coefficient was multiplied by.
pub(in crate::diagnose) fn joint_slips(
    ptm: &Ptm,
    view: &View,
    reading: &Reading,
    received: &Frame,
) -> Vec<Vec<(Formula, String)>> {
    let (View::Rgb(_), Samples::U8(bytes)) = (view, &received.samples) else {
        return Vec::new();
    };
    let planes = &ptm.planes;
    let right = Numbers::of(planes, &ptm.header.scale_bias, view, reading);
    if bytes.len() != planes.size.texels() * 3 {
        return Vec::new();
    }
    let Some((weights, errors)) = weights(ptm, bytes) else {
        return Vec::new();
    };
    let made = |numbers: &Numbers, i: usize| {
        numbers.powers.map_or(0.0, |powers| powers[i]) * numbers.final_values.scale[i]
    };
    let slips = right.slips(planes.shape);
    let is_off = |i: usize, numbers: &Numbers| {
        (made(numbers, i) - weights[i]).abs() > 5.0 * errors[i] + 1e-4
    };
    let wrong: Vec<usize> = (0..6).filter(|&i| is_off(i, &right)).collect();
    if wrong.is_empty() || wrong.len() > TERMS {
        return Vec::new();
    }
    // Of each wrong term all slips that give it the weight that was solved.
    let mut groups: Vec<Vec<(Formula, String)>> = vec![Vec::new()];
    for &i in &wrong {
        let name = format!("a{i} ");
        let fitting = slips.iter().filter(|(formula, says, numbers)| {
            matches!(formula, Formula::Polynomial | Formula::Final)
                && says.contains(&name)
                && !is_off(i, numbers)
        });
        let fitting: Vec<(Formula, String)> = fitting
            .map(|(formula, says, _)| (*formula, says.clone()))
            .take(TERMS)
            .collect();
        groups = groups
            .iter()
            .flat_map(|group| {
                fitting.iter().map(|slip| {
                    let mut group = group.clone();
                    group.push(slip.clone());
                    group
                })
            })
            .collect();
    }
    groups.retain(|group| {
        let names: Vec<&str> = group.iter().map(|(_, says)| says.as_str()).collect();
        right
            .with(&names, planes.shape)
            .make(planes, reading, received)
    });
    groups
}

/// What each raw coefficient was multiplied by, and how far that may be off: least squares over the samples that are
/// not clamped. Six weights and a constant.
pub(in crate::diagnose) fn weights(ptm: &Ptm, bytes: &[u8]) -> Option<([f64; 7], [f64; 7])> {
    let mut normal = [[0.0; 8]; 7];
    let mut count = 0;
    for (texel, raw) in ptm.planes.texels().enumerate() {
        for color in 0..3 {
            let received = f64::from(bytes[texel * 3 + color]);
            if !(1.0..=254.0).contains(&received) {
                continue;
            }
            let (first, factor) = match ptm.planes.shape {
                Shape::Rgb => (6 * color, 1.0),
                Shape::Lrgb => (0, f64::from(raw[6 + color]) / 255.0),
                Shape::Lum(_) => return None,
            };
            let mut row = [factor; 8];
            for i in 0..6 {
                row[i] = f64::from(raw[first + i]) * factor;
            }
            row[7] = received;
            count += 1;
            for i in 0..7 {
                for j in 0..8 {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }
    }
    (count >= TEXELS).then(|| solve(&normal))?
}

/// Gauss and Jordan: the solution, and the error of each of its numbers where each sample is rounded.
fn solve(normal: &[[f64; 8]; 7]) -> Option<([f64; 7], [f64; 7])> {
    let mut rows = [[0.0; 15]; 7];
    for (i, row) in rows.iter_mut().enumerate() {
        row[..8].copy_from_slice(&normal[i]);
        row[8 + i] = 1.0;
    }
    for column in 0..7 {
        let pivot =
            (column..7).max_by(|&a, &b| rows[a][column].abs().total_cmp(&rows[b][column].abs()))?;
        if rows[pivot][column].abs() < 1e-6 {
            return None;
        }
        rows.swap(column, pivot);
        let divisor = rows[column][column];
        rows[column].iter_mut().for_each(|value| *value /= divisor);
        let top = rows[column];
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != column) {
            let factor = row[column];
            for (value, top) in row.iter_mut().zip(top) {
                *value -= factor * top;
            }
        }
    }
    // Rounding a color is an error of 0.29 on average.
    let error = |i: usize| 0.29 * rows[i][8 + i].max(0.0).sqrt();
    let all = [0, 1, 2, 3, 4, 5, 6];
    Some((all.map(|i| rows[i][7]), all.map(error)))
}
