//! §2.8 Lookup Table Indices
//!
//! One-byte indices for up to 256 entries, or two-byte indices, low byte first (2.8.1/2–3). The colors of `PTM_LUT` follow.

use super::{model::Model, output::Output, texels};
use ptm::Storage;

pub fn write(model: &Model, out: &mut Output) {
    let wide = model.entries() > 256;
    let mut bytes = Vec::new();
    for row in model.indices.chunks(model.size.width as usize).rev() {
        for &index in row {
            bytes.push((index % 256) as u8);
            if wide {
                bytes.push((index / 256) as u8);
            }
        }
    }
    out.put("2.8.1/1", "indices", &bytes);
    if model.format.storage() == Storage::Table {
        texels::write_colors("2.8.1/4", model, out);
    }
}
