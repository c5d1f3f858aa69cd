//! Decisions that an implementation of the chapter has to make.
//!
//! For each decision, [`Rules::SPEC`] contains the function that implements the requirement. The pipeline calls these functions
//! only through [`Rules`], so replacing one implements an alternative reading or a deliberate mistake.

use super::entry::{Boundary, Color, Entry, Matrix, SampleMethod, Table, Vector};
use super::map::{CellPair, Texel, TextureMap};
use super::no_value::NoValue;
use super::primitive::{
    Frequency, InteriorStyle, Interpolation, LitPrimitive, MapValue, Point, Selection, Shade, Site,
    Surface, Terms, VertexData,
};
use crate::evaluate::RelitImage;

/// Reading of the chapter: one function per decision, in the order of the chapter.
#[derive(Clone, Copy)]
#[allow(missing_docs)] // each field is documented at its function in SPEC
pub struct Rules {
    // table
    pub(crate) fallback_values: fn() -> Entry,
    pub(crate) is_valid_index: fn(i64) -> bool,
    pub(crate) undefined_entry: fn(&Table, &Rules) -> Entry,
    // selection
    pub(crate) uses_back: fn(&Surface) -> bool,
    pub(crate) is_textured: fn(InteriorStyle) -> bool,
    pub(crate) empty_list: fn() -> Selection,
    pub(crate) within_limit: fn(&[i64], usize) -> Vec<i64>,
    // the default map
    pub(crate) checkerboard: fn() -> (usize, usize),
    pub(crate) is_white: fn(usize, usize) -> bool,
    // parameterization
    pub(crate) parameterize: fn(&Entry, &Point, usize, &Rules) -> Result<Vector, NoValue>,
    pub(crate) normal: fn(&VertexData) -> Option<Vector>,
    pub(crate) spline_parameters: fn(&Point) -> Vector,
    pub(crate) float_data: fn(&Point, usize, usize) -> Result<Vector, NoValue>,
    pub(crate) vrc_vertex: fn(&Point) -> VertexData,
    pub(crate) wc_vertex: fn(&Point) -> VertexData,
    pub(crate) sight: fn(eye: Vector, position: Vector) -> Vector,
    pub(crate) reflect: fn(i: Vector, n: Vector) -> Vector,
    pub(crate) rotate: fn(&Matrix, Vector) -> Vector,
    pub(crate) vrc_azimuth: fn(Vector) -> f64,
    pub(crate) vrc_height: fn(Vector) -> f64,
    pub(crate) wc_azimuth: fn(Vector) -> f64,
    pub(crate) wc_height: fn(Vector) -> f64,
    // orientation, interpolation
    pub(crate) orient: fn(&Matrix, Vector) -> Vector,
    pub(crate) linear: fn(&[Vector], &[f64], &[f64]) -> Vector,
    pub(crate) hyperbolic: fn(&[Vector], &[f64], &[f64]) -> Vector,
    pub(crate) site: fn(Interpolation, Frequency) -> Site,
    // composition
    pub(crate) stage:
        fn(&[(Entry, MapValue)], &LitPrimitive, Interpolation, Frequency, &Rules) -> Shade,
    pub(crate) add_specular: fn(Shade, Color) -> Shade,
    pub(crate) light: fn(Shade, &LitPrimitive) -> Shade,
    pub(crate) texel_color: fn(&Texel) -> Color,
    pub(crate) gamma: fn(&Entry, &Texel) -> Color,
    pub(crate) replace: fn(&Terms) -> Shade,
    pub(crate) modulate: fn(&Terms) -> Shade,
    pub(crate) blend_env_color: fn(&Terms) -> Shade,
    pub(crate) decal: fn(&Terms) -> Shade,
    pub(crate) decal_background: fn(&Terms) -> Shade,
    // sampling
    pub(crate) is_magnified: fn(spans: &[f64], bias: f64) -> bool,
    pub(crate) method: fn(&Entry, magnify: bool) -> SampleMethod,
    pub(crate) closest: fn(Boundary, f64, usize, &Rules) -> usize,
    pub(crate) neighbors: fn(Boundary, f64, usize, &Rules) -> CellPair,
    pub(crate) corner_weights: fn(&[[f64; 2]; 3]) -> [f64; 8],
    pub(crate) offset: fn([usize; 3], [usize; 3]) -> usize,
    pub(crate) closest_level: fn(f64, usize) -> usize,
    pub(crate) levels: fn(f64, usize) -> (usize, usize, f64),
    // boundary conditions, clamp methods
    pub(crate) condition: fn(&Entry, usize) -> Boundary,
    pub(crate) is_clamped: fn(&Entry, Vector, usize, &Rules) -> bool,
    pub(crate) is_outside: fn(f64) -> bool,
    pub(crate) outside: fn(&Entry, &TextureMap, Vector, SampleMethod, &Rules) -> MapValue,
    pub(crate) clamp: fn(&Entry) -> MapValue,
    pub(crate) clamp_color: fn(&Entry, &Texel, Shade, Color, &Rules) -> Shade,
    pub(crate) wrap: fn(i64, usize) -> usize,
    pub(crate) mirror: fn(i64, usize) -> usize,
    pub(crate) border: fn(i64, usize) -> usize,
    // a PTM as a map
    pub(crate) rows: fn(&RelitImage) -> Vec<[f64; 3]>,
    pub(crate) to_eight_bits: fn(f64) -> f64,
}
