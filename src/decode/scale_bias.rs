//! §2.4 Scale and Bias
//!
//! Six floating point scales, then six integer biases, parted by spaces (clauses 2.4/2–5); a line end may stand between
//! the scales and the biases (clause 2.4/6).
//!
//! Format notes
//! - Scales come with exponents, signs and bare points; zero and negative ones are legal (ruling `numbers`).
//! - Biases below 0 and above 255 occur in real files. A whole number written `3.0` is read (ruling `odd-numbers`).

use super::Input;
use crate::error::Result;
use crate::ptm::ScaleBias;

pub(super) fn read(input: &mut Input) -> Result<ScaleBias> {
    let scale = six(input, |input| input.number("2.4/3", "a scale"))?;
    input.gap_or_line_end("2.4/6")?;
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
    let mut values = [read(input)?, 0.0, 0.0, 0.0, 0.0, 0.0];
    for value in &mut values[1..] {
        input.gap("2.4/5")?;
        *value = read(input)?;
    }
    Ok(values)
}
