#![doc = include_str!("../README.md")]

mod error;

mod output;

/// §2.1 Header String
mod header_string;

/// §2.2 Format String
mod format_string;

/// §2.3 Image Size
mod image_size;

/// §2.4 Scale and Bias
mod scale_bias;

/// §2.5 Lookup Table
mod lookup_table;

/// §2.6 Color Matrix
mod color_matrix;

/// §2.7 Uncompressed Per Texel Data
mod texels;

/// §2.8 Lookup Table Indices
mod indices;

/// §2.9 Compressed Data
mod compressed;

/// §2.9.2–2.9.5 Transforms, Motion Vectors, Order, Reference Planes
mod predict;

/// §2.9.8 Compressed Coefficient Planes
pub mod planes;

/// Rewrites the headers of a stream in a different order or with a different component id.
mod headers;

/// Recipes for files: format, size, scene, numbers, spelling.
pub mod recipe;

/// Compression of planes: structure, transforms, motion, side information, streams.
pub mod plan;

/// All legal spellings of a header.
pub mod spelling;

/// Painted scenes.
pub mod scene;

/// Painting the samples of a scene.
mod paint;

/// Painted maps whose planes, coefficients and colors are known by construction.
pub mod model;

/// Damages: one fault at a time.
pub mod damage;

/// Places in a file, in the syntax of damages.
mod place;

/// Streams that replace streams in a file but have wrong properties.
mod stand_in;

pub use damage::Damage;
pub use error::{Error, Result};
pub use model::Model;
pub use output::GeneratedFile;
pub use plan::Compression;
pub use predict::{INVERSION, MOTION};
pub use recipe::{Numbers, Recipe};
pub use scene::Scene;
pub use spelling::Spelling;

use output::Output;
use ptm::{Shape, Storage};

/// Writes the file of `recipe` with the values of `model`.
#[must_use]
pub fn write(recipe: &Recipe, model: &Model) -> GeneratedFile {
    let mut out = Output::new(&recipe.spelling);
    write_header(recipe, &mut out);
    write_planes(recipe, model, &mut out);
    out.into_written()
}

/// Writes the header (2.1–2.4).
fn write_header(recipe: &Recipe, out: &mut Output) {
    header_string::write(out);
    format_string::write(recipe.format, out);
    image_size::write(recipe.size, out);
    scale_bias::write(&recipe.scale, &recipe.bias, out);
}

/// Writes the values (2.5–2.9).
fn write_planes(recipe: &Recipe, model: &Model, out: &mut Output) {
    if let Shape::Lum(()) = recipe.format.shape() {
        color_matrix::write(&recipe.matrix, out);
    }
    match recipe.format.storage() {
        Storage::Texels => texels::write(model, out),
        Storage::Table | Storage::ColorTable => {
            lookup_table::write(model, out);
            indices::write(model, out);
        }
        Storage::Streams(_) => compressed::write(model, out),
    }
}
