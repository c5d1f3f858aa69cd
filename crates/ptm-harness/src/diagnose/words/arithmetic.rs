//! Formats the computation of one value, with the numbers in the file.

use crate::diagnose::witness::Witness;
use ptm::{Ptm, Shape};
use ptm_suite::compare;
use ptm_suite::protocol::frame::View;

/// Formats the computation of a value in an image from stored values. Returns `None` if the value itself is stored.
pub(in crate::diagnose) fn format_arithmetic(
    witness: &Witness,
    texel: usize,
    channel: usize,
) -> Option<String> {
    let ptm = witness.decoded().as_ref().ok()?;
    format_steps(ptm, &witness.observation.view, texel, channel)
}

/// Formats the computation of a value in a view of a map. Returns `None` if the value itself is stored.
#[must_use]
pub fn format_steps(ptm: &Ptm, view: &View, texel: usize, channel: usize) -> Option<String> {
    let raw = ptm.planes.texels().nth(texel)?;
    match view {
        View::Coef if channel < ptm.planes.shape.coefficients() => {
            Some(format_final_value(ptm, raw, channel))
        }
        View::Rgb(light) => Some(format_color(ptm, raw, channel, (light.lu, light.lv))),
        _ => None,
    }
}

fn format_final_value(ptm: &Ptm, raw: &[u8], channel: usize) -> String {
    let numbers = &ptm.header.scale_bias;
    format!(
        "({} − {}) · {}",
        raw[channel],
        exact_number(numbers.bias[channel % 6]),
        exact_number(numbers.scale[channel % 6])
    )
}

fn format_color(ptm: &Ptm, raw: &[u8], color: usize, (u, v): (f64, f64)) -> String {
    let numbers = &ptm.header.scale_bias;
    let first = match ptm.planes.shape {
        Shape::Rgb => 6 * color,
        _ => 0,
    };
    let a: Vec<f64> = (0..6)
        .map(|i| (f64::from(raw[first + i]) - numbers.bias[i]) * numbers.scale[i])
        .collect();
    let powers = [u * u, v * v, u * v, u, v, 1.0];
    let sum: f64 = a.iter().zip(powers).map(|(a, power)| a * power).sum();
    let terms: Vec<String> = a
        .iter()
        .zip(powers)
        .map(|(a, power)| format!("{}·{}", rounded_number(*a), rounded_number(power)))
        .collect();
    let polynomial = format!(
        "a0·u² + a1·v² + a2·u·v + a3·u + a4·v + a5 = {}",
        terms.join(" + ")
    );
    match &ptm.planes.shape {
        Shape::Rgb => polynomial,
        Shape::Lrgb => format!(
            "L · {} / 255 with L = {} = {polynomial}",
            raw[6 + color],
            short_number(sum)
        ),
        Shape::Lum(matrix) => {
            let row = |column: usize| rounded_number(matrix.0[4 * column + color]);
            format!(
                "{}·Y + {}·Cr + {}·Cb + {} with Y = {}, Cr = {}, Cb = {} and Y = {polynomial}",
                row(0),
                row(1),
                row(2),
                row(3),
                short_number(sum),
                raw[6],
                raw[7]
            )
        }
    }
}

/// Formats a number with all its digits, in parentheses if it is negative.
fn exact_number(value: f64) -> String {
    let format = |size: f64| format!("{size:?}").trim_end_matches(".0").to_owned();
    format_signed(value, format)
}

/// Formats a number with at most four decimal places, in parentheses if it is negative.
fn rounded_number(value: f64) -> String {
    format_signed(value, short_number)
}

fn format_signed(value: f64, format: impl Fn(f64) -> String) -> String {
    let digits = format(value.abs());
    match value < 0.0 {
        true => format!("(−{digits})"),
        false => digits,
    }
}

/// Formats a number with at most four decimal places.
fn short_number(value: f64) -> String {
    compare::format_short(value, 4)
}
