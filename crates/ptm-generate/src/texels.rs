//! §2.7 Uncompressed Per Texel Data
//!
//! Blocks of bytes, bottom row first (§2.7.1, §2.7.2, §2.7.3).

use std::ops::Range;

use super::{model::Model, output::Output};
use ptm::Shape;

pub fn write(model: &Model, out: &mut Output) {
    match model.format.shape() {
        Shape::Rgb => {
            out.put("2.7.1/2", "red coefficients", &block(model, 0..6));
            out.put("2.7.1/2", "green coefficients", &block(model, 6..12));
            out.put("2.7.1/2", "blue coefficients", &block(model, 12..18));
        }
        Shape::Lum(()) => out.put("2.7.2/1", "coefficients, Cr and Cb", &block(model, 0..8)),
        Shape::Lrgb => {
            out.put("2.7.3/1", "coefficients", &block(model, 0..6));
            write_colors("2.7.3/2", model, out);
        }
    }
}

/// Writes R, G and B of every texel, for LRGB files and after the indices of `PTM_LUT` files (clause 2.8.1/4).
pub fn write_colors(clause: &'static str, model: &Model, out: &mut Output) {
    out.put(clause, "colors", &block(model, 6..9));
}

/// Returns the samples of these channels for every texel, from the bottom row to the top row.
fn block(model: &Model, channels: Range<usize>) -> Vec<u8> {
    let per_texel = model.format.channels();
    let row = model.size.width as usize * per_texel;
    let rows = model.samples.chunks(row).rev();
    rows.flat_map(|row| row.chunks(per_texel))
        .flat_map(|texel| &texel[channels.clone()])
        .copied()
        .collect()
}
