//! §2.4 Scale and Bias
//!
//! Twelve numbers on one line or two (clauses 2.4/2–7), spelled as in the recipe.

use super::{output::Output, recipe::Numbers, spelling::Line};

pub fn write(scale: &Numbers<6>, bias: &Numbers<6>, out: &mut Output) {
    out.padded_numbers("2.4/3", "scale", &scale.texts());
    out.line_end_or_gap(out.spelling.scale_bias_on_two_lines, Line::Scale);
    out.padded_numbers("2.4/4", "bias", &bias.texts());
    out.line_end(Line::Bias);
}
