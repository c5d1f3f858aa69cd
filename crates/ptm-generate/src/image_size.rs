//! §2.3 Image Size
//!
//! One line or two (clauses 2.3/1–2).

use super::{output::Output, spelling::Line};
use ptm::Size;

pub fn write(size: Size, out: &mut Output) {
    out.token("2.3/1", "width", &size.width.to_string());
    out.line_end_or_gap(out.spelling.size_on_two_lines, Line::Width);
    out.token("2.3/1", "height", &size.height.to_string());
    out.line_end(Line::Height);
}
