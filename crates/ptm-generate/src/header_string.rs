//! §2.1 Header String

use super::{output::Output, spelling::Line};

pub fn write(out: &mut Output) {
    out.token("2.1/1", "version", "PTM_1.2");
    out.line_end(Line::Version);
}
