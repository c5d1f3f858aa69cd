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

pub(crate) mod entry;
pub use entry::{
    Boundary, Channel, ClampMethod, Composition, Entry, Matrix, Parameterization, RenderingControl,
    SampleMethod, Table, Vector, resolve,
};

pub(crate) mod map;
pub use map::{Color, Level, Texel, TexelKind, TextureMap};

pub(crate) mod select;
pub use select::{InteriorStyle, Selection, Surface, select};

pub(crate) mod parameterize;
pub use parameterize::{Place, Point, SplinePoint, parameterize, reflect};

pub(crate) mod orient;
pub use orient::{Correction, Frequency, Interpolation, Site, interpolate, orient, site};

pub(crate) mod depth;
pub use depth::{Footprint, magnifies, sample_depth};

pub(crate) mod boundary;
pub use boundary::texel_index;

pub(crate) mod sample;
pub use sample::{Fetched, fetch};

pub(crate) mod compose;
pub use compose::{Shade, compose};

pub(crate) mod stage;
pub use stage::{Lit, stage};

pub(crate) mod from_ptm;
pub use from_ptm::Rounding;

mod rules;
pub use rules::Rules;

mod picture;
pub use picture::{Picture, Scene, Shape, picture};
/// Why there is no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoValue {
    /// The chapter leaves it to the implementation; the ruling that says so.
    ImplementationDefined(&'static str),
    /// The question is beyond the valid range; a short name of what is.
    OutOfRange(&'static str),
    /// Something is missing that the method needs.
    Missing(&'static str),
}

impl std::fmt::Display for NoValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            NoValue::ImplementationDefined(ruling) => {
                write!(f, "left to the implementation (ruling {ruling})")
            }
            NoValue::OutOfRange(what) => write!(f, "out of range: {what}"),
            NoValue::Missing(what) => write!(f, "the method needs {what}"),
        }
    }
}

impl std::error::Error for NoValue {}
