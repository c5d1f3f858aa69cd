//! §2.6 Color Matrix
//!
//! Sixteen numbers (clause 2.6/2) on one line, or four numbers or one number per line (ruling `lum-layout`).

use super::{output::Output, recipe::Numbers, spelling::Line};

pub fn write(matrix: &Numbers<16>, out: &mut Output) {
    for (i, line) in matrix.texts().chunks(out.spelling.matrix_line).enumerate() {
        if i > 0 {
            out.line_end(Line::Matrix);
        }
        out.numbers("2.6/2", "matrix", line);
    }
    out.line_end(Line::Matrix);
}
