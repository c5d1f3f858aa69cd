#![doc = include_str!("../README.md")]
//!
//! # Format notes
//!
//! - The formulas of the chapter were images and are lost. The formulas here are reconstructed from its text and from
//!   related documents. `spec-cases/texture/rulings.yaml` states how certain each formula is, and [`Rules`] lists the decisions.
//! - Requirements are cited by their ids in `spec-cases/texture/clauses.yaml`, such as R-SMP-05.
//! - All arithmetic is in `f64`. No color is clamped to 0…1 (ruling `color-range`).
//! - The numeric values of the enumerants are not public, so only names are used. The chapter has two sets of names, and
//!   both are accepted.

mod error;
pub use error::Error;

mod no_value;
pub use no_value::NoValue;

// Types: table entries, maps and primitives.

pub(crate) mod entry;
pub use entry::{
    Boundary, Channel, ClampMethod, Color, Composition, Entry, Matrix, Parameterization,
    RenderingControl, SampleMethod, Table, Vector,
};

pub mod map;
pub use map::{Level, Texel, TexelKind, TextureMap};

pub mod primitive;
pub use primitive::{
    Correction, Frequency, InteriorStyle, Interpolation, LitPrimitive, MapValue, Point, Selection,
    Shade, Site, SplinePoint, Surface, VertexData,
};

// Decisions, and the stages of the pipeline in order.

mod rules;
pub use rules::Rules;

pub(crate) mod table;
pub use table::resolve;

pub(crate) mod checkerboard;

pub(crate) mod select;
pub use select::select;

pub mod parameterize;
pub use parameterize::{parameterize, reflect};

pub(crate) mod orient;
pub use orient::{interpolate, orient, site};

pub mod depth;
pub use depth::{Footprint, is_magnified, sample_depth};

pub mod boundary;
pub use boundary::texel_index;

mod precision;
pub use precision::{MAX_LEVEL_WEIGHT_ERROR, MAX_WEIGHT_ERROR, Tolerance, ToleratedSample};

pub mod sample;
pub use sample::{fetch, fetch_with_tolerance};

pub mod compose;
pub use compose::compose;

pub mod stage;
pub use stage::stage;

pub(crate) mod from_ptm;
pub use from_ptm::Rounding;

mod spec;

mod preview;
pub use preview::{Preview, PreviewShape, preview};
