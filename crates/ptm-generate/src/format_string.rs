//! §2.2 Format String

use super::{output::Output, spelling::Line};
use ptm::Format;

pub fn write(format: Format, out: &mut Output) {
    out.token("2.2/1", "format", format.name());
    out.line_end(Line::Format);
}
