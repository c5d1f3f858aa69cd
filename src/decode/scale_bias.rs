//! §2.4 Scale and Bias
//!
//! Six floating point scales, then six integer biases, separated by spaces (clauses 2.4/2–5); a
//! line end may stand between the scales and the biases (clause 2.4/6).
//!
//! ```text
//! 0.5 1 1 1 1 2          scales of a0 … a5
//! 128 0 0 0 0 -20        biases of a0 … a5
//!
//! a raw a0 of 130 means (130 − 128) · 0.5 = 1, a raw a5 of 10 means (10 − −20) · 2 = 60     (clause 2.4/8)
//! ```
//!
//! Format notes
//! - Scales come with exponents, signs and bare points; zero and negative ones are legal (ruling `numbers`).
//! - Biases below 0 and above 255 occur in real files. A whole number written `3.0` is read (ruling `odd-numbers`).
//! - In the uncompressed formats without a table this is the last line of the header. The payload starts right after its
//!   line feed, and its first byte may be 0x0A or 0x20: a reader that skips blanks here loses texels (ruling
//!   `header-line-end`).

use crate::error::Result;
use crate::input::Input;
use crate::ptm::ScaleBias;

pub(super) fn read(input: &mut Input) -> Result<ScaleBias> {
    let scale = six(input, |input| input.number("2.4/3", "a scale"))?;
    input.gap_or_line_end("2.4/6")?;
    // odd-numbers: read as a number and then required to be whole, so that "3.0" is read and "1.5" is not.
    let bias = six(input, |input| {
        let fraction = input.wrong("2.4/4", "an integer bias");
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

fn six(input: &mut Input, read: fn(&mut Input) -> Result<f64>) -> Result<[f64; 6]> {
    // Numbers of one kind are separated by spaces only; the one line end that is allowed is between the kinds.
    let mut values = [read(input)?, 0.0, 0.0, 0.0, 0.0, 0.0];
    for value in &mut values[1..] {
        input.gap("2.4/5")?;
        *value = read(input)?;
    }
    Ok(values)
}
