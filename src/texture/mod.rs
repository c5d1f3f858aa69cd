//! The texture mapping table of `PEXlib` 5.2: what a surface makes of a texture map.
//!
//! A PTM lit from one direction is a picture, and a picture is a texture map. This module says what the chapter "Texture
//! Mapping Table" does with it, as pure functions in the order of the pipeline, each a place where two implementations
//! can be compared:
//!
//! ```text
//! Surface ──select──→ indices ──resolve──→ Entry ──parameterize──→ t ──orient──→ t' ──interpolate──→ t''
//! t'', depth ──fetch──→ texel ──compose──→ color after map i ──stage──→ color of the primitive
//! ```
//!
//! ```
//! use ptm_conform::texture::{self, Entry, Rules, TextureMap};
//!
//! let fetched = texture::fetch(&Entry::default(), &TextureMap::checkerboard(&Rules::SPEC), [0.0; 3], 0.0, false, &Rules::SPEC);
//! assert_eq!(fetched.components(), Some(&[1.0, 1.0, 1.0][..]));
//! ```
//!
//! Format notes
//! - The chapter's formulas were pictures and are lost. What stands here for them is rebuilt from its words and from its
//!   relatives; `spec-cases/texture/rulings.yaml` says for each how sure that is, and [`Rules`] lists the decisions.
//! - Requirements are cited by their ids in `spec-cases/texture/clauses.yaml`, such as R-SMP-05.
//! - All arithmetic is in `f64`. No color is limited to 0…1 (ruling `color-range`).
//! - The numbers behind the enumerants are nowhere public; names are all that is used. The chapter has two sets of them,
//!   and both are understood.

mod no_value;
pub use no_value::NoValue;

// The nouns: an entry of the table, a map, and what is textured.

pub(crate) mod entry;
pub use entry::{
    Boundary, Channel, ClampMethod, Color, Composition, Entry, Matrix, Parameterization,
    RenderingControl, SampleMethod, Table, Vector,
};

pub(crate) mod map;
pub use map::{Level, Texel, TexelKind, TextureMap};

pub(crate) mod primitive;
pub use primitive::{
    Correction, Fetched, Frequency, InteriorStyle, Interpolation, Lit, Place, Point, Selection,
    Shade, Site, SplinePoint, Surface,
};

// The decisions, and the stages of the pipeline in its order.

mod rules;
pub use rules::Rules;

pub(crate) mod table;
pub use table::resolve;

pub(crate) mod checkerboard;

pub(crate) mod select;
pub use select::select;

pub(crate) mod parameterize;
pub use parameterize::{parameterize, reflect};

pub(crate) mod orient;
pub use orient::{interpolate, orient, site};

pub(crate) mod depth;
pub use depth::{Footprint, magnifies, sample_depth};

pub(crate) mod boundary;
pub use boundary::texel_index;

pub(crate) mod sample;
pub use sample::fetch;

pub(crate) mod compose;
pub use compose::compose;

pub(crate) mod stage;
pub use stage::stage;

pub(crate) mod from_ptm;
pub use from_ptm::Rounding;

mod spec;

mod preview;
pub use preview::{Preview, PreviewImage, PreviewShape, preview};
