//! §2.4 Scale and Bias
//!
//! Six floating point scales, then six integer biases, separated by spaces (clauses 2.4/2–5). The scales and the
//! biases may be on separate lines (clause 2.4/6).
//!
//! ```text
//! 0.5 1 1 1 1 2          scales of a0 … a5
//! 128 0 0 0 0 -20        biases of a0 … a5
//!
//! a raw a0 of 130 means (130 − 128) · 0.5 = 1, a raw a5 of 10 means (10 − −20) · 2 = 60     (clause 2.4/8)
//! ```
//!
//! Format notes
//! - Scales may have exponents, signs, and leading or trailing decimal points. They may be zero or negative (ruling `numbers`).
//! - Biases below 0 and above 255 occur in real files. An integer written as `3.0` is accepted (ruling `odd-numbers`).
//! - In `RGB` and `LRGB`, the line that contains the biases is the last line of the header. The payload starts right after the
//!   line feed, and may itself start with 0x0A or 0x20. A decoder that skips whitespace here loses texels (ruling
//!   `header-line-end`).

use crate::error::Result;
use crate::input::Input;
use crate::types::ScaleBias;

pub(super) fn read(input: &mut Input) -> Result<ScaleBias> {
    let scale = read_six(input, |input| input.number("2.4/3", "a scale"))?;
    input.gap_or_line_end("2.4/6")?;
    // odd-numbers: parse a floating point number and require that it is an integer, so that "3.0" is accepted and "1.5" is not.
    let bias = read_six(input, |input| {
        let fraction = input.unexpected("2.4/4", "an integer bias");
        let value = input.number("2.4/4", "an integer bias")?;
        if value.fract() == 0.0 {
            Ok(value)
        } else {
            Err(fraction)
        }
    })?;
    input.line_end("2.0/2")?;
    Ok(ScaleBias { scale, bias })
}

/// Reads six numbers with `read`, separated by spaces (clause 2.4/5).
fn read_six(input: &mut Input, read: fn(&mut Input) -> Result<f64>) -> Result<[f64; 6]> {
    // A line end is allowed only between the scales and the biases.
    let mut values = [read(input)?, 0.0, 0.0, 0.0, 0.0, 0.0];
    for value in &mut values[1..] {
        input.gap("2.4/5")?;
        *value = read(input)?;
    }
    Ok(values)
}
